#include <highwall/factors/time_offset_factor.h>

#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>
#include <highwall/core/testing/jacobian_check.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/line_reprojection.h>
#include <highwall/factors/point_reprojection.h>
#include <highwall/factors/zero_velocity.h>

#include "reprojection_scene.h"
#include "support/imu_scene.h"

namespace highwall::time_offset_factor_test {
namespace {

const PoseManifold kPoseManifold;
const LineManifold kLineManifold;
const std::vector<const ceres::Manifold*> kPointManifolds = {&kPoseManifold, nullptr, nullptr};
const std::vector<const ceres::Manifold*> kLineManifolds = {&kPoseManifold, &kLineManifold,
                                                            nullptr};

std::shared_ptr<const ceres::CostFunction> SomePoint(const twins::Rig& rig, const Pose& T_WB,
                                                     const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d z = Observe(rig, T_WB, p_W) + Eigen::Vector3d(2.0, -1.0, 0.2);
  return std::make_shared<PointReprojectionRgbd>(z, Eigen::Matrix3d::Identity(), Projection(rig));
}

std::shared_ptr<const ceres::CostFunction> SomeLine(const twins::Rig& rig, const Pose& T_WB,
                                                    const Eigen::Vector3d& p_W,
                                                    const Eigen::Vector3d& q_W) {
  const RgbdSegment segment{Observe(rig, T_WB, p_W), Observe(rig, T_WB, q_W)};
  return std::make_shared<OrthonormalLineReprojectionRgbd>(segment, SegmentNoise(),
                                                           Weighting::kCovariance, Projection(rig));
}

TEST(TimeOffsetFactor, IsTheFactorAtThePoseThatTheVelocitiesLeadTo) {
  std::mt19937 rng(90);
  const twins::Rig rig = TestRig();
  const Pose T_WB = RandomPose(rng);
  const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
  const Eigen::Vector3d v_WB(0.7, -1.1, 0.4), omega_B(0.5, 0.8, -0.6);
  const auto seen = SomePoint(rig, T_WB, p_W);
  const TimeOffsetFactor f(seen, v_WB, omega_B, 0.01);
  const Pose moved(T_WB.q() * so3::Exp(omega_B * 0.02), T_WB.p() + 0.02 * v_WB);
  EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(p_W), {0.03}}) -
             Residual(*seen, {ToBlock(moved), ToBlock(p_W)}))
                .norm(),
            1e-10);
  EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(p_W), {0.01}}) -
             Residual(*seen, {ToBlock(T_WB), ToBlock(p_W)}))
                .norm(),
            1e-11);
}

TEST(TimeOffsetFactor, JacobiansOfPointsAndLinesMatchCentralDifferences) {
  std::mt19937 rng(91);
  const twins::Rig rig = TestRig();
  AtRandomPoses(rng, [&](const Pose& T_WB) {
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
    const Eigen::Vector3d q_W = RandomPointInView(rng, rig, T_WB);
    const Eigen::Vector3d v = RandomVector(rng, 2.0), omega = RandomVector(rng, 2.0);
    const double t_d = Uniform(rng, -0.02, 0.02);
    const TimeOffsetFactor point(SomePoint(rig, T_WB, p_W), v, omega, 0.005);
    const auto of_point =
        testing::CheckJacobians(point, {ToBlock(T_WB), ToBlock(p_W), {t_d}}, kPointManifolds);
    EXPECT_TRUE(of_point) << of_point.message;
    if ((Observe(rig, T_WB, p_W) - Observe(rig, T_WB, q_W)).head<2>().norm() < 30.0) return;
    const OrthonormalLine line(PluckerLine::FromPoints(p_W, q_W));
    const TimeOffsetFactor of_line(SomeLine(rig, T_WB, p_W, q_W), v, omega, 0.005);
    const std::vector<Block> blocks = {ToBlock(T_WB), Block(line.data(), line.data() + 6), {t_d}};
    const auto check = testing::CheckJacobians(of_line, blocks, kLineManifolds);
    EXPECT_TRUE(check) << check.message;
  });
}

TEST(TimeOffsetFactor, JacobianOfTheOffsetDoesNotNeedThatOfThePose) {
  std::mt19937 rng(92);
  const twins::Rig rig = TestRig();
  const Pose T_WB = RandomPose(rng);
  const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
  const TimeOffsetFactor f(SomePoint(rig, T_WB, p_W), {0.7, -1.1, 0.4}, {0.5, 0.8, -0.6}, 0.0);
  const double t_d = 0.01;
  const double* blocks[] = {T_WB.data(), p_W.data(), &t_d};
  double r[3], pose[21], point[9], with[3], alone[3];
  double* all[] = {pose, point, with};
  double* one[] = {nullptr, nullptr, alone};
  ASSERT_TRUE(f.Evaluate(blocks, r, all));
  ASSERT_TRUE(f.Evaluate(blocks, r, one));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(alone[i], with[i]);
}

// The readings from 0.3 to 0.7 s, and the blocks of a factor on them, with the poses of images that
// were taken `late` [s] after the readings at either end.
struct Interval {
  static constexpr double kFrom = 0.3, kTo = 0.7;

  explicit Interval(double late_from, double late_to) {
    std::vector<ImuSample> samples;
    for (int i = 0; i <= 400; ++i)
      samples.push_back(motion.SampleAt(FromSeconds(kFrom + i * 1e-3)));
    factor = std::make_shared<ImuGravityFactor>(ImuPreintegration(samples, ImuBias::Zero()));
    const auto at = [&](double reading, double late) {
      const ImuState state = motion.StateAt(reading);
      const Pose T_WB = motion.StateAt(reading + late).T_WB;
      blocks.insert(blocks.end(), {ToBlock(T_WB), ToBlock(state.v_WB), Block(6, 0.0)});
    };
    at(kFrom, late_from);
    at(kTo, late_to);
    blocks.push_back({0.0, 0.0, -1.0});
  }
  // The pose of an image moves back to its reading: t_d is 0 where it was taken to be t_d_state.
  MovingPose Back(double reading, std::size_t block, double t_d_state) const {
    const Eigen::Vector3d omega_B = motion.SampleAt(FromSeconds(reading)).gyroscope;
    return {block, -motion.StateAt(reading).v_WB, -omega_B, t_d_state};
  }

  const SinusoidalMotion motion;
  std::shared_ptr<const ceres::CostFunction> factor;
  std::vector<Block> blocks;
};

TEST(TimeOffsetFactor, ReadingsMeetImagesAtBothEndsWhereTheOffsetIsTheirs) {
  // Both ends were taken with another offset: 3 ms and 1 ms too early.
  Interval interval(0.003, 0.001);
  const TimeOffsetFactor f(interval.factor,
                           {interval.Back(Interval::kFrom, ImuGravityFactor::kPoseI, -0.003),
                            interval.Back(Interval::kTo, ImuGravityFactor::kPoseJ, -0.001)});
  const double before = Residual(*interval.factor, interval.blocks).norm();
  interval.blocks.push_back({0.0});
  // The path is a parabola, the velocity a constant: 1/2 a t^2 of 1.8 m/s^2 are 8 um of 2 mm.
  EXPECT_LT(Residual(f, interval.blocks).norm(), 0.02 * before);
  interval.blocks.back() = {0.003};
  EXPECT_GT(Residual(f, interval.blocks).norm(), 0.5 * before);
}

TEST(TimeOffsetFactor, JacobiansOfReadingsWithTwoMovingPosesMatchCentralDifferences) {
  const UnitDirectionManifold direction;
  Interval interval(0.003, -0.002);
  interval.blocks.push_back({0.004});
  const TimeOffsetFactor f(interval.factor,
                           {interval.Back(Interval::kFrom, ImuGravityFactor::kPoseI, -0.003),
                            interval.Back(Interval::kTo, ImuGravityFactor::kPoseJ, 0.002)});
  const auto check = testing::CheckJacobians(
      f, interval.blocks,
      {&kPoseManifold, nullptr, nullptr, &kPoseManifold, nullptr, nullptr, &direction, nullptr});
  EXPECT_TRUE(check) << check.message;
}

TEST(TimeOffsetFactor, LinesFindTheOffsetOfAMovingCamera) {
  // The images are taken t_d later than their stamps, and the poses are known in the IMU's time.
  constexpr double kOffset = 0.01, kPeriod = 1.0 / 30.0;
  std::mt19937 rng(93);
  const twins::Rig rig = TestRig();
  const SinusoidalMotion motion;
  FactorGraph graph;
  const Variable<double> t_d = graph.AddVariable(0.0);
  for (int k = 1; k < 10; ++k) {
    const double t = k * kPeriod;
    const ImuState state = motion.StateAt(t);
    const Pose taken = motion.StateAt(t + kOffset).T_WB;
    const auto pose = graph.AddVariable(state.T_WB);
    graph.Fix(pose);
    const Eigen::Vector3d omega_B = motion.SampleAt(FromSeconds(t)).gyroscope;
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d p_W = RandomPointInView(rng, rig, taken);
      const Eigen::Vector3d q_W = RandomPointInView(rng, rig, taken);
      if ((Observe(rig, taken, p_W) - Observe(rig, taken, q_W)).head<2>().norm() < 30.0) continue;
      const auto line = graph.AddVariable(OrthonormalLine(PluckerLine::FromPoints(p_W, q_W)));
      graph.Fix(line);
      graph.AddFactorToBlocks(std::make_shared<TimeOffsetFactor>(SomeLine(rig, taken, p_W, q_W),
                                                                 state.v_WB, omega_B, 0.0),
                              nullptr, std::vector<VariableId>{pose, line, t_d});
    }
  }
  ASSERT_TRUE(graph.Solve().IsUsable());
  // The velocities are those at the stamps: the path is a parabola, with an error of 1/2 a t_d^2, a
  // < 10 m/s^2.
  EXPECT_NEAR(graph.Value(t_d), kOffset, 2e-4);
}

TEST(TimeOffsetFactor, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const twins::Rig rig = TestRig();
  const auto seen = std::make_shared<PointReprojection>(
      Eigen::Vector2d(1, 2), Eigen::Matrix2d::Identity(), Projection(rig));
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  EXPECT_THROW(TimeOffsetFactor(nullptr, zero, zero, 0.0), InvalidArgument);
  EXPECT_THROW(TimeOffsetFactor(std::make_shared<ZeroVelocity>(), zero, zero, 0.0),
               InvalidArgument);
  EXPECT_THROW(TimeOffsetFactor(seen, {nan, 0, 0}, zero, 0.0), InvalidArgument);
  EXPECT_THROW(TimeOffsetFactor(seen, zero, {0, nan, 0}, 0.0), InvalidArgument);
  EXPECT_THROW(TimeOffsetFactor(seen, zero, zero, nan), InvalidArgument);
  EXPECT_THROW(TimeOffsetFactor(seen, {}), InvalidArgument);
  EXPECT_THROW(TimeOffsetFactor(seen, {MovingPose{.block = 1}}), InvalidArgument);
  EXPECT_THROW(TimeOffsetFactor(seen, {MovingPose(), MovingPose()}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::time_offset_factor_test
