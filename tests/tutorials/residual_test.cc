// The program of docs/tutorial_residual.md.
#include "examples/residual/reproject.h"

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
