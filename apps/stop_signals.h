#pragma once

#include <signal.h>

#include <array>
#include <stdexcept>
#include <string>

namespace highwall::apps {

// While it lives, the first SIGINT (Ctrl-C), SIGTERM (kill, a scheduler) or SIGHUP (the terminal
// was closed) ends nothing, but is remembered: the program looks at it where it can end in order. A
// second one ends the process at once, with the exit code of that signal. For programs, one at a
// time: handlers belong to all of the process. A SIGHUP that was ignored (nohup) stays so.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();  // as before
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // The number of the signal that came; 0: none.
  int caught() const;

 private:
  std::array<struct sigaction, 3> before_;  // of each of them
};

// "SIGINT".
std::string SignalName(int signal);
// What a program throws that one has ended in order: what it was asked to do is done in part.
class StoppedBySignal : public std::runtime_error {
 public:
  explicit StoppedBySignal(int signal)
      : std::runtime_error("stopped by " + SignalName(signal) + ": what was done is kept"),
        signal_(signal) {}
  int signal() const { return signal_; }

 private:
  int signal_;
};
// What a shell says of a program that a signal has ended: 130, 143, 129.
int ExitCodeOf(int signal);

}  // namespace highwall::apps
