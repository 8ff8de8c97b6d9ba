#pragma once

#include <highwall/internal/processor_time.h>
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
  const double start = ThreadProcessorSeconds();
  work();
  return ThreadProcessorSeconds() - start;
}

}  // namespace highwall::bench
