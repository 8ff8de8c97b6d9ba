#include "features/corner_refinement.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "features/fast_score.h"

namespace highwall::internal {
namespace {

// Returns the peak of the parabola through (-1, before), (0, peak), (1, after), within half a step.
float ParabolaPeak(int before, int peak, int after) {
  const int curvature = before - 2 * peak + after;
  if (curvature >= 0) return 0.0F;
  const float offset = 0.5F * static_cast<float>(before - after) / static_cast<float>(curvature);
  return std::clamp(offset, -0.5F, 0.5F);
}

}  // namespace

cv::Point2f RefineCorner(const cv::Mat& gray, int x, int y) {
  const auto stride = static_cast<std::ptrdiff_t>(gray.step[0]);
  const FastCircle circle(stride);
  const std::uint8_t* centre = gray.ptr<std::uint8_t>(y) + x;
  const int score = FastScore(centre, circle);
  return {
      ParabolaPeak(FastScore(centre - 1, circle), score, FastScore(centre + 1, circle)),
      ParabolaPeak(FastScore(centre - stride, circle), score, FastScore(centre + stride, circle))};
}

}  // namespace highwall::internal
