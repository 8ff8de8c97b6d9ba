#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <opencv2/core/hal/intrin.hpp>

namespace highwall::internal {

// The circle of FAST, as offsets in an image.
struct FastCircle {
  // The 16 pixels on the circle of radius 3 around a corner, in order: x, y.
  static constexpr std::array<std::array<int, 2>, 16> kPixels = {{{0, 3},
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

  // stride: bytes from one row of the CV_8UC1 image to the next.
  explicit FastCircle(std::ptrdiff_t stride) {
    for (std::size_t i = 0; i < kPixels.size(); ++i) {
      offsets[i] = kPixels[i][0] + kPixels[i][1] * stride;
    }
  }

  std::array<std::ptrdiff_t, kPixels.size()> offsets{};
};

namespace fast {

// 16 values around the circle in two registers.
struct Ring {
  cv::v_int16x8 a, b;
};

// Rotates the ring by k places.
template <int k>
Ring Turned(const Ring& ring) {
  return {cv::v_extract<k>(ring.a, ring.b), cv::v_extract<k>(ring.b, ring.a)};
}

inline Ring Min(const Ring& x, const Ring& y) {
  return {cv::v_min(x.a, y.a), cv::v_min(x.b, y.b)};
}

inline Ring Max(const Ring& x, const Ring& y) {
  return {cv::v_max(x.a, y.a), cv::v_max(x.b, y.b)};
}

}  // namespace fast

// Returns the largest contrast that some arc of 9 pixels has throughout, brighter or darker than
// the centre; 0 if there is none (Rosten, Drummond 2006). The extrema over arcs of 2, 4, 8 and 9
// pixels are each computed from the previous ones.
inline int FastScore(const std::uint8_t* centre, const FastCircle& circle) {
  alignas(16) std::array<std::int16_t, 16> difference;
  for (std::size_t i = 0; i < difference.size(); ++i) {
    difference[i] = static_cast<std::int16_t>(centre[circle.offsets[i]] - *centre);
  }
  const fast::Ring ring = {cv::v_load_aligned(difference.data()),
                           cv::v_load_aligned(&difference[8])};
  const fast::Ring ninth = {ring.b, ring.a};
  fast::Ring low = Min(ring, fast::Turned<1>(ring)), high = Max(ring, fast::Turned<1>(ring));
  low = Min(low, fast::Turned<2>(low));
  high = Max(high, fast::Turned<2>(high));
  low = Min(Min(low, fast::Turned<4>(low)), ninth);
  high = Max(Max(high, fast::Turned<4>(high)), ninth);
  const int brighter = cv::v_reduce_max(cv::v_max(low.a, low.b));
  const int darker = -cv::v_reduce_min(cv::v_min(high.a, high.b));
  return std::max({brighter, darker, 0});
}

}  // namespace highwall::internal
