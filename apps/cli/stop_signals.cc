#include "cli/stop_signals.h"

#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace highwall::apps {
namespace {

constexpr std::array<int, 3> kStopSignals = {SIGINT, SIGTERM, SIGHUP};
// timeout(1) and a closed terminal send their signal twice, to the process and to its group.
constexpr std::int64_t kOneRequest = 100'000'000;  // [ns]

struct Caught {
  std::atomic<int> signal{0};
  std::atomic<std::int64_t> time{0};  // [ns] since boot
};
static_assert(std::atomic<int>::is_always_lock_free &&
              std::atomic<std::int64_t>::is_always_lock_free);  // required in signal handlers

// State accessible to the signal handler.
Caught& TheCaught() {
  static constinit Caught caught;
  return caught;
}

// Calls only async-signal-safe functions.
void Catch(int signal) {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t time = std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
  std::int64_t first = 0;
  if (TheCaught().time.compare_exchange_strong(first, time)) {
    TheCaught().signal = signal;
  } else if (time - first >= kOneRequest) {
    ::_exit(ExitCodeOf(signal));
  }
}

}  // namespace

StopSignals::StopSignals() {
  TheCaught().signal = 0;
  TheCaught().time = 0;
  struct sigaction action {};
  action.sa_handler = Catch;
  action.sa_flags = SA_RESTART;  // restarts interrupted system calls
  ::sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < before_.size(); ++i) {
    struct sigaction& before = before_[i];
    ::sigaction(kStopSignals[i], nullptr, &before);
    if (kStopSignals[i] == SIGHUP && before.sa_handler == SIG_IGN) continue;
    ::sigaction(kStopSignals[i], &action, nullptr);
  }
}

StopSignals::~StopSignals() {
  for (std::size_t i = 0; i < before_.size(); ++i) {
    ::sigaction(kStopSignals[i], &before_[i], nullptr);
  }
}

int StopSignals::caught() const {
  return TheCaught().signal;
}

std::string SignalName(int signal) {
  switch (signal) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    case SIGHUP:
      return "SIGHUP";
    default:
      return "signal " + std::to_string(signal);
  }
}

int ExitCodeOf(int signal) {
  return 128 + signal;
}

}  // namespace highwall::apps
