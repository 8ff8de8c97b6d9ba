#include "features/corner_refinement.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <opencv2/core/hal/intrin.hpp>

namespace highwall::internal {
namespace {

// The 16 pixels on the circle of radius 3 around a corner, in order.
constexpr std::array<std::array<int, 2>, 16> kCircle = {{{0, 3},
                                                         {1, 3},
                                                         {2, 2},
                                                         {3, 1},
                                                         {3, 0},
                                                         {3, -1},
                                                         {2, -2},
                                                         {1, -3},
                                                         {0, -3},
                                                         {-1, -3},
                                                         {-2, -2},
                                                         {-3, -1},
                                                         {-3, 0},
                                                         {-3, 1},
                                                         {-2, 2},
                                                         {-1, 3}}};

using CircleOffsets = std::array<std::ptrdiff_t, kCircle.size()>;

CircleOffsets OffsetsInMemory(std::ptrdiff_t stride) {
  CircleOffsets offsets{};
  for (std::size_t i = 0; i < kCircle.size(); ++i) {
    offsets[i] = kCircle[i][0] + kCircle[i][1] * stride;
  }
  return offsets;
}

// 16 values around the circle in two registers.
struct Ring {
  cv::v_int16x8 a, b;
};

// Rotates the ring by k places.
template <int k>
Ring Turned(const Ring& ring) {
  return {cv::v_extract<k>(ring.a, ring.b), cv::v_extract<k>(ring.b, ring.a)};
}

Ring Min(const Ring& x, const Ring& y) {
  return {cv::v_min(x.a, y.a), cv::v_min(x.b, y.b)};
}

Ring Max(const Ring& x, const Ring& y) {
  return {cv::v_max(x.a, y.a), cv::v_max(x.b, y.b)};
}

// Returns the largest contrast that some arc of 9 pixels has throughout, brighter or darker than
// the centre; 0 if there is none (Rosten, Drummond 2006). The extrema over arcs of 2, 4, 8 and 9
// pixels are each computed from the previous ones.
int FastScore(const std::uint8_t* centre, const CircleOffsets& circle) {
  alignas(16) std::array<std::int16_t, 16> difference;
  for (std::size_t i = 0; i < circle.size(); ++i) {
    difference[i] = static_cast<std::int16_t>(centre[circle[i]] - *centre);
  }
  const Ring ring = {cv::v_load_aligned(difference.data()), cv::v_load_aligned(&difference[8])};
  const Ring ninth = {ring.b, ring.a};
  Ring low = Min(ring, Turned<1>(ring)), high = Max(ring, Turned<1>(ring));
  low = Min(low, Turned<2>(low));
  high = Max(high, Turned<2>(high));
  low = Min(Min(low, Turned<4>(low)), ninth);
  high = Max(Max(high, Turned<4>(high)), ninth);
  const int brighter = cv::v_reduce_max(cv::v_max(low.a, low.b));
  const int darker = -cv::v_reduce_min(cv::v_min(high.a, high.b));
  return std::max({brighter, darker, 0});
}

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
  const CircleOffsets circle = OffsetsInMemory(stride);
  const std::uint8_t* centre = gray.ptr<std::uint8_t>(y) + x;
  const int score = FastScore(centre, circle);
  return {
      ParabolaPeak(FastScore(centre - 1, circle), score, FastScore(centre + 1, circle)),
      ParabolaPeak(FastScore(centre - stride, circle), score, FastScore(centre + stride, circle))};
}

}  // namespace highwall::internal
