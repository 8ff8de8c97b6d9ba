#include <highwall/frontend/input/depth_stamp.h>

#include <cmath>

#include <highwall/core/stamp.h>

namespace highwall {

double DepthDelay(const RgbdImage& image) {
  constexpr double kLongest = 0.1;
  const Stamp stamp = image.depth_stamp.value_or(image.stamp);
  if (stamp > kMaxStamp || stamp < -kMaxStamp) return 0.0;
  const double delay = ToSeconds(stamp - image.stamp);
  return std::abs(delay) <= kLongest ? delay : 0.0;
}

}  // namespace highwall
