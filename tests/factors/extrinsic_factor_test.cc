#include <highwall/factors/extrinsic_factor.h>

#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>
#include <highwall/factors/line_reprojection.h>
#include <highwall/factors/point_reprojection.h>
#include <highwall/factors/time_offset_factor.h>
#include <highwall/factors/zero_velocity.h>

#include "reprojection_scene.h"

namespace highwall::extrinsic_factor_test {
namespace {

const PoseManifold kPoseManifold;
const LineManifold kLineManifold;

// Returns the projection of a camera whose body is the camera itself.
RgbdProjection OfCamera(const twins::Rig& rig) {
  return RgbdProjection(rig.camera, Pose(), rig.right);
}

std::shared_ptr<const ceres::CostFunction> SomePoint(const twins::Rig& rig,
                                                     const Eigen::Vector3d& z) {
  return std::make_shared<PointReprojectionRgbd>(z, Eigen::Matrix3d::Identity(), OfCamera(rig));
}

std::shared_ptr<const ceres::CostFunction> SomeLine(const twins::Rig& rig, const Pose& T_WB,
                                                    const Eigen::Vector3d& p_W,
                                                    const Eigen::Vector3d& q_W) {
  const RgbdSegment segment{Observe(rig, T_WB, p_W), Observe(rig, T_WB, q_W)};
  const SegmentNoise noise{.px = 1.0, .disparity_s = 0.5, .disparity_e = 0.5};
  return std::make_shared<OrthonormalLineReprojectionRgbd>(segment, noise, Weighting::kCovariance,
                                                           OfCamera(rig));
}

// Calls check(rng, rig, T_WB, p_W, z) at fifty poses of a body with a random camera pose. z is the
// observation of p_W with an error of a pixel or two.
template <typename Check>
void AtRandomMounts(unsigned seed, const Check& check) {
  std::mt19937 rng(seed);
  twins::Rig rig = TestRig();
  AtRandomPoses(rng, [&](const Pose& T_WB) {
    rig.T_BC = RandomPose(rng);
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
    const Eigen::Vector3d z = Observe(rig, T_WB, p_W) + Eigen::Vector3d(2.0, -1.0, 0.2);
    check(rng, rig, T_WB, p_W, z);
  });
}

TEST(ExtrinsicFactor, IsTheFactorOfACameraMountedThere) {
  AtRandomMounts(100, [](std::mt19937&, const twins::Rig& rig, const Pose& T_WB,
                         const Eigen::Vector3d& p_W, const Eigen::Vector3d& z) {
    const ExtrinsicFactor f(SomePoint(rig, z));
    const PointReprojectionRgbd same(z, Eigen::Matrix3d::Identity(),
                                     RgbdProjection(rig.camera, rig.T_BC, rig.right));
    // For values of some hundred pixels.
    EXPECT_LT((Residual(f, {ToBlock(T_WB), ToBlock(p_W), ToBlock(rig.T_BC)}) -
               Residual(same, {ToBlock(T_WB), ToBlock(p_W)}))
                  .norm(),
              1e-10);
  });
}

TEST(ExtrinsicFactor, JacobiansOfPointsAndLinesMatchCentralDifferences) {
  AtRandomMounts(101, [](std::mt19937& rng, const twins::Rig& rig, const Pose& T_WB,
                         const Eigen::Vector3d& p_W, const Eigen::Vector3d& z) {
    const auto of_point = testing::CheckJacobians(ExtrinsicFactor(SomePoint(rig, z)),
                                                  {ToBlock(T_WB), ToBlock(p_W), ToBlock(rig.T_BC)},
                                                  {&kPoseManifold, nullptr, &kPoseManifold});
    EXPECT_TRUE(of_point) << of_point.message;
    const Eigen::Vector3d q_W = RandomPointInView(rng, rig, T_WB);
    if ((Observe(rig, T_WB, p_W) - Observe(rig, T_WB, q_W)).head<2>().norm() < 30.0) return;
    const OrthonormalLine line(PluckerLine::FromPoints(p_W + Eigen::Vector3d(0.01, 0, 0.02), q_W));
    const auto of_line = testing::CheckJacobians(
        ExtrinsicFactor(SomeLine(rig, T_WB, p_W, q_W)),
        {ToBlock(T_WB), Block(line.data(), line.data() + 6), ToBlock(rig.T_BC)},
        {&kPoseManifold, &kLineManifold, &kPoseManifold});
    EXPECT_TRUE(of_line) << of_line.message;
  });
}

TEST(ExtrinsicFactor, JacobiansMatchCentralDifferencesBehindATimeOffset) {
  AtRandomMounts(102, [](std::mt19937& rng, const twins::Rig& rig, const Pose& T_WB,
                         const Eigen::Vector3d& p_W, const Eigen::Vector3d& z) {
    const TimeOffsetFactor f(std::make_shared<ExtrinsicFactor>(SomePoint(rig, z)),
                             RandomVector(rng, 2.0), RandomVector(rng, 2.0), 0.005);
    const auto check =
        testing::CheckJacobians(f, {ToBlock(T_WB), ToBlock(p_W), ToBlock(rig.T_BC), {0.012}},
                                {&kPoseManifold, nullptr, &kPoseManifold, nullptr});
    EXPECT_TRUE(check) << check.message;
  });
}

TEST(ExtrinsicFactor, AJacobianDoesNotNeedTheOthers) {
  std::mt19937 rng(103);
  const twins::Rig rig = TestRig();
  const Pose T_WB = RandomPose(rng);
  const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
  const ExtrinsicFactor f(SomePoint(rig, {300.0, 200.0, 15.0}));
  const double* blocks[] = {T_WB.data(), p_W.data(), rig.T_BC.data()};
  double r[3], body[21], point[9], camera[21];
  double* all[] = {body, point, camera};
  ASSERT_TRUE(f.Evaluate(blocks, r, all));
  for (int wanted = 0; wanted < 3; ++wanted) {
    double alone[21];
    double* one[] = {nullptr, nullptr, nullptr};
    one[wanted] = alone;
    ASSERT_TRUE(f.Evaluate(blocks, r, one));
    for (int i = 0; i < 3 * f.parameter_block_sizes()[static_cast<std::size_t>(wanted)]; ++i) {
      EXPECT_EQ(alone[i], all[wanted][i]) << wanted;
    }
  }
}

TEST(ExtrinsicFactor, LinesFindWhereTheCameraSits) {
  std::mt19937 rng(104);
  const twins::Rig rig = TestRig();
  FactorGraph graph;
  const Pose off = Pose::FromTangent({0.02, -0.01, 0.03}, {0.02, 0.03, -0.01});
  const auto T_BC = graph.AddVariable(rig.T_BC * off);
  for (int k = 0; k < 10; ++k) {
    const Pose T_WB = RandomPose(rng);
    const auto pose = graph.AddVariable(T_WB);
    graph.Fix(pose);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
      const Eigen::Vector3d q_W = RandomPointInView(rng, rig, T_WB);
      if ((Observe(rig, T_WB, p_W) - Observe(rig, T_WB, q_W)).head<2>().norm() < 30.0) continue;
      const auto line = graph.AddVariable(OrthonormalLine(PluckerLine::FromPoints(p_W, q_W)));
      graph.Fix(line);
      graph.AddFactorToBlocks(std::make_shared<ExtrinsicFactor>(SomeLine(rig, T_WB, p_W, q_W)),
                              nullptr, std::vector<VariableId>{pose, line, T_BC});
    }
  }
  ASSERT_TRUE(graph.Solve().IsUsable());
  const Pose error = rig.T_BC.Inverse() * graph.Value(T_BC);  // measurements are exact
  EXPECT_LT(error.p().norm(), 1e-7);
  EXPECT_LT(error.Angle(), 1e-7);
}

TEST(ExtrinsicFactor, BlocksThatAreNoneDoNotThrow) {
  const twins::Rig rig = TestRig();
  const ExtrinsicFactor f(SomePoint(rig, {300.0, 200.0, 15.0}));
  const Block nothing(7, 0.0), nan(7, std::numeric_limits<double>::quiet_NaN());
  for (const Block& pose : {nothing, nan}) {
    const Block point = {0.0, 0.0, 2.0};
    const double* blocks[] = {pose.data(), point.data(), pose.data()};
    double r[3], body[21], camera[21];
    double* jacobians[] = {body, nullptr, camera};
    EXPECT_NO_THROW(f.Evaluate(blocks, r, jacobians));
  }
}

TEST(ExtrinsicFactor, RefusesFactorsWithoutAPose) {
  EXPECT_THROW(ExtrinsicFactor(nullptr), InvalidArgument);
  EXPECT_THROW(ExtrinsicFactor(std::make_shared<ZeroVelocity>()), InvalidArgument);
}

}  // namespace
}  // namespace highwall::extrinsic_factor_test
