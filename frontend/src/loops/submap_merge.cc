#include "loops/submap_merge.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/internal/number_text.h>

#include "loops/keyframe_graph.h"
#include "map/pose_covariance.h"
#include "map/yaw_and_shift.h"

namespace highwall {
namespace {

// [rad] sigma of a map's gravity, as in BundleAdjuster
constexpr double kGravitySigma = 0.02;
constexpr double kMaxAngle = 0.8;  // [rad] between compared views
constexpr double kChi2 = 10.828;   // of one degree of freedom, 99.9 %

// Returns the variance [rad^2] of a loop's rotation about an axis of W. T_WC: of its keyframe.
double VarianceAbout(const Eigen::Vector3d& axis_W, const LoopEdge& loop, const Pose& T_WC,
                     const KeyFrameGraphOptions& options) {
  const Eigen::Vector3d axis_C = T_WC.R().transpose() * axis_W.stableNormalized();
  return axis_C.dot(CovarianceOf(loop, options).bottomRightCorner<3, 3>() * axis_C);
}

}  // namespace

std::optional<SubmapMerge> PlanMerge(const Map& map, const LoopEdge& loop,
                                     const KeyFrameGraphOptions& options, std::string* message) {
  const KeyFrame& match = *map.keyframe(loop.match);
  const KeyFrame& keyframe = *map.keyframe(loop.keyframe);
  const SubmapId of_match = map.Root(match.submap), of_keyframe = map.Root(keyframe.submap);
  HIGHWALL_REQUIRE(of_match != of_keyframe, "PlanMerge: the submaps are joined already");
  SubmapMerge merge;
  merge.root = std::min(of_match, of_keyframe);
  merge.other = std::max(of_match, of_keyframe);
  const bool levelled = map.gravity_W(merge.root) && map.gravity_W(merge.other);
  merge.moved = !map.gravity_W(merge.root) && map.gravity_W(merge.other) ? merge.root : merge.other;
  // Pose of the moved keyframe in the other world, by the loop.
  const bool moves_keyframe = merge.moved == of_keyframe;
  const Pose& before = moves_keyframe ? keyframe.T_WC : match.T_WC;
  const Pose after = moves_keyframe ? match.T_WC * loop.Z : keyframe.T_WC * loop.Z.Inverse();
  merge.T_new_old = after * before.Inverse();
  if (!levelled) return merge;

  const Eigen::Vector3d up = merge.T_new_old.q() * Eigen::Vector3d::UnitZ();
  const double tilt = std::acos(std::clamp(up.z(), -1.0, 1.0));
  const double variance = 2.0 * kGravitySigma * kGravitySigma +
                          VarianceAbout(up.cross(Eigen::Vector3d::UnitZ()), loop,
                                        moves_keyframe ? after : keyframe.T_WC, options);
  if (tilt * tilt > kChi2 * variance) {
    *message = "tilts gravity by " + FixedText(tilt * 180.0 / M_PI) + " deg, more than " +
               FixedText(std::sqrt(kChi2 * variance) * 180.0 / M_PI);
    return std::nullopt;
  }
  merge.T_new_old = YawAndShift(merge.T_new_old, before.p());
  return merge;
}

double MergeChi2(const Map& map, const LoopEdge& before, const LoopEdge& now,
                 const KeyFrameGraphOptions& options) {
  // Both place the newer keyframe in the world of the matches.
  const Pose T_C_before =
      map.ResolvePose(now.keyframe).Inverse() * map.ResolvePose(before.keyframe);
  const Pose by_before = map.ResolvePose(before.match) * before.Z * T_C_before.Inverse();
  const Pose between = by_before.Inverse() * map.ResolvePose(now.match) * now.Z;
  Eigen::Matrix<double, 6, 1> error;
  error << between.p(), so3::Log(between.q());
  const PoseCovariance covariance =
      CovarianceOf(now, options) + CarriedTo(T_C_before, CovarianceOf(before, options));
  return error.dot(covariance.llt().solve(error));
}

std::optional<double> MergeContradiction(const Map& map, const SubmapMerge& merge,
                                         const DepthGrid& grid, const DepthNoise& noise) {
  constexpr std::size_t kMost = 40;  // compared keyframes, evenly spread
  constexpr std::size_t kViews = 3;  // views that each is compared with
  DepthComparison comparison(grid, noise);
  const std::vector<KeyFrameId> moved = map.KeyFramesOf(merge.moved);
  const std::vector<KeyFrameId> kept =
      map.KeyFramesOf(merge.moved == merge.root ? merge.other : merge.root);
  const std::size_t every = (moved.size() + kMost - 1) / kMost;
  for (std::size_t i = 0; i < moved.size(); i += every) {
    const KeyFrame& keyframe = *map.keyframe(moved[moved.size() - 1 - i]);
    const Pose T_WC = merge.T_new_old * keyframe.T_WC;
    std::vector<std::pair<double, KeyFrameId>> views;
    for (const KeyFrameId id : kept) {
      const Pose T = T_WC.Inverse() * map.keyframe(id)->T_WC;
      // Views whose frustums do not intersect share nothing; of the others the nearest overlap
      // most.
      if (T.Angle() < kMaxAngle) views.emplace_back(T.p().norm(), id);
    }
    std::sort(views.begin(), views.end());
    views.resize(std::min(views.size(), kViews));
    for (const auto& [distance, id] : views) {
      const KeyFrame& other = *map.keyframe(id);
      DepthComparison pair(grid, noise);
      pair.Add(keyframe.depth_grid, other.depth_grid, T_WC.Inverse() * other.T_WC);
      // Many pairs with little overlap are no evidence.
      if (pair.Contradiction()) comparison.Add(pair);
    }
  }
  return comparison.Contradiction();
}

void Apply(const SubmapMerge& merge, Map* map) {
  map->Transform(merge.T_new_old, merge.moved);
  map->Join(merge.root, merge.other);
}

}  // namespace highwall
