#include "square_suppression.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace highwall::internal {
namespace {

// Cells of half a radius: a survivor covers its own cell and two more to each side.
constexpr int kReach = 2;
constexpr int kBisections = 8;

class SquareSuppression {
 public:
  SquareSuppression(const std::vector<cv::KeyPoint>& sorted, int count, const cv::Rect& area)
      : sorted_(sorted), count_(static_cast<std::size_t>(count)), area_(area) {}

  // Indices of the first `count` survivors.
  const std::vector<int>& Survivors(float radius) {
    const float per_cell = static_cast<float>(kReach) / radius;
    // A margin of kReach cells all round saves the clipping.
    const int columns =
        2 * kReach + 1 + static_cast<int>(static_cast<float>(area_.width) * per_cell);
    const int rows = 2 * kReach + 1 + static_cast<int>(static_cast<float>(area_.height) * per_cell);
    covered_.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
    survivors_.clear();
    for (std::size_t i = 0; i < sorted_.size() && survivors_.size() < count_; ++i) {
      const int x = static_cast<int>((sorted_[i].pt.x - static_cast<float>(area_.x)) * per_cell);
      const int y = static_cast<int>((sorted_[i].pt.y - static_cast<float>(area_.y)) * per_cell);
      std::uint8_t* corner = covered_.data() + y * columns + x;
      if (corner[kReach * columns + kReach] != 0) continue;
      survivors_.push_back(static_cast<int>(i));
      for (int dy = 0; dy <= 2 * kReach; ++dy, corner += columns) {
        std::fill_n(corner, 2 * kReach + 1, std::uint8_t{1});
      }
    }
    return survivors_;
  }

 private:
  const std::vector<cv::KeyPoint>& sorted_;
  const std::size_t count_;
  const cv::Rect area_;
  std::vector<std::uint8_t> covered_;
  std::vector<int> survivors_;
};

}  // namespace

std::vector<cv::KeyPoint> SelectEvenly(std::vector<cv::KeyPoint> keypoints, int count,
                                       const cv::Rect& area) {
  if (count <= 0) return {};
  std::sort(keypoints.begin(), keypoints.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    if (a.response != b.response) return a.response > b.response;
    if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
    return a.pt.x < b.pt.x;
  });
  if (keypoints.size() <= static_cast<std::size_t>(count)) return keypoints;

  SquareSuppression suppression(keypoints, count, area);
  // One square per keypoint fills the area at `high`: no larger radius can leave so many.
  float low = 1.0F;
  float high = 2.0F + 2.0F * std::sqrt(static_cast<float>(area.area()) / static_cast<float>(count));
  std::vector<int> best = suppression.Survivors(low);
  for (int i = 0; i < kBisections; ++i) {
    const float radius = 0.5F * (low + high);
    const std::vector<int>& survivors = suppression.Survivors(radius);
    if (survivors.size() >= best.size()) {
      best = survivors;
      low = radius;
    } else {
      high = radius;
    }
  }
  std::vector<cv::KeyPoint> selected;
  selected.reserve(best.size());
  for (const int i : best) selected.push_back(keypoints[static_cast<std::size_t>(i)]);
  return selected;
}

}  // namespace highwall::internal
