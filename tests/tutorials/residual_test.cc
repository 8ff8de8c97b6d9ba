// The program of docs/tutorial_residual.md, between the two marks, and its test.
// [tutorial]
#include <string>

#include <highwall/core/testing/jacobian_check.h>
#include <highwall/factors/point_reprojection.h>

// Evaluates a point p_W [m] that a camera at T_WB sees at `pixel`. Returns the residual [px]; the
// message is empty if the Jacobian agrees with central differences.
Eigen::Vector2d Reproject(const highwall::Pose& T_WB, const highwall::Point& p_W,
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
// [/tutorial]

#include <gtest/gtest.h>

namespace highwall {
namespace {

TEST(ResidualTutorial, IsZeroWhereThePointProjectsAndItsJacobianAgrees) {
  const Pose T_WB = Pose::FromTangent({0.1, 0.0, -0.2}, {0.0, 0.05, 0.0});
  const Point p_W(0.1, 0.05, 2.0);
  const Eigen::Vector2d pixel = PinholeCamera().Project(T_WB.Inverse() * p_W);
  std::string message;
  EXPECT_LT(Reproject(T_WB, p_W, pixel, &message).norm(), 1e-9);
  EXPECT_EQ(message, "");
  const Eigen::Vector2d shifted = pixel + Eigen::Vector2d(3.0, -2.0);
  const Eigen::Vector2d residual = Reproject(T_WB, p_W, shifted, &message);
  EXPECT_LT((residual - Eigen::Vector2d(-3.0, 2.0)).norm(), 1e-9) << "prediction - measurement";
  EXPECT_EQ(message, "");
}

}  // namespace
}  // namespace highwall
