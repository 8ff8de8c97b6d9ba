#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/landmark.h>

// What the creation and the adjustment of landmarks need of each kind.
namespace highwall {

// Returns where the landmark of a feature is, in C [m]; empty if its depth does not suffice.
// camera: without distortion. min_line_length: [m] of a line.
std::optional<Eigen::Vector3d> FromDepth(const PointFeature& feature, const PinholeCamera& camera,
                                         double min_line_length);
std::optional<Segment3> FromDepth(const LineFeature& feature, const PinholeCamera& camera,
                                  double min_line_length);

// Gives a new landmark the descriptor of feature `index`. Map::RefreshPoint selects that of a
// point.
inline void TakeDescriptor(const FrameFeatures&, int, MapPoint*) {}
void TakeDescriptor(const FrameFeatures& features, int index, MapLine* line);

// Moves a landmark to its estimate. Returns false if no landmark is left.
bool MoveTo(const Eigen::Vector3d& p_W, MapPoint* point);
bool MoveTo(const OrthonormalLine& line_W, MapLine* line);

// Returns whether a landmark is inside the domain of its factor.
bool IsInDomain(const Eigen::Vector3d& p_W, const PointFeature& feature, const Pose& T_CW,
                const RgbdProjection& projection);
bool IsInDomain(const OrthonormalLine& line_W, const LineFeature& feature, const Pose& T_CW,
                const RgbdProjection& projection);

// Whether a new landmark is where its only observation has it. A line starts from a fit of its
// depth, which an adjustment moves to where the image has it.
template <class Landmark>
inline constexpr bool kStartsAsObserved = false;
template <>
inline constexpr bool kStartsAsObserved<MapPoint> = true;

// Returns the Huber threshold of the rows of a kind in an adjustment.
template <class Landmark>
double HuberThreshold(const BundleAdjustmentOptions& options) = delete;
template <>
inline double HuberThreshold<MapPoint>(const BundleAdjustmentOptions& options) {
  return options.point_huber;
}
template <>
inline double HuberThreshold<MapLine>(const BundleAdjustmentOptions& options) {
  return options.line_huber;
}

}  // namespace highwall
