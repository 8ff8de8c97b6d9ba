#include "tracking/dynamic_objects.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr double kSigmas = 3.0;     // of depth noise by which two depths must differ ...
constexpr double kRelative = 0.03;  // ... and this share of the depth, for pose errors
constexpr double kLink = 0.05;  // neighbouring cells are one surface up to this share of the depth
constexpr int kMinVotes = 2;    // frames that contradict a point
constexpr int kMinCore = 6;     // [cells] inside a dynamic cluster; edges have none

// Minimum difference of the depths of two surfaces, given the farther one: depth noise and pose
// error.
class Margin {
 public:
  explicit Margin(const DepthNoise& noise)
      : offset_(static_cast<float>(std::numbers::sqrt2 * kSigmas * noise.offset)),
        quadratic_(static_cast<float>(std::numbers::sqrt2 * kSigmas * noise.quadratic)),
        reference_(static_cast<float>(noise.reference)),
        relative_(static_cast<float>(kRelative)) {}

  float operator()(float z) const {
    return offset_ + quadratic_ * (z - reference_) * (z - reference_) + relative_ * z;
  }

 private:
  float offset_, quadratic_, reference_, relative_;
};

// Values of the dynamic mask. Dynamic by the depth of references; by the landmarks on the surface;
// presumed dynamic because connected to such cells, or uncovered by something that has gone.
constexpr std::uint8_t kSeenMoving = 255, kSurface = 254, kPresumed = 127;

// kSettle: a confirmation over a long time. kGone: a contradiction because an occluding surface in
// front of the point has gone.
enum class Vote { kNone, kConfirm, kSettle, kContradict, kGone };

// Looks up cells of a view in a reference.
class Comparison {
 public:
  // settled: reference and view are far apart in time.
  Comparison(const PosedDepth& view, const PosedDepth& reference, const DepthGrid& grid,
             const Margin& margin, bool settled)
      : view_(view),
        reference_(reference),
        grid_(grid),
        margin_(margin),
        confirms_(settled ? Vote::kSettle : Vote::kConfirm),
        heeds_moving_(!settled && !reference.moving.empty()) {
    const Pose T_RV = reference.T_WC.Inverse() * view.T_WC;
    R_RV_ = T_RV.R().cast<float>();
    p_RV_ = T_RV.p().cast<float>();
  }

  // p_V: a point of the view.
  Vote Ask(const Eigen::Vector3f& p_V) const {
    const Eigen::Vector3f p_R = R_RV_ * p_V + p_RV_;
    cv::Point cell;
    if (!Locate(p_R, &cell)) return Vote::kNone;
    const float nearest = reference_.nearest.at<float>(cell);
    if (nearest <= 0.0F) return Vote::kNone;
    if (p_R.z() < nearest - margin_(nearest)) return Vote::kContradict;  // free space there
    const float farthest = reference_.farthest.at<float>(cell);
    if (p_R.z() <= farthest + margin_(p_R.z())) {
      // A surface that moved a short time ago still moves, even where it overlaps its old place.
      const bool moved = heeds_moving_ && reference_.moving.at<std::uint8_t>(cell) >= kSurface;
      return moved ? Vote::kContradict : confirms_;
    }
    return HasGone(cell) ? Vote::kGone : Vote::kNone;
  }

 private:
  // Returns the cell that a point projects to; false at the border and beyond.
  bool Locate(const Eigen::Vector3f& p, cv::Point* cell) const {
    constexpr float kMinDepth = 0.1F;  // [m]
    if (p.z() < kMinDepth) return false;
    const Eigen::Vector2f uv = grid_.Project(p);
    const auto columns = static_cast<float>(view_.depth.cols - 1);
    const auto rows = static_cast<float>(view_.depth.rows - 1);
    if (!(uv.x() >= 0.5F && uv.y() >= 0.5F && uv.x() < columns && uv.y() < rows)) return false;
    *cell = {static_cast<int>(uv.x() + 0.5F), static_cast<int>(uv.y() + 0.5F)};
    return true;
  }

  // Returns whether the view looks through the surface that the reference observed in a cell.
  bool HasGone(const cv::Point& cell) const {
    const float z = reference_.depth.at<float>(cell);
    if (z <= 0.0F) return false;
    const Eigen::Vector3f p_V = R_RV_.transpose() * (z * grid_.Ray(cell) - p_RV_);
    cv::Point seen;
    if (!Locate(p_V, &seen)) return false;
    const float nearest = view_.nearest.at<float>(seen);
    return nearest > 0.0F && p_V.z() < nearest - margin_(nearest);
  }

  const PosedDepth& view_;
  const PosedDepth& reference_;
  const DepthGrid& grid_;
  const Margin& margin_;
  Vote confirms_;
  bool heeds_moving_;
  Eigen::Matrix3f R_RV_;
  Eigen::Vector3f p_RV_;
};

// Labels of a cell by the references.
constexpr std::uint8_t kStands = 0;   // or has no depth
constexpr std::uint8_t kUnknown = 1;  // no static surface there for long
constexpr std::uint8_t kMoves = 2;

struct Verdicts {
  explicit Verdicts(const cv::Size& size)
      : labels(cv::Mat::zeros(size, CV_8UC1)), seen(cv::Mat::zeros(size, CV_8UC1)) {}

  cv::Mat labels;
  cv::Mat seen;  // not 0 where a reference observed free space, not only something that has gone
};

Verdicts Label(const PosedDepth& view, std::span<const PosedDepth> references,
               const DepthGrid& grid, const Margin& margin, double settled_after) {
  std::vector<Comparison> comparisons;
  for (const PosedDepth& reference : references) {
    const bool settled = std::abs(reference.stamp - view.stamp) >= FromSeconds(settled_after);
    comparisons.emplace_back(view, reference, grid, margin, settled);
  }
  Verdicts verdicts(view.depth.size());
  for (int v = 0; v < view.depth.rows; ++v) {
    for (int u = 0; u < view.depth.cols; ++u) {
      const float z = view.depth.at<float>(v, u);
      if (z <= 0.0F) continue;
      const Eigen::Vector3f p_V = z * grid.Ray({u, v});
      int contradict = 0, gone = 0, confirm = 0;
      bool settled = false;
      for (const Comparison& comparison : comparisons) {
        const Vote vote = comparison.Ask(p_V);
        contradict += vote == Vote::kContradict ? 1 : 0;
        gone += vote == Vote::kGone ? 1 : 0;
        confirm += vote == Vote::kConfirm || vote == Vote::kSettle ? 1 : 0;
        settled = settled || vote == Vote::kSettle;
      }
      const int votes = contradict + gone;
      verdicts.labels.at<std::uint8_t>(v, u) = votes >= kMinVotes && votes > confirm ? kMoves
                                               : settled                             ? kStands
                                                                                     : kUnknown;
      verdicts.seen.at<std::uint8_t>(v, u) = contradict > 0 ? 1 : 0;
    }
  }
  return verdicts;
}

// Returns whether at least six of a cell and its eight neighbours are contradicted, so that it is
// no mere edge.
bool IsCore(const cv::Mat& labels, const cv::Point& cell) {
  constexpr int kMostOfNine = 6;
  if (cell.x < 1 || cell.y < 1 || cell.x + 1 >= labels.cols || cell.y + 1 >= labels.rows) {
    return false;
  }
  int count = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      count += labels.at<std::uint8_t>(cell.y + dv, cell.x + du) == kMoves ? 1 : 0;
    }
  }
  return count >= kMostOfNine;
}

// A surface of contradicted cells.
struct Cluster {
  std::vector<cv::Point> cells;
  int core = 0;
};

class Clusters {
 public:
  Clusters(const cv::Mat& depth, const cv::Mat& labels, double link)
      : depth_(depth),
        labels_(labels),
        link_(link),
        visited_(cv::Mat::zeros(labels.size(), CV_8UC1)) {}

  Cluster Grow(const cv::Point& seed) {
    Cluster cluster;
    Visit(seed, cluster);
    for (std::size_t i = 0; i < cluster.cells.size(); ++i) {
      const cv::Point cell = cluster.cells[i];
      for (const cv::Point& step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const cv::Point next = cell + step;
        if (IsFree(next, kMoves) && Linked(cell, next)) Visit(next, cluster);
      }
    }
    return cluster;
  }

  // Adds the adjacent cells without evidence on the same surface: at most as many as the cluster
  // has, because they may be a wall that has just come into view.
  void Extend(Cluster& cluster) {
    constexpr int kRings = 24;
    const std::size_t enough = 2 * cluster.cells.size();
    std::size_t begin = 0;
    for (int ring = 0; ring < kRings && cluster.cells.size() < enough; ++ring) {
      const std::size_t end = cluster.cells.size();
      for (; begin < end; ++begin) {
        const cv::Point cell = cluster.cells[begin];
        for (const cv::Point& step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          const cv::Point next = cell + step;
          if (IsFree(next, kUnknown) && Linked(cell, next)) Visit(next, cluster);
        }
      }
    }
  }

  bool IsFree(const cv::Point& cell, std::uint8_t label) const {
    return cv::Rect(0, 0, labels_.cols, labels_.rows).contains(cell) &&
           labels_.at<std::uint8_t>(cell) == label && visited_.at<std::uint8_t>(cell) == 0;
  }

 private:
  void Visit(const cv::Point& cell, Cluster& cluster) {
    visited_.at<std::uint8_t>(cell) = 1;
    cluster.cells.push_back(cell);
    cluster.core += IsCore(labels_, cell) ? 1 : 0;
  }

  bool Linked(const cv::Point& a, const cv::Point& b) const {
    const float z = depth_.at<float>(a);
    return std::abs(depth_.at<float>(b) - z) <= static_cast<float>(link_) * z;
  }

  const cv::Mat& depth_;
  const cv::Mat& labels_;
  double link_;
  cv::Mat visited_;
};

// Marks the clusters of cells that the references contradict. mask: all 0 on entry.
void MarkClusters(const cv::Mat& depth, const Verdicts& verdicts, cv::Mat& mask) {
  Clusters clusters(depth, verdicts.labels, kLink);
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      if (!clusters.IsFree({u, v}, kMoves)) continue;
      Cluster cluster = clusters.Grow({u, v});
      if (cluster.core < kMinCore) continue;
      const std::size_t contradicted = cluster.cells.size();
      clusters.Extend(cluster);
      for (std::size_t i = 0; i < cluster.cells.size(); ++i) {
        const cv::Point& cell = cluster.cells[i];
        const bool seen = i < contradicted && verdicts.seen.at<std::uint8_t>(cell) != 0;
        mask.at<std::uint8_t>(cell) = seen ? kSeenMoving : kPresumed;
      }
    }
  }
}

// Returns whether a cell shows a surface that was dynamic there in the previous frame.
bool MovedBefore(const SurfaceHistory& history, const cv::Point& cell, float z) {
  constexpr float kSameDepth = 0.1F;  // share of the depth by which it may have come nearer
  return !history.moving.empty() && history.moving.at<std::uint8_t>(cell) == kSurface &&
         std::abs(history.depth.at<float>(cell) - z) < kSameDepth * z;
}

// Marks the surfaces that move as a whole.
void MarkSurfaces(const cv::Mat& depth, const cv::Mat& labels, const SurfaceHistory& history,
                  const DynamicObjectParameters& parameters, cv::Mat& mask) {
  if (history.moving.empty() && !history.moved) return;
  const DepthSurfaces surfaces = FindSurfaces(depth, kLink);
  std::vector<int> stand(surfaces.sizes.size()), moved(surfaces.sizes.size());
  for (int v = 0; v < labels.rows; ++v) {
    for (int u = 0; u < labels.cols; ++u) {
      if (surfaces.labels.at<int>(v, u) < 0) continue;
      const auto k = static_cast<std::size_t>(surfaces.labels.at<int>(v, u));
      stand[k] += labels.at<std::uint8_t>(v, u) == kStands ? 1 : 0;
      moved[k] += MovedBefore(history, {u, v}, depth.at<float>(v, u)) ? 1 : 0;
    }
  }
  const double most = parameters.max_surface * cv::countNonZero(depth > 0.0);
  for (std::size_t k = 0; k < surfaces.sizes.size(); ++k) {
    const int size = surfaces.sizes[k], surface = static_cast<int>(k);
    if (size < parameters.min_surface || size > most || 2 * stand[k] > size) continue;
    const bool moves =
        2 * moved[k] > size || (history.moved && history.moved(surfaces, surface, mask));
    if (moves) mask.setTo(kSurface, surfaces.labels == surface);
  }
}

}  // namespace

PosedDepth::PosedDepth(Stamp time, const cv::Mat& depth_grid, const Pose& T)
    : stamp(time),
      depth(depth_grid),
      nearest(cv::Mat::zeros(depth_grid.size(), CV_32FC1)),
      farthest(cv::Mat::zeros(depth_grid.size(), CV_32FC1)),
      T_WC(T) {
  constexpr int kMostOfNine = 6;
  for (int v = 1; v + 1 < depth.rows; ++v) {
    for (int u = 1; u + 1 < depth.cols; ++u) {
      float low = 0.0F, high = 0.0F;
      int valid = 0;
      for (int dv = -1; dv <= 1; ++dv) {
        const float* row = depth.ptr<float>(v + dv) + u;
        for (int du = -1; du <= 1; ++du) {
          if (row[du] <= 0.0F) continue;
          low = valid == 0 ? row[du] : std::min(low, row[du]);
          high = std::max(high, row[du]);
          ++valid;
        }
      }
      if (valid < kMostOfNine) continue;
      nearest.at<float>(v, u) = low;
      farthest.at<float>(v, u) = high;
    }
  }
}

cv::Mat FindDynamic(const PosedDepth& view, std::span<const PosedDepth> references,
                    const DepthGrid& grid, const DepthNoise& noise,
                    const DynamicObjectParameters& parameters, const SurfaceHistory& history,
                    double max_share) {
  HIGHWALL_REQUIRE(history.moving.empty() || (history.moving.size() == view.depth.size() &&
                                              history.depth.size() == view.depth.size()),
                   "FindDynamic: SurfaceHistory::depth and moving must be grids as the view's");
  const Verdicts verdicts = Label(view, references, grid, Margin(noise), parameters.settled);
  cv::Mat mask = cv::Mat::zeros(view.depth.size(), CV_8UC1);
  MarkClusters(view.depth, verdicts, mask);
  MarkSurfaces(view.depth, verdicts.labels, history, parameters, mask);
  const int masked = cv::countNonZero(mask);
  if (masked == 0 || masked > max_share * cv::countNonZero(view.depth > 0.0)) return {};
  return mask;
}

cv::Mat WithBorder(const cv::Mat& cells) {
  cv::Mat wide = cv::Mat::zeros(cells.size(), CV_8UC1);
  const cv::Rect all(0, 0, cells.cols, cells.rows);
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) {
      if (cells.at<std::uint8_t>(v, u) != 0) {
        wide(cv::Rect(u - 1, v - 1, 3, 3) & all).setTo(255);
      }
    }
  }
  return wide;
}

cv::Mat Standing(const cv::Mat& depth, const cv::Mat& moving) {
  if (moving.empty()) return depth;
  cv::Mat standing = depth.clone();
  standing.setTo(0.0F, WithBorder(moving));
  return standing;
}

DynamicObjects::DynamicObjects(const PinholeCamera& camera, const DepthNoise& noise,
                               const DynamicObjectOptions& options,
                               const DynamicObjectParameters& parameters)
    : grid_(camera), noise_(noise), options_(options), parameters_(parameters) {
  options_.Validate();
}

cv::Mat DynamicObjects::Find(Stamp stamp, const cv::Mat& depth, const Pose& T_WC, const Map& map,
                             SubmapId submap, const SurfaceTest& moved) const {
  if (!options_.enabled || depth.empty()) return {};
  std::vector<PosedDepth> references;
  for (const Remembered& remembered : recent_) {
    if (remembered.view.stamp == stamp) continue;
    if (map.RootOf(remembered.pose.reference) != map.Root(submap)) continue;
    references.push_back(remembered.view);
    references.back().T_WC = remembered.pose.T_WC(map);
  }
  SurfaceHistory history{.moved = moved};
  if (stamp > before_ && stamp - before_ <= FromSeconds(parameters_.interval)) {
    history.depth = depth_before_;
    history.moving = moving_before_;
  }
  return FindDynamic(PosedDepth(stamp, depth, T_WC), references, grid_, noise_, parameters_,
                     history, options_.max_share);
}

void DynamicObjects::Remember(Stamp stamp, const cv::Mat& depth, const Pose& T_WC,
                              const cv::Mat& moving, KeyFrameId reference, const Map& map) {
  if (!options_.enabled || depth.empty()) return;
  before_ = stamp;
  depth_before_ = depth;
  moving_before_ = moving;
  const Stamp interval = FromSeconds(parameters_.interval);
  if (!recent_.empty() && stamp - recent_.back().view.stamp < interval) return;
  recent_.push_back({PosedDepth(stamp, depth, T_WC), AnchoredPose::At(map, reference, T_WC)});
  recent_.back().view.moving = moving;
  while (stamp - recent_.front().view.stamp > FromSeconds(parameters_.history)) recent_.pop_front();
}

}  // namespace highwall
