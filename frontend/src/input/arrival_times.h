#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>

#include <highwall/core/stamp.h>

namespace highwall {

// When the images arrived that wait in a queue. Not for several threads at once.
class ArrivalTimes {
 public:
  using Clock = std::chrono::steady_clock;

  // most: arrivals that are kept; the oldest are forgotten.
  explicit ArrivalTimes(std::size_t most) : most_(most) {}

  void Add(Stamp stamp, Clock::time_point time) {
    arrivals_.push_back({stamp, time});
    if (arrivals_.size() > most_) arrivals_.pop_front();
  }

  // Returns when the image of this stamp arrived, nothing if that is forgotten, and forgets the
  // images before it, which were dropped.
  std::optional<Clock::time_point> Take(Stamp stamp) {
    while (!arrivals_.empty() && arrivals_.front().stamp < stamp) arrivals_.pop_front();
    if (arrivals_.empty() || arrivals_.front().stamp != stamp) return std::nullopt;
    const Clock::time_point time = arrivals_.front().time;
    arrivals_.pop_front();
    return time;
  }

 private:
  struct Arrival {
    Stamp stamp = 0;
    Clock::time_point time{};
  };

  std::size_t most_;
  std::deque<Arrival> arrivals_;
};

}  // namespace highwall
