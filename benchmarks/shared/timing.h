#pragma once

#include <ctime>

#include <highwall/internal/stopwatch.h>

namespace highwall::bench {

// Returns the wall time of `work` [s].
template <typename Work>
double WallSeconds(const Work& work) {
  const Stopwatch stopwatch;
  work();
  return stopwatch.Seconds();
}

// Returns the processor time of `work` in the calling thread [s].
template <typename Work>
double ThreadSeconds(const Work& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

}  // namespace highwall::bench
