#include <highwall/frontend/features/frame.h>

#include <algorithm>
#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

FeatureGrid::FeatureGrid(const std::vector<cv::KeyPoint>& keypoints, const cv::Size& image_size,
                         double cell_size)
    : cell_size_(cell_size) {
  HIGHWALL_REQUIRE(image_size.width > 0 && image_size.height > 0,
                   "FeatureGrid: the image must not be empty");
  HIGHWALL_REQUIRE(std::isfinite(cell_size) && cell_size > 0.0,
                   "FeatureGrid: cell_size must be positive");
  columns_ = static_cast<int>(std::ceil(image_size.width / cell_size));
  rows_ = static_cast<int>(std::ceil(image_size.height / cell_size));
  cell_begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  std::vector<std::size_t> cells;
  cells.reserve(keypoints.size());
  for (const cv::KeyPoint& keypoint : keypoints) {
    HIGHWALL_REQUIRE(std::isfinite(keypoint.pt.x) && std::isfinite(keypoint.pt.y),
                     "FeatureGrid: the keypoints must be finite");
    const int cell = Row(keypoint.pt.y) * columns_ + Column(keypoint.pt.x);
    cells.push_back(static_cast<std::size_t>(cell));
    ++cell_begin_[cells.back() + 1];
  }
  for (std::size_t i = 1; i < cell_begin_.size(); ++i) cell_begin_[i] += cell_begin_[i - 1];
  std::vector<int> next(cell_begin_.begin(), cell_begin_.end() - 1);
  entries_.resize(keypoints.size());
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const cv::KeyPoint& keypoint = keypoints[i];
    entries_[static_cast<std::size_t>(next[cells[i]]++)] = {keypoint.pt.x, keypoint.pt.y,
                                                            keypoint.octave, static_cast<int>(i)};
  }
}

std::vector<int> FeatureGrid::Query(const Eigen::Vector2d& centre, double radius, int min_octave,
                                    int max_octave) const {
  std::vector<int> indices;
  Query(centre, radius, min_octave, max_octave, &indices);
  return indices;
}

void FeatureGrid::Query(const Eigen::Vector2d& centre, double radius, int min_octave,
                        int max_octave, std::vector<int>* indices) const {
  indices->clear();
  if (entries_.empty() || !(radius >= 0.0) || !centre.allFinite()) return;
  const int first_column = Column(centre.x() - radius), last_column = Column(centre.x() + radius);
  const int first_row = Row(centre.y() - radius), last_row = Row(centre.y() + radius);
  for (int row = first_row; row <= last_row; ++row) {
    // The cells of a row are contiguous in memory.
    const auto first = static_cast<std::size_t>(row * columns_ + first_column);
    const auto last = static_cast<std::size_t>(row * columns_ + last_column);
    for (int i = cell_begin_[first]; i < cell_begin_[last + 1]; ++i) {
      const Entry& entry = entries_[static_cast<std::size_t>(i)];
      if (entry.octave < min_octave || entry.octave > max_octave) continue;
      const double dx = entry.x - centre.x(), dy = entry.y - centre.y();
      if (dx * dx + dy * dy <= radius * radius) indices->push_back(entry.index);
    }
  }
}

int FeatureGrid::Column(double x) const {
  // Within these bounds the conversion rounds down.
  return static_cast<int>(std::clamp(x / cell_size_, 0.0, columns_ - 1.0));
}

int FeatureGrid::Row(double y) const {
  return static_cast<int>(std::clamp(y / cell_size_, 0.0, rows_ - 1.0));
}

}  // namespace highwall
