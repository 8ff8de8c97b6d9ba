#include "inertial/clock_check.h"

#include <cmath>

namespace highwall {

bool ClockCheck::Update(Stamp image, double off, double sigma) {
  constexpr double kTolerated = 0.03;  // [s]
  constexpr double kSigmas = 5.0;      // exceeded once in a million
  constexpr double kLasting = 1.0;     // [s]: the estimate takes some images to settle
  if (is_reported_) return false;
  if (!(std::abs(off) > kTolerated + kSigmas * sigma)) {  // not a number: unknown
    off_since_.reset();
    return false;
  }
  if (!off_since_) off_since_ = image;
  is_reported_ = ToSeconds(image - *off_since_) >= kLasting;
  return is_reported_;
}

}  // namespace highwall
