#pragma once

#include <array>
#include <functional>
#include <optional>

#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/features/frame.h>

// What differs between the kinds of features; everything else is written once for all of them.
namespace highwall {

// Calls f with the members about one kind of structures with one member for each kind, such as
// FrameFeatures and FeatureFlags; for each kind, points first.
template <class F, class... Holders>
void ForEachKindOfFeature(F&& f, Holders&... holders) {
  f(holders.points...);
  f(holders.lines...);
}

// Positions [px] that represent a feature where a mask is looked up.
inline std::array<Eigen::Vector2d, 1> PixelsOf(const PointFeature& point) {
  return {point.uv};
}
std::array<Eigen::Vector2d, 3> PixelsOf(const LineFeature& line);

inline bool HasDepth(const PointFeature& point) {
  return point.depth > 0.0;
}
inline bool HasDepth(const LineFeature& line) {
  return line.segment_C.has_value();
}

// Correction of measured distances by a distortion pattern.
class DepthFactor {
 public:
  // camera: with its distortion. Both must outlive it.
  DepthFactor(const PinholeCamera& camera, const DepthPattern& pattern)
      : camera_(camera), undistorted_(camera.WithoutDistortion()), pattern_(pattern) {}

  // Returns the factor on the distance of p_C [m].
  double At(const Eigen::Vector3d& p_C) const;
  const PinholeCamera& undistorted() const { return undistorted_; }

 private:
  const PinholeCamera& camera_;
  PinholeCamera undistorted_;
  const DepthPattern& pattern_;
};

// Corrects the depth of a feature that has it.
void CorrectDepth(const DepthFactor& factor, PointFeature* point);
void CorrectDepth(const DepthFactor& factor, LineFeature* line);

// Returns where a point p_C [m] observed at the undistorted pixel uv has moved. measured: whether
// its depth was measured.
using MovePoint = std::function<Eigen::Vector3d(const Eigen::Vector2d& uv,
                                                const Eigen::Vector3d& p_C, bool measured)>;

// Moves the points that a feature consists of. camera: without distortion. mean_depth: [m] of a
// feature without depth.
void MoveFeature(const MovePoint& move, const PinholeCamera& camera, double mean_depth,
                 PointFeature* point);
void MoveFeature(const MovePoint& move, const PinholeCamera& camera, double mean_depth,
                 LineFeature* line);

// Returns the shift in C [m] of a feature that has moved; empty if its depth was not measured.
// camera: without distortion.
std::optional<Eigen::Vector3d> ShiftOf(const PointFeature& before, const PointFeature& after,
                                       const PinholeCamera& camera);
// The mean over both ends.
std::optional<Eigen::Vector3d> ShiftOf(const LineFeature& before, const LineFeature& after,
                                       const PinholeCamera& camera);

}  // namespace highwall
