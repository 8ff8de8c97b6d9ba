#pragma once

#include <algorithm>
#include <chrono>

namespace highwall::apps {

// Limits how often something is done, and to a share of the time. Not thread-safe.
class Turn {
 public:
  // period: at least between two times.
  explicit Turn(std::chrono::nanoseconds period) : period_(period) {}

  // Does the work if its turn has come.
  template <class Work>
  void Do(const Work& work) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begin = Clock::now();
    if (begin < next_) return;
    work();
    const Clock::duration took = Clock::now() - begin;
    next_ = begin + std::max<Clock::duration>(period_, kShare * took);
  }

 private:
  static constexpr int kShare = 50;

  const std::chrono::nanoseconds period_;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace highwall::apps
