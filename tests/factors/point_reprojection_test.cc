#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include <ceres/problem.h>
#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/point_reprojection.h>

#include "reprojection_scene.h"
#include "solve_exactly.h"

namespace highwall::point_reprojection_test {
namespace {

const PoseManifold kPoseManifold;
const std::vector<const ceres::Manifold*> kManifolds = {&kPoseManifold, nullptr};

// A full matrix, so that a transposed or missing W is detected.
Eigen::Matrix2d TestWeight2() {
  return (Eigen::Matrix2d() << 0.8, 0.1, -0.2, 1.3).finished();
}
Eigen::Matrix3d TestWeight3() {
  return (Eigen::Matrix3d() << 0.8, 0.1, 0.3, -0.2, 1.3, 0.0, 0.5, -0.4, 4.0).finished();
}

TEST(PointReprojection, MatchesHandComputedValues) {
  const PointReprojection f({420.0, 160.0}, Eigen::Matrix2d::Identity(), SimpleProjection());
  // (0.6, -0.6, 3): u = 320 + 500 0.2 = 420, v = 240 - 400 0.2 = 160.
  const Block pose = ToBlock(Pose());
  EXPECT_LT(Residual(f, {pose, {0.6, -0.6, 3.0}}).norm(), 1e-12);
  // (0.9, -0.3, 3): u = 470, v = 200.
  EXPECT_LT((Residual(f, {pose, {0.9, -0.3, 3.0}}) - Eigen::Vector2d(50.0, 40.0)).norm(), 1e-12);
}

TEST(PointReprojectionRgbd, MatchesHandComputedValues) {
  // Disparity at 2.5 m: 50 / 2.5 = 20.
  const Eigen::Vector3d measured(420.0, 160.0, 20.0);
  const PointReprojectionRgbd f(measured, PointSqrtInformation(Weighting::kCovariance, 2.0, 0.5),
                                SimpleProjection());
  const Block pose = ToBlock(Pose());
  EXPECT_LT(Residual(f, {pose, {0.5, -0.5, 2.5}}).norm(), 1e-12);
  // (1, -1, 5): the same pixel, disparity 10.
  EXPECT_LT((Residual(f, {pose, {1.0, -1.0, 5.0}}) - Eigen::Vector3d(0.0, 0.0, -20.0)).norm(),
            1e-12);

  const PointReprojectionRgbd paper(measured, PointSqrtInformation(Weighting::kPaper, 2.0, 0.5),
                                    SimpleProjection());
  // u_R is 410 instead of 400, in units of 2 px.
  EXPECT_LT((Residual(paper, {pose, {1.0, -1.0, 5.0}}) - Eigen::Vector3d(0.0, 0.0, 5.0)).norm(),
            1e-12);
}

// Checks both factors at one state by central differences and the autodiff twin.
void CheckBothFactors(std::mt19937& rng, const twins::Rig& rig, const Pose& T_WB,
                      const Eigen::Vector3d& p_W) {
  // The state is 5 to 50 px away from the optimum.
  const Eigen::Vector3d z =
      Observe(rig, T_WB, p_W) +
      Eigen::Vector3d(Uniform(rng, 5.0, 50.0), Uniform(rng, -50.0, -5.0), Uniform(rng, 1.0, 5.0));
  const std::vector<Block> blocks = {ToBlock(T_WB), ToBlock(p_W)};
  const PointReprojection f2(z.head<2>(), TestWeight2(), Projection(rig));
  const PointReprojectionRgbd f3(z, TestWeight3(), Projection(rig));
  const auto check2 = testing::CheckJacobians(f2, blocks, kManifolds);
  const auto check3 = testing::CheckJacobians(f3, blocks, kManifolds);
  EXPECT_TRUE(check2) << check2.message;
  EXPECT_TRUE(check3) << check3.message;
  ExpectTwins(f2, *twins::MakePoint<2>({rig, z.head<2>(), TestWeight2()}), blocks, kManifolds,
              1e-10);
  ExpectTwins(f3, *twins::MakePoint<3>({rig, z, TestWeight3()}), blocks, kManifolds, 1e-10);
}

TEST(PointReprojection, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(42);
  const twins::Rig rig = TestRig();
  AtRandomPoses(rng, [&](const Pose& T_WB) {
    CheckBothFactors(rng, rig, T_WB, RandomPointInView(rng, rig, T_WB));
  });
}

TEST(PointReprojection, JacobiansHoldAtTheEdges) {
  std::mt19937 rng(43);
  const twins::Rig rig = TestRig();
  AtEdgesOfRotation([&](const Pose& T_WB) {
    CheckBothFactors(rng, rig, T_WB, RandomPointInView(rng, rig, T_WB));
    // The point is just inside the depth limit, and the factor is smooth within a step of 1e-6.
    const double depth = RgbdProjection::kDefaultMinDepth + 1e-5;
    CheckBothFactors(rng, rig, T_WB, T_WB * (rig.T_BC * Eigen::Vector3d(0.01, -0.008, depth)));
  });
}

TEST(PointReprojection, DoesNotChangeWhenTheWorldFrameMoves) {
  std::mt19937 rng(44);
  const twins::Rig rig = TestRig();
  for (int i = 0; i < 20; ++i) {
    const Pose T_WB = RandomPose(rng), T_NW = RandomPose(rng);
    const Eigen::Vector3d p_W = RandomPointInView(rng, rig, T_WB);
    const Eigen::Vector3d z = Observe(rig, T_WB, p_W) + Eigen::Vector3d(7.0, -4.0, 2.0);
    const PointReprojectionRgbd f(z, TestWeight3(), Projection(rig));
    const Eigen::VectorXd before = Residual(f, {ToBlock(T_WB), ToBlock(p_W)});
    const Eigen::VectorXd after =
        Residual(f, {ToBlock(T_NW * T_WB), ToBlock(Eigen::Vector3d(T_NW * p_W))});
    // Pixels of magnitude 500 and metres of magnitude 5 in double precision.
    EXPECT_LT((before - after).norm(), 1e-10);
  }
}

TEST(PointReprojectionRgbd, SolvesForAPerturbedPose) {
  std::mt19937 rng(45);
  const twins::Rig rig = TestRig();
  for (const Weighting weighting : {Weighting::kCovariance, Weighting::kPaper}) {
    const Pose truth = RandomPose(rng);
    Pose T_WB =
        truth.Plus((Eigen::Matrix<double, 6, 1>() << 0.1, -0.1, 0.1, 0.1, 0.1, -0.1).finished());
    std::vector<Eigen::Vector3d> points;
    ceres::Problem problem;
    for (int i = 0; i < 12; ++i) points.push_back(RandomPointInView(rng, rig, truth));
    for (Eigen::Vector3d& p_W : points) {
      problem.AddResidualBlock(
          new PointReprojectionRgbd(Observe(rig, truth, p_W),
                                    PointSqrtInformation(weighting, 1.0, 0.1), Projection(rig)),
          nullptr, T_WB.data(), p_W.data());
      problem.SetParameterBlockConstant(p_W.data());
    }
    problem.SetManifold(T_WB.data(), new PoseManifold);
    SolveExactly(&problem);
    // The data are exact, so the result is the truth to rounding.
    EXPECT_LT((T_WB.p() - truth.p()).norm(), 1e-9);
    EXPECT_LT((truth.Inverse() * T_WB).Angle(), 1e-9);
  }
}

TEST(PointReprojection, TwoViewsSolveForThePoint) {
  std::mt19937 rng(46);
  const twins::Rig rig = TestRig();
  std::vector<Pose> poses = {RandomPose(rng)};
  poses.push_back(
      poses[0].Plus((Eigen::Matrix<double, 6, 1>() << 0.2, 0.1, 0, 0, 0.05, 0).finished()));
  const Eigen::Vector3d truth = RandomPointInView(rng, rig, poses[0]);
  Eigen::Vector3d p_W = truth + Eigen::Vector3d(0.1, -0.1, 0.1);
  ceres::Problem problem;
  for (Pose& T_WB : poses) {
    problem.AddResidualBlock(new PointReprojection(Observe(rig, T_WB, truth).head<2>(),
                                                   Eigen::Matrix2d::Identity(), Projection(rig)),
                             nullptr, T_WB.data(), p_W.data());
    problem.SetManifold(T_WB.data(), new PoseManifold);
    problem.SetParameterBlockConstant(T_WB.data());
  }
  SolveExactly(&problem);
  EXPECT_LT((p_W - truth).norm(), 1e-8);
}

TEST(PointReprojectionRgbd, WhitenedResidualsOfNoisyMeasurementsHaveUnitCovariance) {
  std::mt19937 rng(47);
  std::normal_distribution<double> normal;
  const twins::Rig rig = TestRig();
  const DepthNoise noise = DepthNoise::Kinect();
  constexpr double kSigmaPx = 0.8, kDepth = 2.0;
  const Eigen::Vector3d p_W = rig.T_BC * Eigen::Vector3d(0.3, -0.2, kDepth);
  const Eigen::Vector3d exact = Observe(rig, Pose(), p_W);
  const Eigen::Matrix3d W = PointSqrtInformation(Weighting::kCovariance, kSigmaPx,
                                                 noise.DisparitySigma(kDepth, rig.right));
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const double du = kSigmaPx * normal(rng), dv = kSigmaPx * normal(rng);
    const double depth = kDepth + noise.Sigma(kDepth) * normal(rng);
    const PointReprojectionRgbd f({exact.x() + du, exact.y() + dv, rig.right.Disparity(depth)}, W,
                                  Projection(rig));
    const Eigen::Vector3d r = Residual(f, {ToBlock(Pose()), ToBlock(p_W)});
    covariance += r * r.transpose() / kSamples;
  }
  // 20000 samples: standard error 0.01 on the diagonal, 0.007 off it.
  EXPECT_LT((covariance - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.04) << covariance;
}

TEST(PointReprojection, IsInactiveNearerThanTheMinimalDepth) {
  const twins::Rig rig = TestRig();
  const RgbdProjection projection(rig.camera, rig.T_BC, rig.right, 0.5);
  const PointReprojection f2({1.0, 2.0}, Eigen::Matrix2d::Identity(), projection);
  const PointReprojectionRgbd f3({1.0, 2.0, 3.0}, Eigen::Matrix3d::Identity(), projection);
  for (const double depth : {0.49, 0.0, -2.0}) {
    const Eigen::Vector3d p_W = rig.T_BC * Eigen::Vector3d(0.1, 0.2, depth);
    const std::vector<Block> blocks = {ToBlock(Pose()), ToBlock(p_W)};
    EXPECT_EQ(Residual(f2, blocks).norm(), 0.0) << depth;
    EXPECT_EQ(Residual(f3, blocks).norm(), 0.0) << depth;
    EXPECT_EQ(TangentJacobian(f2, blocks, kManifolds).norm(), 0.0) << depth;
    EXPECT_EQ(TangentJacobian(f3, blocks, kManifolds).norm(), 0.0) << depth;
  }
  const Eigen::Vector3d inside = rig.T_BC * Eigen::Vector3d(0.1, 0.2, 0.51);
  EXPECT_GT(Residual(f2, {ToBlock(Pose()), ToBlock(inside)}).norm(), 1.0);
}

TEST(PointReprojection, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const RgbdProjection projection = SimpleProjection();
  EXPECT_THROW(PointReprojection({nan, 0.0}, Eigen::Matrix2d::Identity(), projection),
               InvalidArgument);
  EXPECT_THROW(PointReprojection({0.0, 0.0}, Eigen::Matrix2d::Constant(nan), projection),
               InvalidArgument);
  EXPECT_THROW(PointReprojectionRgbd({0.0, 0.0, nan}, Eigen::Matrix3d::Identity(), projection),
               InvalidArgument);
  EXPECT_THROW(PointReprojectionRgbd({0.0, 0.0, 1.0}, Eigen::Matrix3d::Constant(nan), projection),
               InvalidArgument);
}

}  // namespace
}  // namespace highwall::point_reprojection_test
