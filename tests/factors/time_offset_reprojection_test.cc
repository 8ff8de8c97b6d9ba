#include <highwall/factors/time_offset_reprojection.h>

#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"
#include "support/calibration_twins.h"
#include "support/imu_scene.h"

namespace highwall::time_offset_reprojection_test {
namespace {

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, nullptr, nullptr};

Eigen::Matrix3d TestWeight() {
  return (Eigen::Matrix3d() << 0.8, 0.1, 0.3, -0.2, 1.3, 0.0, 0.5, -0.4, 4.0).finished();
}

TEST(TimeOffsetReprojection, MovesTheObservationWithItsVelocity) {
  // The camera of the factor sees (0, 0, 2) at (320, 240).
  PinholeCamera camera;
  camera.cx = 320.0;
  camera.cy = 240.0;
  const RgbdProjection projection(camera, Pose());
  const std::vector<Block> state = {ToBlock(Pose()), {0, 0, 2}};
  const auto at = [&](double t_d) {
    const PointReprojectionTimeOffset f({320.0, 240.0}, {100.0, -50.0}, Eigen::Matrix2d::Identity(),
                                        projection, 0.01);
    return Residual(f, {state[0], state[1], {t_d}});
  };
  // The image is 20 ms later than assumed: it shows the feature 2 px ahead, and r compensates for
  // this.
  EXPECT_LT((at(0.03) - Eigen::Vector2d(2.0, -1.0)).norm(), 1e-12);
  EXPECT_LT(at(0.01).norm(), 1e-12);
}

TEST(TimeOffsetReprojection, IsPointReprojectionWhereTheOffsetIsThatOfTheState) {
  std::mt19937 rng(80);
  const twins::Rig rig = TestRig();
  const Pose T_WB = RandomPose(rng);
  const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB), z(300.0, 200.0, 15.0);
  const PointReprojectionRgbdTimeOffset f(z, {30.0, 40.0, 1.0}, TestWeight(), Projection(rig),
                                          -0.02);
  const PointReprojectionRgbd g(z, TestWeight(), Projection(rig));
  EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(p_W), {-0.02}}) -
             Residual(g, {ToBlock(T_WB), ToBlock(p_W)}))
                .norm(),
            1e-11);
}

template <int kRows>
void CheckAt(std::mt19937& rng, const twins::Rig& rig, const Pose& T_WB,
             const Eigen::Vector3d& p_W) {
  using Vector = Eigen::Matrix<double, kRows, 1>;
  const Vector z = (Observe(rig, T_WB, p_W) + Eigen::Vector3d(20.0, -10.0, 2.0)).head<kRows>();
  const Vector velocity = RandomVector(rng, 200.0).head<kRows>();
  const Eigen::Matrix<double, kRows, kRows> W = TestWeight().topLeftCorner<kRows, kRows>();
  const TimeOffsetReprojection<kRows> f(z, velocity, W, Projection(rig), 0.01);
  const std::vector<Block> blocks = {ToBlock(T_WB), ToBlock(p_W), {Uniform(rng, -0.05, 0.05)}};
  const auto check = testing::CheckJacobians(f, blocks, kManifolds);
  EXPECT_TRUE(check) << check.message;
  ExpectTwins(f, *twins::MakeTimeOffset<kRows>({{rig, z, W}, velocity, 0.01}), blocks, kManifolds,
              1e-10);
}

TEST(TimeOffsetReprojection, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(81);
  const twins::Rig rig = TestRig();
  AtRandomPoses(rng, [&](const Pose& T_WB) {
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
    CheckAt<2>(rng, rig, T_WB, p_W);
    CheckAt<3>(rng, rig, T_WB, p_W);
  });
  // Just inside the depth limit, and at half a turn.
  const Pose T_WB = Pose::FromTangent({1, 2, 3}, {M_PI, 0, 0});
  const double depth = RgbdProjection::kDefaultMinDepth + 1e-5;
  CheckAt<3>(rng, rig, T_WB, T_WB * (rig.T_BC * Eigen::Vector3d(0.01, -0.008, depth)));
}

TEST(TimeOffsetReprojection, DoesNotChangeWhenTheWorldFrameMoves) {
  std::mt19937 rng(82);
  const twins::Rig rig = TestRig();
  const Pose T_WB = RandomPose(rng), T_NW = RandomPose(rng);
  const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
  const PointReprojectionRgbdTimeOffset f({300, 200, 15}, {30, 40, 1}, TestWeight(),
                                          Projection(rig));
  EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(p_W), {0.01}}) -
             Residual(f, {ToBlock(T_NW * T_WB), ToBlock(Eigen::Vector3d(T_NW * p_W)), {0.01}}))
                .norm(),
            1e-10);
}

TEST(TimeOffsetReprojection, SolvesForTheOffsetOfAMovingCamera) {
  // The images are taken t_d later than their stamps, and the poses are known in the IMU's time.
  constexpr double kOffset = 0.03, kPeriod = 1.0 / 30.0;
  std::mt19937 rng(83);
  const twins::Rig rig = TestRig();
  const SinusoidalMotion motion;
  FactorGraph graph;
  const Variable<double> t_d = graph.AddVariable(0.0);
  for (int k = 1; k < 10; ++k) {
    const double t = k * kPeriod;
    const Pose T_WB = motion.StateAt(t).T_WB;
    const auto pose = graph.AddVariable(T_WB);
    graph.Fix(pose);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
      const auto point = graph.AddVariable(p_W);
      graph.Fix(point);
      const auto observed = [&](double time) {
        return Observe(rig, motion.StateAt(time + kOffset).T_WB, p_W);
      };
      const Eigen::Vector3d velocity =
          (observed(t + kPeriod) - observed(t - kPeriod)) / (2.0 * kPeriod);
      graph.AddFactor(std::make_unique<PointReprojectionRgbdTimeOffset>(
                          observed(t), velocity, Eigen::Matrix3d::Identity(), Projection(rig)),
                      pose, point, t_d);
    }
  }
  ASSERT_TRUE(graph.Solve().IsUsable());
  // Each round linearizes the image motion over 30 ms, and the next round starts from its t_d.
  EXPECT_NEAR(graph.Value(t_d), kOffset, 1e-3);
}

TEST(TimeOffsetReprojection, IsInactiveNearerThanTheMinimalDepth) {
  const twins::Rig rig = TestRig();
  const PointReprojectionTimeOffset f({1, 2}, {3, 4}, Eigen::Matrix2d::Identity(), Projection(rig));
  const Eigen::Vector3d p_W = rig.T_BC * Eigen::Vector3d(0.1, 0.2, 0.04);
  const std::vector<Block> blocks = {ToBlock(Pose()), ToBlock(p_W), {0.5}};
  EXPECT_EQ(Residual(f, blocks).norm(), 0.0);
  EXPECT_EQ(TangentJacobian(f, blocks, kManifolds).norm(), 0.0);
}

TEST(TimeOffsetReprojection, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const RgbdProjection projection = Projection(TestRig());
  const Eigen::Matrix2d W = Eigen::Matrix2d::Identity();
  using Factor = PointReprojectionTimeOffset;
  EXPECT_THROW(Factor({nan, 0}, {0, 0}, W, projection), InvalidArgument);
  EXPECT_THROW(Factor({0, 0}, {nan, 0}, W, projection), InvalidArgument);
  EXPECT_THROW(Factor({0, 0}, {0, 0}, nan * W, projection), InvalidArgument);
  EXPECT_THROW(Factor({0, 0}, {0, 0}, W, projection, nan), InvalidArgument);
}

}  // namespace
}  // namespace highwall::time_offset_reprojection_test
