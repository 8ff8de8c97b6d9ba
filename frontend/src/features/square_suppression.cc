#include "features/square_suppression.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace highwall::internal {
namespace {

// Cells of half a radius: a survivor covers its own cell and two more on each side.
constexpr int kReach = 2;
constexpr float kRadiusTolerance = 0.5F;  // [px]

// A keypoint packed into one integer, in order of preference: the larger response, then the upper,
// then the left one. Bit patterns of non-negative floats sort like their values.
using Key = std::uint64_t;

Key Pack(const cv::KeyPoint& keypoint) {
  const std::uint32_t response = std::bit_cast<std::uint32_t>(keypoint.response);
  return (Key{~response} << 32) | (static_cast<Key>(keypoint.pt.y) << 16) |
         static_cast<Key>(keypoint.pt.x);
}

int X(Key key) {
  return static_cast<int>(key & 0xFFFF);
}

int Y(Key key) {
  return static_cast<int>((key >> 16) & 0xFFFF);
}

cv::KeyPoint Unpack(Key key) {
  const auto response = std::bit_cast<float>(static_cast<std::uint32_t>(~(key >> 32)));
  return {cv::Point2f(static_cast<float>(X(key)), static_cast<float>(Y(key))), 0.0F, -1.0F,
          response};
}

class SquareSuppression {
 public:
  SquareSuppression(const std::vector<Key>& sorted, int count, const cv::Rect& area)
      : sorted_(sorted), count_(static_cast<std::size_t>(count)), area_(area) {
    survivors_.reserve(count_);
  }

  // Returns the first `count` survivors.
  const std::vector<Key>& Survivors(float radius) {
    const float per_cell = static_cast<float>(kReach) / radius;
    // A margin of kReach cells on all sides avoids clipping.
    const int columns =
        2 * kReach + 1 + static_cast<int>(static_cast<float>(area_.width) * per_cell);
    const int rows = 2 * kReach + 1 + static_cast<int>(static_cast<float>(area_.height) * per_cell);
    covered_.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
    survivors_.clear();
    for (const Key key : sorted_) {
      if (survivors_.size() == count_) break;
      const int x = static_cast<int>(static_cast<float>(X(key) - area_.x) * per_cell);
      const int y = static_cast<int>(static_cast<float>(Y(key) - area_.y) * per_cell);
      std::uint8_t* corner = covered_.data() + y * columns + x;
      if (corner[kReach * columns + kReach] != 0) continue;
      survivors_.push_back(key);
      for (int dy = 0; dy <= 2 * kReach; ++dy, corner += columns) {
        std::fill_n(corner, 2 * kReach + 1, std::uint8_t{1});
      }
    }
    return survivors_;
  }

 private:
  const std::vector<Key>& sorted_;
  const std::size_t count_;
  const cv::Rect area_;
  std::vector<std::uint8_t> covered_;
  std::vector<Key> survivors_;
};

}  // namespace

std::vector<cv::KeyPoint> SelectEvenly(const std::vector<cv::KeyPoint>& keypoints, int count,
                                       const cv::Rect& area) {
  if (count <= 0) return {};
  std::vector<Key> keys(keypoints.size());
  std::transform(keypoints.begin(), keypoints.end(), keys.begin(), Pack);
  std::sort(keys.begin(), keys.end());

  if (keys.size() > static_cast<std::size_t>(count)) {
    SquareSuppression suppression(keys, count, area);
    // At `high` one square per keypoint fills the area: no larger radius can leave so many.
    float low = 1.0F;
    float high =
        2.0F + 2.0F * std::sqrt(static_cast<float>(area.area()) / static_cast<float>(count));
    std::vector<Key> best = suppression.Survivors(low);
    while (high - low > kRadiusTolerance) {
      const float radius = 0.5F * (low + high);
      const std::vector<Key>& survivors = suppression.Survivors(radius);
      if (survivors.size() >= best.size()) {
        best = survivors;
        low = radius;
      } else {
        high = radius;
      }
    }
    keys = std::move(best);
  }
  std::vector<cv::KeyPoint> selected(keys.size());
  std::transform(keys.begin(), keys.end(), selected.begin(), Unpack);
  return selected;
}

}  // namespace highwall::internal
