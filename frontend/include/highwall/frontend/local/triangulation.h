#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/measurement_model.h>

namespace [[gnu::visibility("default")]] highwall {

// A corner and the pose of its camera.
struct PointView {
  Pose T_WC;
  PointFeature feature;
};

// Result of TriangulatePoint.
struct TriangulatedPoint {
  Eigen::Vector3d p_W;         // [m]
  Eigen::Matrix3d covariance;  // [m^2] of p_W, from the noise of the features alone
  double squared_error = 0.0;  // |r|^2 of all rows, chi-square of 2 (n - 1) - 1 and one a depth
};

// Returns the maximum-likelihood point of corners of two or more images with known poses, with
// their noise (MeasurementModel) and their depth if available. Empty if the rays do not meet in
// front of the cameras, or are too parallel for a distance.
// Initialized at the point nearest to all rays; then Levenberg-Marquardt (Hartley, Zisserman,
// "Multiple View Geometry", 2nd ed., section 12.5, with the covariance of section 5.2).
std::optional<TriangulatedPoint> TriangulatePoint(const MeasurementModel& model,
                                                  std::span<const PointView> views);

}  // namespace highwall
