#include "system/frame_clock.h"

#include <algorithm>
#include <utility>

#include <highwall/internal/median.h>

namespace highwall {

void FrameClock::Add(Stamp stamp) {
  constexpr std::size_t kIntervals = 31;  // a second of a camera: pauses are fewer than half
  constexpr std::size_t kFewest = 9;      // before that, a pause may be among few
  constexpr double kSlowest = 1.0;        // [s] interval that no camera exceeds
  constexpr double kUsual = 1.0 / 30.0;   // [s]
  constexpr double kTolerance = 1e-3;     // [s] of stamps with few decimals
  const std::optional<Stamp> last = std::exchange(last_, stamp);
  if (!last) return;
  if (intervals_.size() < kIntervals) intervals_.push_back(0);
  intervals_[next_] = stamp - *last;
  next_ = (next_ + 1) % kIntervals;
  if (intervals_.size() < kFewest) return;
  const double median = ToSeconds(UpperMedian(intervals_));
  scale_ = median >= kSlowest - kTolerance ? kUsual / median : 1.0;
}

}  // namespace highwall
