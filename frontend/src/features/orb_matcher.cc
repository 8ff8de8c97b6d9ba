#include <highwall/frontend/features/orb_matcher.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <highwall/core/error.h>
#include <highwall/core/target_clones.h>

namespace highwall {
namespace {

constexpr int kDescriptorBytes = 32;
constexpr int kDescriptorBits = 8 * kDescriptorBytes;

// Inlined into functions with clones, where it becomes four popcnt instructions.
[[gnu::always_inline]] inline int CountDifferentBits(const std::uint8_t* a, const std::uint8_t* b) {
  int count = 0;
  for (std::size_t i = 0; i < kDescriptorBytes; i += sizeof(std::uint64_t)) {
    std::uint64_t x, y;
    std::memcpy(&x, a + i, sizeof(x));
    std::memcpy(&y, b + i, sizeof(y));
    count += std::popcount(x ^ y);
  }
  return count;
}

HIGHWALL_TARGET_CLONES("popcnt", "default")
void DistancesToAll(const std::uint8_t* query, const std::uint8_t* train, std::size_t stride,
                    int count, int* distances) {
  for (int i = 0; i < count; ++i, train += stride) distances[i] = CountDifferentBits(query, train);
}

void RequireDescriptors(const cv::Mat& descriptors) {
  HIGHWALL_REQUIRE(descriptors.empty() || (descriptors.dims == 2 && descriptors.type() == CV_8UC1 &&
                                           descriptors.cols == kDescriptorBytes),
                   "MatchDescriptors: descriptors must be CV_8U with 32 columns");
}

struct Best {
  int index = -1;
  int distance = kDescriptorBits + 1;
  int second_distance = kDescriptorBits + 1;

  void Offer(int candidate, int d) {
    if (d < distance) {
      second_distance = distance;
      distance = d;
      index = candidate;
    } else if (d < second_distance) {
      second_distance = d;
    }
  }
};

}  // namespace

HIGHWALL_TARGET_CLONES("popcnt", "default")
int HammingDistance(const std::uint8_t* a, const std::uint8_t* b) {
  return CountDifferentBits(a, b);
}

void OrbMatcherOptions::Validate() const {
  HIGHWALL_REQUIRE(max_distance >= 0 && max_distance <= kDescriptorBits,
                   "OrbMatcherOptions::max_distance must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "OrbMatcherOptions::ratio must be in (0, 1]");
}

std::vector<FeatureMatch> MatchDescriptors(const cv::Mat& query, const cv::Mat& train,
                                           const OrbMatcherOptions& options) {
  options.Validate();
  RequireDescriptors(query);
  RequireDescriptors(train);
  std::vector<Best> best_of_query(static_cast<std::size_t>(query.rows));
  std::vector<Best> best_of_train(static_cast<std::size_t>(train.rows));
  std::vector<int> distances(best_of_train.size());
  for (int i = 0; i < query.rows && train.rows > 0; ++i) {
    DistancesToAll(query.ptr<std::uint8_t>(i), train.ptr<std::uint8_t>(), train.step[0], train.rows,
                   distances.data());
    for (int j = 0; j < train.rows; ++j) {
      const int distance = distances[static_cast<std::size_t>(j)];
      best_of_query[static_cast<std::size_t>(i)].Offer(j, distance);
      best_of_train[static_cast<std::size_t>(j)].Offer(i, distance);
    }
  }
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < query.rows; ++i) {
    const Best& best = best_of_query[static_cast<std::size_t>(i)];
    if (best.index < 0 || best.distance > options.max_distance) continue;
    if (options.ratio < 1.0 && best.distance >= options.ratio * best.second_distance) continue;
    if (options.mutual && best_of_train[static_cast<std::size_t>(best.index)].index != i) continue;
    matches.push_back({i, best.index, best.distance});
  }
  return matches;
}

FeatureGrid::FeatureGrid(const std::vector<cv::KeyPoint>& keypoints, const cv::Size& image_size,
                         double cell_size)
    : cell_size_(cell_size) {
  HIGHWALL_REQUIRE(image_size.width > 0 && image_size.height > 0, "FeatureGrid: empty image");
  HIGHWALL_REQUIRE(std::isfinite(cell_size) && cell_size > 0.0,
                   "FeatureGrid: cell_size must be positive");
  columns_ = static_cast<int>(std::ceil(image_size.width / cell_size));
  rows_ = static_cast<int>(std::ceil(image_size.height / cell_size));
  cell_begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  std::vector<std::size_t> cells;
  cells.reserve(keypoints.size());
  for (const cv::KeyPoint& keypoint : keypoints) {
    HIGHWALL_REQUIRE(std::isfinite(keypoint.pt.x) && std::isfinite(keypoint.pt.y),
                     "FeatureGrid: keypoint not finite");
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
    // The cells of a row follow one another in memory.
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
  return static_cast<int>(std::clamp(std::floor(x / cell_size_), 0.0, columns_ - 1.0));
}

int FeatureGrid::Row(double y) const {
  return static_cast<int>(std::clamp(std::floor(y / cell_size_), 0.0, rows_ - 1.0));
}

}  // namespace highwall
