#include <gtest/gtest.h>

#include <limits>
#include <random>

#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/factors/rgbd_projection.h>

#include "reprojection_scene.h"

namespace highwall::rgbd_projection_test {
namespace {

TEST(RgbdProjection, DisparityIsTheShiftBetweenTheTwoImages) {
  std::mt19937 rng(1);
  const twins::Rig rig = TestRig();
  const RgbdProjection projection = Projection(rig);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p_C = Eigen::Vector3d(0.0, 0.0, 2.0) + RandomVector(rng, 1.0);
    const Eigen::Vector3d p_V = p_C - Eigen::Vector3d(rig.right.baseline, 0.0, 0.0);
    const Eigen::Vector3d y = projection.Project(p_C);
    EXPECT_LT((y.head<2>() - rig.camera.Project(p_C)).norm(), 1e-11);
    EXPECT_NEAR(y.z(), (rig.camera.Project(p_C) - rig.camera.Project(p_V)).x(), 1e-11);
    EXPECT_NEAR(y.z(), rig.right.Disparity(p_C.z()), 1e-11);
  }
}

TEST(RgbdProjection, EvaluatesAnyAffineRowOfTheProjection) {
  // The form used by a pose-only problem: one View, no cost function.
  std::mt19937 rng(2);
  const twins::Rig rig = TestRig();
  const RgbdProjection projection = Projection(rig);
  const Pose T_WB = RandomPose(rng);
  const RgbdProjection::View view = RgbdProjection::At(T_WB.data());
  const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
  ProjectionRows<1> row;
  row.A << 0.3, -0.2, 2.0;
  row.b << 5.0;
  const auto value = [&](const Pose& pose, const Eigen::Vector3d& p) {
    return (row.A * Observe(rig, pose, p) + row.b)(0);
  };

  Eigen::Matrix<double, 1, 1> r;
  Eigen::Matrix<double, 1, 6> dr_dpose;
  Eigen::Matrix<double, 1, 3> dr_dp_W;
  ASSERT_TRUE(projection.Evaluate<1>(view, row, p_W, &r, &dr_dpose, &dr_dp_W));
  EXPECT_NEAR(r(0), value(T_WB, p_W), 1e-10);
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 6; ++k) {
    const Eigen::Matrix<double, 6, 1> d = kStep * Eigen::Matrix<double, 6, 1>::Unit(k);
    const double slope = (value(T_WB.Plus(d), p_W) - value(T_WB.Plus(-d), p_W)) / (2.0 * kStep);
    // Truncation is of order f h^2, rounding of order 1e-13 / h.
    EXPECT_NEAR(dr_dpose(k), slope, 1e-5) << k;
  }
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(k);
    EXPECT_NEAR(dr_dp_W(k), (value(T_WB, p_W + d) - value(T_WB, p_W - d)) / (2.0 * kStep), 1e-5);
  }
}

TEST(RgbdProjection, WritesNothingOutsideOfItsDomain) {
  const RgbdProjection projection(TestRig().camera, Pose());
  const ProjectionRows<1> row{Eigen::RowVector3d(1.0, 1.0, 1.0), Eigen::Matrix<double, 1, 1>(0.0)};
  Eigen::Matrix<double, 1, 1> r(7.0);
  Eigen::Matrix<double, 1, 3> dr_dp_W(7.0, 7.0, 7.0);
  const RgbdProjection::View view = RgbdProjection::At(Pose().data());
  EXPECT_FALSE(projection.Evaluate<1>(view, row, {0.0, 0.0, -1.0}, &r, nullptr, &dr_dp_W));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(projection.Evaluate<1>(view, row, {0.0, 0.0, nan}, &r, nullptr, &dr_dp_W));
  EXPECT_EQ(r(0), 7.0);
  EXPECT_EQ(dr_dp_W, Eigen::RowVector3d(7.0, 7.0, 7.0));
}

TEST(RgbdProjection, RefusesBadArguments) {
  const PinholeCamera camera;
  PinholeCamera distorted;
  distorted.k1 = 0.1;
  PinholeCamera flat;
  flat.fx = 0.0;
  const VirtualRightCamera right{.fx = camera.fx, .baseline = 0.1};
  EXPECT_NO_THROW(RgbdProjection(camera, Pose(), right));
  EXPECT_THROW(RgbdProjection(distorted, Pose(), right), InvalidArgument);
  EXPECT_THROW(RgbdProjection(flat, Pose(), right), InvalidArgument);
  EXPECT_THROW(RgbdProjection(camera, Pose(), {.fx = 400.0, .baseline = 0.1}), InvalidArgument);
  EXPECT_THROW(RgbdProjection(camera, Pose(), {.fx = camera.fx, .baseline = 0.0}), InvalidArgument);
  EXPECT_THROW(RgbdProjection(camera, Pose(), right, 0.0), InvalidArgument);
  Pose broken;
  broken.data()[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(RgbdProjection(camera, broken, right), InvalidArgument);
}

}  // namespace
}  // namespace highwall::rgbd_projection_test
