#pragma once

#include <string>

#include <highwall/core/testing/jacobian_check.h>
#include <highwall/factors/point_reprojection.h>

// Evaluates a point p_W [m] that a camera at T_WB sees at `pixel`. Returns the residual [px]; the
// message is empty if the Jacobian agrees with central differences.
inline Eigen::Vector2d Reproject(const highwall::Pose& T_WB, const highwall::Point& p_W,
                                 const Eigen::Vector2d& pixel, std::string* message) {
  using namespace highwall;
  const RgbdProjection projection{PinholeCamera(), Pose()};  // the body is the camera
  const PointReprojection factor(pixel, Eigen::Matrix2d::Identity(), projection);
  const double* const values[] = {T_WB.data(), p_W.data()};
  Eigen::Vector2d residual;
  factor.Evaluate(values, residual.data(), nullptr);
  const PoseManifold pose;  // a point needs no manifold
  const auto check = highwall::testing::CheckJacobians(
      factor, {{T_WB.data(), T_WB.data() + Pose::kSize}, {p_W.data(), p_W.data() + 3}},
      {&pose, nullptr});
  *message = check ? "" : check.message;
  return residual;
}
