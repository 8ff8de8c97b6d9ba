#include "features/fast_corners.h"

#include <array>
#include <bit>
#include <cstddef>

#include <opencv2/core/hal/intrin.hpp>

#include "features/fast_score.h"

namespace highwall::internal {
namespace {

// Places on the circle that any arc of 9 pixels contains two adjacent ones of.
constexpr std::array<std::size_t, 4> kCompass{0, 4, 8, 12};

// Returns whether two adjacent compass points are brighter, or darker, than the centre by more than
// the threshold.
bool MayBeCorner(const std::uint8_t* centre, const FastCircle& circle, int threshold) {
  std::array<bool, 4> brighter{}, darker{};
  for (std::size_t i = 0; i < 4; ++i) {
    const int difference = centre[circle.offsets[kCompass[i]]] - *centre;
    brighter[i] = difference > threshold;
    darker[i] = difference < -threshold;
  }
  bool any = false;
  for (std::size_t i = 0; i < 4; ++i) {
    any |= (brighter[i] && brighter[(i + 1) % 4]) || (darker[i] && darker[(i + 1) % 4]);
  }
  return any;
}

// Returns MayBeCorner() of 16 pixels, a bit each, the first the lowest.
unsigned MayBeCorners(const std::uint8_t* centre, const FastCircle& circle, int threshold) {
  const cv::v_uint8x16 value = cv::v_load(centre);
  const cv::v_uint8x16 step = cv::v_setall_u8(static_cast<std::uint8_t>(threshold));
  const cv::v_uint8x16 above = value + step, below = value - step;  // both saturate
  std::array<cv::v_uint8x16, 4> brighter, darker;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::v_uint8x16 other = cv::v_load(centre + circle.offsets[kCompass[i]]);
    brighter[i] = other > above;
    darker[i] = other < below;
  }
  cv::v_uint8x16 any = cv::v_setzero_u8();
  for (std::size_t i = 0; i < 4; ++i) {
    any = any | (brighter[i] & brighter[(i + 1) % 4]) | (darker[i] & darker[(i + 1) % 4]);
  }
  return static_cast<unsigned>(cv::v_signmask(any));
}

}  // namespace

void FastCorners::Append(const cv::Mat& image, const cv::Rect& area, int threshold,
                         std::vector<cv::KeyPoint>* corners) {
  constexpr int kLanes = 16;
  const FastCircle circle(static_cast<std::ptrdiff_t>(image.step[0]));
  const auto width = static_cast<std::size_t>(area.width) + 2;
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y + 1) * width + static_cast<std::size_t>(x + 1);
  };
  scores_.assign(width * (static_cast<std::size_t>(area.height) + 2), 0);
  for (int y = 0; y < area.height; ++y) {
    const auto* row = image.ptr<std::uint8_t>(area.y + y) + area.x;
    const auto score = [&](int x) {
      // OpenCV's score is the highest threshold with which the pixel is still a corner.
      const int contrast = FastScore(row + x, circle);
      if (contrast > threshold) scores_[at(x, y)] = static_cast<std::uint8_t>(contrast - 1);
    };
    int x = 0;
    for (; x + kLanes <= area.width; x += kLanes) {
      for (unsigned left = MayBeCorners(row + x, circle, threshold); left != 0; left &= left - 1) {
        score(x + std::countr_zero(left));
      }
    }
    for (; x < area.width; ++x) {
      if (MayBeCorner(row + x, circle, threshold)) score(x);
    }
  }
  for (int y = 0; y < area.height; ++y) {
    for (int x = 0; x < area.width; ++x) {
      const std::uint8_t score = scores_[at(x, y)];
      if (score == 0) continue;
      const auto beaten = [&](int row) {
        const std::uint8_t* around = &scores_[at(x - 1, row)];
        return around[0] >= score || around[2] >= score || (row != y && around[1] >= score);
      };
      if (beaten(y - 1) || beaten(y) || beaten(y + 1)) continue;
      corners->emplace_back(static_cast<float>(area.x + x), static_cast<float>(area.y + y), 7.0F,
                            -1.0F, static_cast<float>(score));
    }
  }
}

}  // namespace highwall::internal
