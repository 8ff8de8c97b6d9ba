#pragma once

#include <optional>

#include <highwall/core/stamp.h>

namespace highwall {

// Tests whether the clocks of the IMU and the images are apart by another time than stated, by an
// online estimate.
class ClockCheck {
 public:
  // image: [ns] its stamp, ascending. off: [s] by which the estimate differs from what is stated,
  // with its standard deviation sigma [s]. Returns true once: where the difference has been beyond
  // what is tolerated for a second.
  bool Update(Stamp image, double off, double sigma);
  // There is no estimate at this image.
  void Interrupt() { off_since_.reset(); }

 private:
  std::optional<Stamp> off_since_;
  bool is_reported_ = false;
};

}  // namespace highwall
