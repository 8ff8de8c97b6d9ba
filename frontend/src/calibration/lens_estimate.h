#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// Focal lengths and principal point as a map tells them.
struct LensEstimate {
  Eigen::Vector4d intrinsics = Eigen::Vector4d::Zero();  // fx fy cx cy [px]
  // [px] Standard deviations by the scatter between groups of keyframes: they hold whatever the
  // noise of the observations is, and also where the map was made with a wrong lens.
  Eigen::Vector4d sigma = Eigen::Vector4d::Zero();
  int keyframes = 0, points = 0;
};

// Solves for the lens together with the poses of these keyframes, active and ascending, the points
// that two or more of them see, and the offset of inverse depth, from the lens of the model on. The
// map is not changed. Takes a few milliseconds per keyframe. Empty with less than twelve keyframes
// or a hundred points, and if the equations have no solution (docs/misconfiguration.md, Lens).
std::optional<LensEstimate> EstimateLens(const Map& map, const MeasurementModel& model,
                                         std::span<const KeyFrameId> keyframes);

}  // namespace highwall
