#pragma once

#include <signal.h>

#include <array>
#include <stdexcept>
#include <string>

namespace highwall::apps {

// During its lifetime, the first SIGINT (Ctrl-C), SIGTERM (kill, a scheduler) or SIGHUP (closed
// terminal) is only recorded, and the program checks for it where it can end in order. A second
// signal ends the process immediately, with the exit code of that signal. Use one instance at a
// time: handlers are process-wide. An ignored SIGHUP (nohup) stays ignored.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();  // restores the previous handlers
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // Returns the number of the caught signal; 0: none.
  int caught() const;

 private:
  std::array<struct sigaction, 3> before_;  // of each signal
};

// Returns a name such as "SIGINT".
std::string SignalName(int signal);
// Thrown when a signal ended the work in order: part of it is done.
class StoppedBySignal : public std::runtime_error {
 public:
  explicit StoppedBySignal(int signal)
      : std::runtime_error("stopped by " + SignalName(signal) + ": the results so far are kept"),
        signal_(signal) {}
  int signal() const { return signal_; }

 private:
  int signal_;
};
// Returns the exit code by which a shell reports a program ended by a signal: 130, 143, 129.
int ExitCodeOf(int signal);

}  // namespace highwall::apps
