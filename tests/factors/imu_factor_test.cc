#include <highwall/factors/imu_factor.h>

#include <limits>
#include <memory>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/SVD>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/testing/jacobian_check.h>

#include "reprojection_scene.h"
#include "support/imu_scene.h"
#include "support/imu_twins.h"

namespace highwall::imu_factor_test {
namespace {

const PoseManifold kPose;
const UnitDirectionManifold kDirection;
const std::vector<const ceres::Manifold*> kManifolds = {&kPose, nullptr, nullptr,
                                                        &kPose, nullptr, nullptr};
const std::vector<const ceres::Manifold*> kGravityManifolds = {&kPose,  nullptr, nullptr,    &kPose,
                                                               nullptr, nullptr, &kDirection};

constexpr double kDuration = 0.5;

// Half a second of the motion from `start` [s], sampled at `hertz`.
ImuPreintegration TestImuFrom(const SinusoidalMotion& motion, double start,
                              const ImuBias& bias = ImuBias::Zero(), int hertz = 200) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= hertz / 2; ++i) {
    samples.push_back(motion.SampleAt(FromSeconds(start + i / static_cast<double>(hertz))));
  }
  // The noise is chosen so that the whitened Jacobians are near one, where differences are
  // accurate.
  const ImuPreintegrationOptions options{.noise = {.gyroscope = 0.5,
                                                   .accelerometer = 1.0,
                                                   .gyroscope_walk = 0.4,
                                                   .accelerometer_walk = 0.8}};
  return ImuPreintegration(WithBias(samples, bias), bias, options);
}

ImuPreintegration TestImu(const ImuBias& bias = ImuBias::Zero()) {
  return TestImuFrom(SinusoidalMotion(2.0), 0.0, bias);
}

Block BiasBlock(const ImuBias& bias) {
  return {bias.data(), bias.data() + 6};
}

struct Ends {
  ImuState i, j;
  ImuBias b_i = ImuBias::Zero(), b_j = ImuBias::Zero();

  std::vector<Block> Blocks() const {
    return {ToBlock(i.T_WB), ToBlock(i.v_WB), BiasBlock(b_i),
            ToBlock(j.T_WB), ToBlock(j.v_WB), BiasBlock(b_j)};
  }
  std::vector<Block> Blocks(const UnitDirection& gravity) const {
    std::vector<Block> blocks = Blocks();
    blocks.push_back(ToBlock(gravity));
    return blocks;
  }
};

Ends Truth() {
  const SinusoidalMotion motion(2.0);
  return {motion.StateAt(0.0), motion.StateAt(kDuration)};
}

ImuBias RandomBias(std::mt19937& rng) {
  return (ImuBias() << RandomVector(rng, 0.1), RandomVector(rng, 0.5)).finished();
}

// Random states with rotation errors of up to pi.
Ends RandomEnds(std::mt19937& rng) {
  return {{RandomPose(rng), RandomVector(rng, 3.0)},
          {RandomPose(rng), RandomVector(rng, 3.0)},
          RandomBias(rng),
          RandomBias(rng)};
}

TEST(ImuFactor, IsZeroOnTheTrueMotion) {
  // Fourth-order integration at 200 Hz leaves 1e-6, and the whitening is near one.
  const ImuFactor f(TestImu(), kGravity);
  EXPECT_LT(Residual(f, Truth().Blocks()).norm(), 1e-5);
}

TEST(ImuFactor, MatchesHandComputedValues) {
  // At rest for one second, with known errors of the end state.
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 100; ++i) samples.push_back({i * 10'000'000, {0, 0, 0}, {0, 0, 9.81}});
  const ImuPreintegration imu(samples, ImuBias::Zero());
  const ImuMeasurement whitening(imu, 4.0);
  const ImuFactor f(imu, kGravity, 4.0);
  Ends ends;
  ends.j.T_WB = Pose::FromTangent({0.1, -0.2, 0.3}, {0, 0, 0.25});
  ends.j.v_WB = {0.5, 0.6, -0.7};
  ends.b_j << 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3;
  Eigen::Matrix<double, 15, 1> e;
  e << 0, 0, 0.25, 0.5, 0.6, -0.7, 0.1, -0.2, 0.3, ends.b_j;
  const Eigen::VectorXd expected = whitening.W * e;
  EXPECT_LT((Residual(f, ends.Blocks()) - expected).norm(), 1e-10 * expected.norm());
  // W^T W = weight * covariance^-1, entry by entry of the identity.
  const Eigen::Matrix<double, 15, 15> identity =
      whitening.W * imu.covariance() * whitening.W.transpose() / 4.0;
  EXPECT_LT((identity - Eigen::Matrix<double, 15, 15>::Identity()).norm(), 1e-9);
}

TEST(ImuFactor, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(60);
  for (int k = 0; k < 50; ++k) {
    SCOPED_TRACE(k);
    const ImuPreintegration imu = TestImu(0.1 * RandomBias(rng));
    const Ends ends = RandomEnds(rng);
    const ImuFactor f(imu, kGravity, 0.7);
    const auto check = testing::CheckJacobians(f, ends.Blocks(), kManifolds);
    EXPECT_TRUE(check) << check.message;
    ExpectTwins(f, *MakeImu(twins::Imu(imu, 0.7)), ends.Blocks(), kManifolds, 1e-9);

    const UnitDirection gravity(RandomVector(rng, 1.0));
    const ImuGravityFactor g(imu, kStandardGravity, 0.7);
    const auto gravity_check = testing::CheckJacobians(g, ends.Blocks(gravity), kGravityManifolds);
    EXPECT_TRUE(gravity_check) << gravity_check.message;
    ExpectTwins(g, *MakeImuGravity(twins::Imu(imu, 0.7)), ends.Blocks(gravity), kGravityManifolds,
                1e-9);
  }
}

TEST(ImuFactor, JacobiansHoldAtTheEdges) {
  std::mt19937 rng(61);
  const ImuPreintegration imu = TestImu();
  const ImuFactor f(imu, kGravity);
  for (const double angle : {0.0, 1e-8, M_PI - 1e-3}) {
    SCOPED_TRACE(angle);
    Ends ends = RandomEnds(rng);
    ends.b_i = ends.b_j = ImuBias::Zero();
    ends.j.T_WB = Pose(ends.i.T_WB.q() * imu.delta().q * so3::Exp({0.6 * angle, 0, 0.8 * angle}),
                       ends.j.T_WB.p());
    const auto check = testing::CheckJacobians(f, ends.Blocks(), kManifolds);
    EXPECT_TRUE(check) << check.message;
  }
  for (const Eigen::Vector3d& n : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 0, 1)}) {
    const ImuGravityFactor g(imu);
    const auto check =
        testing::CheckJacobians(g, RandomEnds(rng).Blocks(UnitDirection(n)), kGravityManifolds);
    EXPECT_TRUE(check) << check.message;
  }
}

// Applies T_NW to both ends.
Ends Moved(const Ends& ends, const Pose& T_NW) {
  Ends moved = ends;
  for (ImuState* state : {&moved.i, &moved.j}) {
    state->T_WB = T_NW * state->T_WB;
    state->v_WB = T_NW.q() * state->v_WB;
  }
  return moved;
}

TEST(ImuFactor, DoesNotChangeWhenTheWorldMovesAndTurnsAboutTheVertical) {
  std::mt19937 rng(62);
  const ImuFactor f(TestImu(), kGravity);
  for (int k = 0; k < 20; ++k) {
    const Ends ends = RandomEnds(rng);
    const Pose T_NW = Pose::FromTangent(RandomVector(rng, 5.0), {0, 0, Uniform(rng, -3.0, 3.0)});
    const Eigen::VectorXd before = Residual(f, ends.Blocks());
    EXPECT_LT((Residual(f, Moved(ends, T_NW).Blocks()) - before).norm(), 1e-11 * before.norm());
    // A tilt does change the residual.
    const Pose tilt = Pose::FromTangent({0, 0, 0}, {0.1, 0, 0});
    EXPECT_GT((Residual(f, Moved(ends, tilt).Blocks()) - before).norm(), 1e-3);
  }
}

TEST(ImuGravityFactor, DoesNotChangeWhenTheWorldAndGravityTurnTogether) {
  std::mt19937 rng(63);
  const ImuGravityFactor f(TestImu());
  for (int k = 0; k < 20; ++k) {
    const Ends ends = RandomEnds(rng);
    const Pose T_NW = RandomPose(rng);
    const Eigen::Vector3d n = RandomVector(rng, 1.0).normalized();
    const Eigen::VectorXd before = Residual(f, ends.Blocks(UnitDirection(n)));
    const UnitDirection turned(T_NW.q() * n);
    EXPECT_LT((Residual(f, Moved(ends, T_NW).Blocks(turned)) - before).norm(),
              1e-11 * before.norm());
  }
}

TEST(ImuFactor, HasTheFourDimensionalNullSpaceOfPositionAndYaw) {
  // Five states with IMU factors, and with relative poses between them in place of visual
  // constraints.
  constexpr int kStates = 5, kDim = 15, kRows = kDim + 6;
  const SinusoidalMotion motion(2.0);
  std::vector<ImuState> states;
  for (int k = 0; k < kStates; ++k) states.push_back(motion.StateAt(k * kDuration));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kRows * (kStates - 1), kDim * kStates);
  for (int k = 0; k + 1 < kStates; ++k) {
    const Ends ends{states[static_cast<std::size_t>(k)], states[static_cast<std::size_t>(k) + 1]};
    const ImuFactor f(TestImuFrom(motion, k * kDuration), kGravity);
    J.block<kDim, 2 * kDim>(kRows * k, kDim * k) = TangentJacobian(f, ends.Blocks(), kManifolds);
    const RelativePose g(ends.i.T_WB.Inverse() * ends.j.T_WB,
                         Eigen::Matrix<double, 6, 6>::Identity());
    const Eigen::MatrixXd J_g =
        TangentJacobian(g, {ToBlock(ends.i.T_WB), ToBlock(ends.j.T_WB)}, {&kPose, &kPose});
    J.block<6, 6>(kRows * k + kDim, kDim * k) = J_g.leftCols<6>();
    J.block<6, 6>(kRows * k + kDim, kDim * (k + 1)) = J_g.rightCols<6>();
  }

  Eigen::MatrixXd null_space = Eigen::MatrixXd::Zero(kDim * kStates, 4);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (int k = 0; k < kStates; ++k) {
    const ImuState& state = states[static_cast<std::size_t>(k)];
    auto rows = null_space.middleRows<kDim>(kDim * k);
    rows.topLeftCorner<3, 3>().setIdentity();
    rows.col(3).head<3>() = up.cross(state.T_WB.p());
    rows.col(3).segment<3>(3) = state.T_WB.q().conjugate() * up;
    rows.col(3).segment<3>(6) = up.cross(state.v_WB);
  }
  EXPECT_LT((J * null_space).cwiseAbs().maxCoeff(), 1e-9);
  // The null space has no other direction: four singular values vanish, and the fifth does not.
  const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues();
  EXPECT_LT(s(s.size() - 4), 1e-12 * s(0));
  EXPECT_GT(s(s.size() - 5), 1e-4 * s(0)) << s.tail<6>().transpose();
}

TEST(ImuFactor, SolvesForVelocityAndBiasFromKnownPoses) {
  const ImuBias bias = (ImuBias() << 0.004, -0.003, 0.002, 0.05, -0.04, 0.03).finished();
  const SinusoidalMotion motion(2.0);
  FactorGraph graph;
  std::vector<Variable<Pose>> poses;
  std::vector<Variable<Eigen::Vector3d>> velocities;
  std::vector<Variable<ImuBias>> biases;
  constexpr int kStates = 5;
  for (int k = 0; k < kStates; ++k) {
    const ImuState state = motion.StateAt(k * kDuration);
    poses.push_back(graph.AddVariable(state.T_WB));
    graph.Fix(poses.back());
    velocities.push_back(graph.AddVariable(Eigen::Vector3d(0, 0, 0)));
    biases.push_back(graph.AddVariable(ImuBias(ImuBias::Zero())));
  }
  for (std::size_t k = 0; k + 1 < kStates; ++k) {
    const double start = static_cast<double>(k) * kDuration;
    // Integrated at the true bias, as after a reintegration, so the first-order correction has no
    // error.
    graph.AddFactor(std::make_unique<ImuFactor>(TestImuFrom(motion, start, bias, 1000), kGravity),
                    poses[k], velocities[k], biases[k], poses[k + 1], velocities[k + 1],
                    biases[k + 1]);
  }
  SolveOptions options;
  options.function_tolerance = 1e-20;
  options.parameter_tolerance = 1e-14;
  ASSERT_TRUE(graph.Solve(options).IsUsable());
  for (std::size_t k = 0; k < kStates; ++k) {
    const ImuState state = motion.StateAt(static_cast<double>(k) * kDuration);
    EXPECT_LT((graph.Value(velocities[k]) - state.v_WB).norm(), 1e-7) << k;
    EXPECT_LT((graph.Value(biases[k]) - bias).norm(), 1e-6) << k;
  }
}

TEST(ImuGravityFactor, SolvesForTheDirectionOfGravity) {
  // The poses are given in a frame that is tilted by 40 degrees.
  const Pose T_NW = Pose::FromTangent({1, 2, 3}, {0.5, -0.4, 0.3});
  const SinusoidalMotion motion(2.0);
  FactorGraph graph;
  const auto gravity = graph.AddVariable(UnitDirection());
  std::vector<Variable<Pose>> poses;
  std::vector<Variable<Eigen::Vector3d>> velocities;
  std::vector<Variable<ImuBias>> biases;
  for (int k = 0; k < 4; ++k) {
    poses.push_back(graph.AddVariable(T_NW * motion.StateAt(k * kDuration).T_WB));
    graph.Fix(poses.back());
    velocities.push_back(graph.AddVariable(Eigen::Vector3d(0, 0, 0)));
    biases.push_back(graph.AddVariable(ImuBias(ImuBias::Zero())));
    graph.Fix(biases.back());
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double start = static_cast<double>(k) * kDuration;
    graph.AddFactor(
        std::make_unique<ImuGravityFactor>(TestImuFrom(motion, start, ImuBias::Zero(), 1000)),
        poses[k], velocities[k], biases[k], poses[k + 1], velocities[k + 1], biases[k + 1],
        gravity);
  }
  SolveOptions options;
  options.function_tolerance = 1e-20;
  ASSERT_TRUE(graph.Solve(options).IsUsable());
  const Eigen::Vector3d truth = T_NW.q() * Eigen::Vector3d(0, 0, -1);
  EXPECT_LT((graph.Value(gravity).vector() - truth).norm(), 1e-7);
}

TEST(ImuFactor, IsNotEvaluatedAtValuesThatAreNotFinite) {
  const ImuFactor f(TestImu(), kGravity);
  std::vector<Block> blocks = Truth().Blocks();
  blocks[1][2] = std::numeric_limits<double>::quiet_NaN();
  std::vector<const double*> parameters;
  for (const Block& block : blocks) parameters.push_back(block.data());
  double r[15];
  EXPECT_FALSE(f.Evaluate(parameters.data(), r, nullptr));
}

TEST(ImuFactor, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ImuPreintegration imu = TestImu();
  EXPECT_THROW(ImuFactor(imu, {0, 0, nan}), InvalidArgument);
  EXPECT_THROW(ImuFactor(imu, kGravity, 0.0), InvalidArgument);
  EXPECT_THROW(ImuFactor(imu, kGravity, nan), InvalidArgument);
  EXPECT_THROW(ImuGravityFactor(imu, -9.81), InvalidArgument);
  EXPECT_THROW(ImuGravityFactor(imu, 9.81, -1.0), InvalidArgument);
}

}  // namespace
}  // namespace highwall::imu_factor_test
