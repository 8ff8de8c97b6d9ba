#pragma once

#include <ctime>

namespace [[gnu::visibility("default")]] highwall {

// Returns a clock of processor time [s], user and system time together.
inline double ProcessorSecondsOf(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Returns the processor time of the calling thread since it began [s].
inline double ThreadProcessorSeconds() {
  return ProcessorSecondsOf(CLOCK_THREAD_CPUTIME_ID);
}

// Returns the processor time of all threads of the process since it began [s].
inline double ProcessProcessorSeconds() {
  return ProcessorSecondsOf(CLOCK_PROCESS_CPUTIME_ID);
}

}  // namespace highwall
