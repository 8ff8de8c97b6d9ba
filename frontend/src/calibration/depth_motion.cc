#include "calibration/depth_motion.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <highwall/frontend/pose/pose_observations.h>
#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {
namespace {

constexpr int kFewestMatches = 300;  // of all pairs
// Matches of epipolar geometry are accurate: those that half of the model's noise does not explain
// belong to another motion.
constexpr double kSharper = 2.0;
// Unexplained matches: their least share by the stated depth, and what may remain of it, and of
// what a constant leaves, by another one. On right recordings the stated depth explains most.
constexpr double kUnexplained = 0.05, kRemains = 0.4, kRemainsOfConstant = 0.7;

cv::Point Flipped(const cv::Point& cell, const cv::Size& size, bool left_right, bool upside_down) {
  return {left_right ? size.width - 1 - cell.x : cell.x,
          upside_down ? size.height - 1 - cell.y : cell.y};
}

// Returns how many of these matches one motion of the camera explains.
int Explained(const MeasurementModel& model, const std::vector<PosePoint>& points) {
  PerKind<PoseObservations> seen;
  seen.points = points;
  const auto solution = SolvePose(Pose(), model.projection(), seen);
  return solution ? solution->num_points : 0;
}

}  // namespace

void DepthMotion::Add(const FrameFeatures& first, const FrameFeatures& second,
                      std::span<const FeatureMatch> matches) {
  const cv::Mat& cells = first.depth_grid;
  if (cells.empty()) return;
  const cv::Size size = cells.size();
  std::array<std::vector<PosePoint>, kCount> points;
  std::vector<float> depths;
  for (const FeatureMatch& match : matches) {
    const PointFeature& a = first.points[static_cast<std::size_t>(match.query)];
    PointFeature b = second.points[static_cast<std::size_t>(match.train)];
    b.depth = 0.0;  // its pixel is observed
    const cv::Point cell = grid_.CellOf(a.uv);
    std::array<float, kFlips> depth{};
    for (int flip = 0; flip < kFlips; ++flip) {
      depth[static_cast<std::size_t>(flip)] =
          cells.at<float>(Flipped(cell, size, (flip & kLeftRight) != 0, (flip & kUpsideDown) != 0));
    }
    if (std::ranges::min(depth) <= 0.0F) continue;
    depths.push_back(depth.front());
    ProjectionRows<3> rows = model_.Rows(b);
    rows.A *= kSharper;
    rows.b *= kSharper;
    for (int flip = 0; flip < kFlips; ++flip) {
      const auto i = static_cast<std::size_t>(flip);
      points[i].push_back({.p_W = model_.camera().Unproject(a.uv, static_cast<double>(depth[i])),
                           .rows = rows,
                           .dimension = 2});
    }
  }
  if (depths.empty()) return;
  std::ranges::nth_element(depths, depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2));
  const double median = depths[depths.size() / 2];
  points[kInverse] = points[kConstant] = points[kAsItIs];
  for (PosePoint& point : points[kConstant]) point.p_W *= median / point.p_W.z();
  // At any scale, which the motion takes, but not nearer than cameras measure.
  constexpr double kTypical = 2.0;  // [m]
  for (PosePoint& point : points[kInverse]) {
    point.p_W *= kTypical * median / (point.p_W.z() * point.p_W.z());
  }
  matches_ += static_cast<int>(depths.size());
  for (std::size_t i = 0; i < kCount; ++i) explained_[i] += Explained(model_, points[i]);
}

double DepthMotion::Unexplained(Depth depth) const {
  return 1.0 - static_cast<double>(explained_[depth]) / std::max(matches_, 1);
}

std::optional<SensorFinding> DepthMotion::Misread() const {
  if (matches_ < kFewestMatches) return std::nullopt;
  const Depth better = std::ranges::min(std::array{kLeftRight, kUpsideDown, kHalfTurn, kInverse},
                                        {}, [this](Depth depth) { return Unexplained(depth); });
  const double stated = Unexplained(kAsItIs);
  if (stated < kUnexplained || Unexplained(better) > kRemains * stated ||
      Unexplained(better) > kRemainsOfConstant * Unexplained(kConstant)) {
    return std::nullopt;
  }
  if (better == kInverse) {
    return SensorFinding{SensorFault::kDepthInverse, Trust::kNotTrusted,
                         "the colour images move as if the values of depth were disparities or "
                         "inverse depths",
                         "store z = focal length x baseline / disparity"};
  }
  const char* const how = better == kLeftRight    ? "mirrored left to right"
                          : better == kUpsideDown ? "upside down"
                                                  : "turned by 180 degrees";
  return SensorFinding{
      SensorFault::kDepthMirrored, Trust::kNotTrusted,
      std::string("depth is ") + how + " against the colour images: their motion agrees then",
      "flip the depth images"};
}

}  // namespace highwall
