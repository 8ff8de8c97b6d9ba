#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include <highwall/core/error.h>
#include <highwall/core/line3.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/testing/jacobian_check.h>
#include <highwall/factors/line_reprojection.h>

#include "reprojection_scene.h"
#include "solve_exactly.h"

namespace highwall::line_reprojection_test {
namespace {

const PoseManifold kPoseManifold;
const LineManifold kLineManifold;
const std::vector<const ceres::Manifold*> kSegmentManifolds = {&kPoseManifold, nullptr};
const std::vector<const ceres::Manifold*> kLineManifolds = {&kPoseManifold, &kLineManifold};
const Weighting kWeightings[] = {Weighting::kCovariance, Weighting::kPaper};

OrthonormalLine LineOf(const Segment3& segment) {
  return OrthonormalLine(PluckerLine::FromPoints(segment.p(), segment.q()));
}

RgbdSegment ObserveSegment(const twins::Rig& rig, const Pose& T_WB, const Segment3& segment) {
  return {Observe(rig, T_WB, segment.p()), Observe(rig, T_WB, segment.q())};
}

// Returns a segment in view that is at least 60 px long.
Segment3 RandomSegment(std::mt19937& rng, const twins::Rig& rig, const Pose& T_WB) {
  for (;;) {
    const Segment3 segment(RandomPointInView(rng, rig, T_WB), RandomPointInView(rng, rig, T_WB));
    const RgbdSegment seen = ObserveSegment(rig, T_WB, segment);
    if ((seen.e - seen.s).head<2>().norm() > 60.0) return segment;
  }
}

Eigen::Vector3d OffTheOptimum(std::mt19937& rng) {
  return {Uniform(rng, 3.0, 20.0), Uniform(rng, -20.0, -3.0), Uniform(rng, 0.3, 1.0)};
}

TEST(LineReprojection, MatchesHandComputedValues) {
  const RgbdSegment observed{{300.0, 200.0, 20.0}, {400.0, 200.0, 10.0}};
  // p at pixel (300, 208), 2.5 m: 8 px below the line. q at (390, 200), 5 m: on the line.
  const std::vector<Block> blocks = {ToBlock(Pose()),
                                     ToBlock(Segment3({-0.1, -0.2, 2.5}, {0.7, -0.5, 5.0}))};
  const LineReprojection left(SegmentRows({300.0, 200.0}, {400.0, 200.0}, 2.0), SimpleProjection());
  EXPECT_LT((Residual(left, blocks) - Eigen::Vector2d(4.0, 0.0)).norm(), 1e-12);

  // The measured disparity falls by 0.1 per px: it is 11 at q's pixel, where q has 10. Its sigma is
  // hypot(0.15, 0.1 * 2 px) = 0.25.
  const SegmentNoise noise{.px = 2.0, .disparity_s = 0.3, .disparity_e = 0.15};
  const LineReprojectionRgbd rgbd(SegmentRows(observed, noise, Weighting::kCovariance),
                                  SimpleProjection());
  EXPECT_LT((Residual(rgbd, blocks) - Eigen::Vector4d(4.0, 0.0, 0.0, -4.0)).norm(), 1e-12);
}

TEST(LineReprojection, PaperRowsMatchHandComputedValues) {
  const SegmentNoise noise{.px = 2.0, .disparity_s = 0.3, .disparity_e = 0.15};
  // The line is vertical at u = 300, and at u = 280 in the right image. p is on it, at 5 m instead
  // of 2.5 m, and so appears at u_R = 290. q (2.5 m) is 6 px off in both images. The normal points
  // to -u.
  const RgbdSegment observed{{300.0, 200.0, 20.0}, {300.0, 300.0, 20.0}};
  const std::vector<Block> blocks = {ToBlock(Pose()),
                                     ToBlock(Segment3({-0.2, -0.5, 5.0}, {-0.07, 0.375, 2.5}))};
  const LineReprojectionRgbd f(SegmentRows(observed, noise, Weighting::kPaper), SimpleProjection());
  EXPECT_LT((Residual(f, blocks) - Eigen::Vector4d(0.0, -5.0, -3.0, -3.0)).norm(), 1e-12);
}

TEST(OrthonormalLineReprojection, MatchesHandComputedValues) {
  // The image of the line: v = 208, disparity 20 at u = 300 and 10 at u = 400.
  const std::vector<Block> blocks = {
      ToBlock(Pose()), ToBlock(LineOf(Segment3({-0.1, -0.2, 2.5}, {0.8, -0.4, 5.0})))};
  const OrthonormalLineReprojection left({300.0, 200.0}, {400.0, 212.0}, 2.0, SimpleProjection());
  EXPECT_LT((Residual(left, blocks) - Eigen::Vector2d(-4.0, 2.0)).norm(), 1e-11);

  // 2 px of disparity off at e; sigma hypot(0.12, 0.08 * 2 px) = 0.2.
  const RgbdSegment observed{{300.0, 200.0, 20.0}, {400.0, 200.0, 12.0}};
  const SegmentNoise noise{.px = 2.0, .disparity_s = 0.3, .disparity_e = 0.12};
  const OrthonormalLineReprojectionRgbd rgbd(observed, noise, Weighting::kCovariance,
                                             SimpleProjection());
  EXPECT_LT((Residual(rgbd, blocks) - Eigen::Vector4d(-4.0, 0.0, -4.0, -10.0)).norm(), 1e-11);
  const OrthonormalLineReprojectionRgbd paper(observed, noise, Weighting::kPaper,
                                              SimpleProjection());
  EXPECT_LT((Residual(paper, blocks) - Eigen::Vector4d(-4.0, -4.0, -4.0, -4.0)).norm(), 1e-11);
}

TEST(LineReprojection, IsZeroAtTheTruth) {
  std::mt19937 rng(10);
  const twins::Rig rig = TestRig();
  for (int i = 0; i < 20; ++i) {
    const Pose T_WB = RandomPose(rng);
    const Segment3 segment = RandomSegment(rng, rig, T_WB);
    const RgbdSegment seen = ObserveSegment(rig, T_WB, segment);
    for (const Weighting weighting : kWeightings) {
      const LineReprojectionRgbd ends(SegmentRows(seen, {}, weighting), Projection(rig));
      const OrthonormalLineReprojectionRgbd line(seen, {}, weighting, Projection(rig));
      EXPECT_LT(Residual(ends, {ToBlock(T_WB), ToBlock(segment)}).norm(), 1e-10);
      EXPECT_LT(Residual(line, {ToBlock(T_WB), ToBlock(LineOf(segment))}).norm(), 1e-10);
    }
  }
}

// Checks all six factors at one state by central differences and the autodiff twin.
void CheckAllFactors(std::mt19937& rng, const twins::Rig& rig, const Pose& T_WB,
                     const Segment3& segment) {
  RgbdSegment observed = ObserveSegment(rig, T_WB, segment);
  observed.s += OffTheOptimum(rng);
  observed.e += OffTheOptimum(rng);
  const SegmentNoise noise{.px = 1.3, .disparity_s = 0.3, .disparity_e = 0.5};
  const Eigen::Vector2d s = observed.s.head<2>(), e = observed.e.head<2>();
  const RgbdProjection projection = Projection(rig);
  const std::vector<Block> ends = {ToBlock(T_WB), ToBlock(segment)};
  const std::vector<Block> line = {ToBlock(T_WB), ToBlock(LineOf(segment))};
  const auto check = [](const ceres::CostFunction& f, const ceres::CostFunction& twin,
                        const std::vector<Block>& blocks,
                        const std::vector<const ceres::Manifold*>& manifolds) {
    const auto result = testing::CheckJacobians(f, blocks, manifolds);
    EXPECT_TRUE(result) << result.message;
    ExpectTwins(f, twin, blocks, manifolds, 1e-10);
  };
  check(LineReprojection(SegmentRows(s, e, noise.px), projection),
        *MakeLine(twins::Segment{rig, observed, noise, {}, false}), ends, kSegmentManifolds);
  check(OrthonormalLineReprojection(s, e, noise.px, projection),
        *MakeLine(twins::OrthonormalLine{rig, observed, noise, {}, false}), line, kLineManifolds);
  for (const Weighting weighting : kWeightings) {
    SCOPED_TRACE(ToString(weighting));
    check(LineReprojectionRgbd(SegmentRows(observed, noise, weighting), projection),
          *MakeLine(twins::Segment{rig, observed, noise, weighting}), ends, kSegmentManifolds);
    check(OrthonormalLineReprojectionRgbd(observed, noise, weighting, projection),
          *MakeLine(twins::OrthonormalLine{rig, observed, noise, weighting}), line, kLineManifolds);
  }
}

TEST(LineReprojection, JacobiansMatchCentralDifferencesAndTheAutodiffTwin) {
  std::mt19937 rng(11);
  const twins::Rig rig = TestRig();
  AtRandomPoses(rng, [&](const Pose& T_WB) {
    CheckAllFactors(rng, rig, T_WB, RandomSegment(rng, rig, T_WB));
  });
}

TEST(LineReprojection, JacobiansHoldAtTheEdges) {
  std::mt19937 rng(12);
  const twins::Rig rig = TestRig();
  AtEdgesOfRotation([&](const Pose& T_WB) {
    const Pose T_WC = T_WB * rig.T_BC;
    CheckAllFactors(rng, rig, T_WB, RandomSegment(rng, rig, T_WB));
    // p is just inside the depth limit, and the factor is smooth within a step of 1e-6.
    const double depth = RgbdProjection::kDefaultMinDepth + 1e-5;
    CheckAllFactors(rng, rig, T_WB, T_WC * Segment3({0.06, 0.05, depth}, {0.56, -0.45, 1.55}));
    // The whole line is just beyond the minimal distance to the optical centre.
    CheckAllFactors(rng, rig, T_WB, T_WC * Segment3({-0.02, 0.0, depth}, {0.03, 0.0, depth}));
    // Vertical and horizontal in the image, and of constant depth.
    CheckAllFactors(rng, rig, T_WB, T_WC * Segment3({0.1, -0.5, 2.0}, {0.1, 0.5, 2.0}));
    CheckAllFactors(rng, rig, T_WB, T_WC * Segment3({-0.5, 0.1, 2.0}, {0.5, 0.1, 2.0}));
    // Through the origin of the world: w_1 = 0.
    const Eigen::Vector3d p = RandomPointInView(rng, rig, T_WB);
    CheckAllFactors(rng, rig, T_WB, Segment3(p, 1.3 * p));
  });
}

TEST(LineReprojection, DoesNotChangeWhenTheWorldFrameMoves) {
  std::mt19937 rng(13);
  const twins::Rig rig = TestRig();
  for (int i = 0; i < 20; ++i) {
    const Pose T_WB = RandomPose(rng), T_NW = RandomPose(rng);
    const Segment3 segment = RandomSegment(rng, rig, T_WB);
    RgbdSegment observed = ObserveSegment(rig, T_WB, segment);
    observed.s += OffTheOptimum(rng);
    const Block pose = ToBlock(T_WB), moved_pose = ToBlock(T_NW * T_WB);
    for (const Weighting weighting : kWeightings) {
      const LineReprojectionRgbd ends(SegmentRows(observed, {}, weighting), Projection(rig));
      const OrthonormalLineReprojectionRgbd line(observed, {}, weighting, Projection(rig));
      // Pixels of magnitude 500 and metres of magnitude 5 in double precision.
      EXPECT_LT((Residual(ends, {pose, ToBlock(segment)}) -
                 Residual(ends, {moved_pose, ToBlock(T_NW * segment)}))
                    .norm(),
                1e-10);
      EXPECT_LT((Residual(line, {pose, ToBlock(LineOf(segment))}) -
                 Residual(line, {moved_pose, ToBlock(LineOf(T_NW * segment))}))
                    .norm(),
                1e-10);
    }
  }
}

// Without depth the scale of the world is unobservable. With depth a change of scale is visible.
TEST(LineReprojection, RowsWithoutDepthDoNotChangeWhenTheWorldGrows) {
  std::mt19937 rng(19);
  const twins::Rig rig = TestRig();
  const RgbdProjection projection(rig.camera, Pose());  // the body is the camera
  for (int i = 0; i < 20; ++i) {
    const Pose T_WB = RandomPose(rng);
    const Segment3 segment = T_WB * Segment3({Uniform(rng, -1, 0), -0.5, 2.0}, {0.5, 0.4, 3.0});
    const RgbdSegment seen{{300.0, 200.0, 20.0}, {400.0, Uniform(rng, 220, 300), 10.0}};
    const Pose grown_pose = Pose(T_WB.q(), 1.7 * T_WB.p());
    const Segment3 grown(1.7 * segment.p(), 1.7 * segment.q());
    const std::vector<Block> ends{ToBlock(T_WB), ToBlock(segment)};
    const std::vector<Block> grown_ends{ToBlock(grown_pose), ToBlock(grown)};
    const std::vector<Block> line{ToBlock(T_WB), ToBlock(LineOf(segment))};
    const std::vector<Block> grown_line{ToBlock(grown_pose), ToBlock(LineOf(grown))};
    const LineReprojection left(SegmentRows(seen.s.head<2>(), seen.e.head<2>(), 1.0), projection);
    const OrthonormalLineReprojection left_line(seen.s.head<2>(), seen.e.head<2>(), 1.0,
                                                projection);
    const OrthonormalLineReprojectionRgbd with_depth(seen, {}, Weighting::kCovariance, projection);
    EXPECT_GT(Residual(left, ends).norm(), 0.1);
    // Pixels of magnitude 500 in double precision.
    EXPECT_LT((Residual(left, ends) - Residual(left, grown_ends)).norm(), 1e-9);
    EXPECT_LT((Residual(left_line, line) - Residual(left_line, grown_line)).norm(), 1e-9);
    EXPECT_GT((Residual(with_depth, line) - Residual(with_depth, grown_line)).norm(), 0.1);
  }
}

// The two rows of a view determine the plane through its camera that contains the line: two of the
// line's four degrees of freedom. A second view determines the other two, unless it has the same
// plane.
TEST(OrthonormalLineReprojection, AViewWithoutDepthHoldsThePlaneThroughCameraAndLine) {
  const RgbdProjection projection(PinholeCamera{}, Pose());
  const Segment3 segment({-0.4, 0.3, 2.0}, {0.5, -0.2, 2.6});
  const Eigen::Vector3d along = segment.q() - segment.p();
  const OrthonormalLine line = LineOf(segment);
  const auto rank = [&](const std::vector<Eigen::Vector3d>& cameras) {
    Eigen::MatrixXd J(2 * static_cast<Eigen::Index>(cameras.size()), 4);
    Eigen::Matrix<double, 6, 4, Eigen::RowMajor> plus;
    kLineManifold.PlusJacobian(line.data(), plus.data());
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const Pose T_WB(Eigen::Quaterniond::Identity(), cameras[i]);
      const PinholeCamera camera;
      const OrthonormalLineReprojection factor(camera.Project(segment.p() - cameras[i]),
                                               camera.Project(segment.q() - cameras[i]), 1.0,
                                               projection);
      const double* blocks[] = {T_WB.data(), line.data()};
      Eigen::Vector2d r;
      Eigen::Matrix<double, 2, 6, Eigen::RowMajor> ambient;
      double* jacobians[] = {nullptr, ambient.data()};
      factor.Evaluate(blocks, r.data(), jacobians);
      J.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = ambient * plus;
    }
    Eigen::FullPivLU<Eigen::MatrixXd> lu(J);
    lu.setThreshold(1e-9);
    return lu.rank();
  };
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero(), aside(0.1, 0.3, 0.0);
  EXPECT_EQ(rank({origin}), 2);
  EXPECT_EQ(rank({origin, aside}), 4);
  EXPECT_EQ(rank({origin, 0.2 * along, 0.3 * along}), 2) << "along the line";
  EXPECT_EQ(rank({origin, 0.1 * segment.p(), 0.2 * segment.q()}), 2) << "within its plane";
}

TEST(LineReprojection, DoesNotChangeWhenTheObservedEndsSlideAlongTheLine) {
  std::mt19937 rng(14);
  const twins::Rig rig = TestRig();
  const RgbdProjection projection = Projection(rig);
  for (int i = 0; i < 20; ++i) {
    const Pose T_WB = RandomPose(rng);
    const Segment3 segment = RandomSegment(rng, rig, T_WB);
    RgbdSegment observed = ObserveSegment(rig, T_WB, segment);
    observed.s += OffTheOptimum(rng);
    const Eigen::Vector3d along = observed.e - observed.s;
    const RgbdSegment slid{observed.s + 0.2 * along, observed.e - 0.1 * along};
    const std::vector<Block> blocks = {ToBlock(T_WB), ToBlock(segment)};
    const LineReprojection left(SegmentRows(observed.s.head<2>(), observed.e.head<2>(), 1.0),
                                projection);
    const LineReprojection left_slid(SegmentRows(slid.s.head<2>(), slid.e.head<2>(), 1.0),
                                     projection);
    EXPECT_GT(Residual(left, blocks).norm(), 1e-3);
    EXPECT_LT((Residual(left, blocks) - Residual(left_slid, blocks)).norm(), 1e-10);
    // If the disparity is shifted along as well, the rows with depth do not change either.
    for (const Weighting weighting : kWeightings) {
      const LineReprojectionRgbd f(SegmentRows(observed, {}, weighting), projection);
      const LineReprojectionRgbd f_slid(SegmentRows(slid, {}, weighting), projection);
      EXPECT_LT((Residual(f, blocks) - Residual(f_slid, blocks)).norm(), 1e-10);
    }
  }
}

TEST(LineReprojection, PaperRowIsACombinationOfTheTwoFormsAcrossTheLine) {
  std::mt19937 rng(18);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d middle(320.0, 240.0, 30.0);
    const RgbdSegment z{middle + RandomVector(rng, 25.0), middle + RandomVector(rng, 25.0)};
    const SegmentNoise unit;
    const auto paper = SegmentRows(z, unit, Weighting::kPaper);
    const auto covariance = SegmentRows(z, unit, Weighting::kCovariance);
    const Eigen::RowVector3d right = paper[0].A.row(1);
    const double sigma_2 = 1.0 / covariance[0].A(1, 2);
    // alpha = (a_R, b_R) . (a, b), and -a_R is the factor of delta.
    const double alpha = right.head<2>().dot(paper[0].A.row(0).head<2>());
    const Eigen::RowVector2d combine(alpha, -right(0) * sigma_2);
    EXPECT_LT((combine * covariance[0].A - right).norm(), 1e-12);
    EXPECT_NEAR(combine * covariance[0].b, paper[0].b(1), 1e-9);
  }
}

TEST(LineReprojection, LineAlongTheBaselineHasDepthInTheCovarianceRowsOnly) {
  const RgbdSegment level{{300.0, 200.0, 20.0}, {400.0, 200.0, 20.0}};
  // On the image line, but at 5 m instead of 2.5 m.
  const Segment3 segment({-0.2, -0.5, 5.0}, {0.8, -0.5, 5.0});
  const std::vector<Block> blocks = {ToBlock(Pose()), ToBlock(segment)};
  const LineReprojectionRgbd paper(SegmentRows(level, {}, Weighting::kPaper), SimpleProjection());
  EXPECT_LT(Residual(paper, blocks).norm(), 1e-12);
  const LineReprojectionRgbd covariance(SegmentRows(level, {}, Weighting::kCovariance),
                                        SimpleProjection());
  EXPECT_LT((Residual(covariance, blocks) - Eigen::Vector4d(0.0, -10.0, 0.0, -10.0)).norm(), 1e-12);
}

// Computes the sample covariance of whitened residuals at the truth under pixel and depth noise.
TEST(LineReprojection, WhitenedResidualsOfNoisyMeasurementsHaveUnitCovariance) {
  std::mt19937 rng(15);
  std::normal_distribution<double> normal;
  const twins::Rig rig = TestRig();
  const DepthNoise depth_noise = DepthNoise::Kinect();
  constexpr double kSigmaPx = 0.8, kDepth[2] = {1.0, 2.2};
  // The line is oblique in the image and steep in depth, so all terms of the covariance matter.
  const Segment3 segment = rig.T_BC * Segment3({0.2, -0.1, kDepth[0]}, {-0.25, 0.15, kDepth[1]});
  const RgbdSegment exact = ObserveSegment(rig, Pose(), segment);
  const SegmentNoise noise{.px = kSigmaPx,
                           .disparity_s = depth_noise.DisparitySigma(kDepth[0], rig.right),
                           .disparity_e = depth_noise.DisparitySigma(kDepth[1], rig.right)};
  const auto noisy = [&](const Eigen::Vector3d& y, double depth) {
    const double du = kSigmaPx * normal(rng), dv = kSigmaPx * normal(rng);
    const double z = depth + depth_noise.Sigma(depth) * normal(rng);
    return Eigen::Vector3d(y.x() + du, y.y() + dv, rig.right.Disparity(z));
  };
  const std::vector<Block> ends = {ToBlock(Pose()), ToBlock(segment)};
  const std::vector<Block> line = {ToBlock(Pose()), ToBlock(LineOf(segment))};
  const RgbdProjection projection = Projection(rig);
  Eigen::Matrix4d C_ends = Eigen::Matrix4d::Zero(), C_line = C_ends;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const RgbdSegment z{noisy(exact.s, kDepth[0]), noisy(exact.e, kDepth[1])};
    const Eigen::Vector4d r_ends = Residual(
        LineReprojectionRgbd(SegmentRows(z, noise, Weighting::kCovariance), projection), ends);
    const Eigen::Vector4d r_line = Residual(
        OrthonormalLineReprojectionRgbd(z, noise, Weighting::kCovariance, projection), line);
    C_ends += r_ends * r_ends.transpose() / kSamples;
    C_line += r_line * r_line.transpose() / kSamples;
  }
  // 20000 samples: standard error 0.01 on the diagonal, 0.007 off it.
  EXPECT_LT((C_ends - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 0.04) << C_ends;
  EXPECT_LT((C_line - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 0.04) << C_line;
}

void SolveToRounding(ceres::Problem* problem) {
  const ceres::Solver::Summary summary = SolveExactly(problem);
  EXPECT_LT(summary.final_cost, 1e-14) << summary.BriefReport();
}

Eigen::Matrix<double, 6, 1> Perturbation() {
  return (Eigen::Matrix<double, 6, 1>() << 0.05, -0.05, 0.05, 0.05, 0.05, -0.05).finished();
}

TEST(LineReprojection, BothFormsSolveForAPerturbedPose) {
  std::mt19937 rng(16);
  const twins::Rig rig = TestRig();
  for (const Weighting weighting : kWeightings) {
    for (const bool has_ends : {true, false}) {
      const Pose truth = RandomPose(rng);
      Pose T_WB = truth.Plus(Perturbation());
      std::vector<Segment3> segments;
      for (int i = 0; i < 10; ++i) segments.push_back(RandomSegment(rng, rig, truth));
      std::vector<OrthonormalLine> lines;
      for (const Segment3& segment : segments) lines.push_back(LineOf(segment));
      ceres::Problem problem;
      problem.AddParameterBlock(T_WB.data(), Pose::kSize, new PoseManifold);
      for (std::size_t i = 0; i < segments.size(); ++i) {
        const RgbdSegment seen = ObserveSegment(rig, truth, segments[i]);
        double* block = has_ends ? segments[i].data() : lines[i].data();
        if (has_ends) {
          problem.AddResidualBlock(
              new LineReprojectionRgbd(SegmentRows(seen, {}, weighting), Projection(rig)), nullptr,
              T_WB.data(), block);
        } else {
          problem.AddResidualBlock(
              new OrthonormalLineReprojectionRgbd(seen, {}, weighting, Projection(rig)), nullptr,
              T_WB.data(), block);
        }
        problem.SetParameterBlockConstant(block);
      }
      SolveToRounding(&problem);
      EXPECT_LT((T_WB.p() - truth.p()).norm(), 1e-7) << ToString(weighting) << has_ends;
      EXPECT_LT((truth.Inverse() * T_WB).Angle(), 1e-7) << ToString(weighting) << has_ends;
    }
  }
}

TEST(OrthonormalLineReprojection, TwoViewsSolveForThePerturbedLine) {
  std::mt19937 rng(17);
  const twins::Rig rig = TestRig();
  std::vector<Pose> poses = {RandomPose(rng)};
  poses.push_back(poses[0].Plus(3.0 * Perturbation()));
  const Segment3 segment = RandomSegment(rng, rig, poses[0]);
  const OrthonormalLine truth = LineOf(segment);
  OrthonormalLine line = truth;
  const Eigen::Vector4d step(0.02, -0.02, 0.02, 0.02);
  kLineManifold.Plus(truth.data(), step.data(), line.data());
  ASSERT_GT(line.Plucker().Distance(segment.p()), 0.01);
  ceres::Problem problem;
  problem.AddParameterBlock(line.data(), OrthonormalLine::kSize, new LineManifold);
  for (Pose& T_WB : poses) {
    const RgbdSegment seen = ObserveSegment(rig, T_WB, segment);
    problem.AddResidualBlock(
        new OrthonormalLineReprojection(seen.s.head<2>(), seen.e.head<2>(), 1.0, Projection(rig)),
        nullptr, T_WB.data(), line.data());
    problem.SetParameterBlockConstant(T_WB.data());
  }
  SolveToRounding(&problem);
  EXPECT_LT(line.Plucker().Distance(segment.p()), 1e-7);
  EXPECT_LT(line.Plucker().Distance(segment.q()), 1e-7);
}

TEST(LineReprojection, AnEndBehindTheCameraIsInactiveAndTheOtherIsNot) {
  const twins::Rig rig = TestRig();
  const RgbdSegment observed{{300.0, 200.0, 20.0}, {400.0, 220.0, 10.0}};
  const std::vector<Block> blocks = {
      ToBlock(Pose()), ToBlock(rig.T_BC * Segment3({0.1, 0.1, -1.0}, {0.3, 0.4, 2.0}))};
  const LineReprojection left(SegmentRows({300.0, 200.0}, {400.0, 220.0}, 1.0), Projection(rig));
  EXPECT_EQ(Residual(left, blocks)(0), 0.0);
  EXPECT_NE(Residual(left, blocks)(1), 0.0);
  for (const Weighting weighting : kWeightings) {
    const LineReprojectionRgbd f(SegmentRows(observed, {}, weighting), Projection(rig));
    const Eigen::VectorXd r = Residual(f, blocks);
    const Eigen::MatrixXd J = TangentJacobian(f, blocks, kSegmentManifolds);
    EXPECT_EQ(r.head<2>().norm(), 0.0);
    EXPECT_EQ(J.topRows<2>().norm(), 0.0);
    EXPECT_GT(r.tail<2>().norm(), 1.0);
    EXPECT_GT(J.bottomRows<2>().norm(), 1.0);
  }
}

TEST(OrthonormalLineReprojection, IsInactiveWhereTheLineHasNoImage) {
  const twins::Rig rig = TestRig();
  const RgbdSegment observed{{300.0, 200.0, 20.0}, {400.0, 220.0, 10.0}};
  const OrthonormalLineReprojection left({300.0, 200.0}, {400.0, 220.0}, 1.0, Projection(rig));
  const Segment3 degenerate[] = {
      Segment3({0.1, 0.2, 1.0}, {0.2, 0.4, 2.0}),      // through the optical centre
      Segment3({0.14, 0.2, 1.0}, {0.24, 0.4, 2.0}),    // 0.036 m away from it
      Segment3({-1.0, 0.3, 0.0}, {1.0, 0.3, 0.0}),     // in the plane z = 0
      Segment3({-1.0, 0.3, 0.001}, {1.0, 0.3, 0.001})  // 89.8 degrees off the axis
  };
  for (const Segment3& segment : degenerate) {
    const std::vector<Block> blocks = {ToBlock(Pose()), ToBlock(LineOf(rig.T_BC * segment))};
    EXPECT_EQ(Residual(left, blocks).norm(), 0.0);
    EXPECT_EQ(TangentJacobian(left, blocks, kLineManifolds).norm(), 0.0);
    for (const Weighting weighting : kWeightings) {
      const OrthonormalLineReprojectionRgbd f(observed, {}, weighting, Projection(rig));
      EXPECT_EQ(Residual(f, blocks).norm(), 0.0);
      EXPECT_EQ(TangentJacobian(f, blocks, kLineManifolds).norm(), 0.0);
    }
  }
  // A line through the centre of the virtual right camera has no right image, but has a disparity.
  const Eigen::Vector3d p_CV(rig.right.baseline, 0.0, 0.0);
  const Segment3 right(p_CV + Eigen::Vector3d(0.0, 0.2, 1.0),
                       p_CV + Eigen::Vector3d(0.0, 0.4, 2.0));
  const std::vector<Block> blocks = {ToBlock(Pose()), ToBlock(LineOf(rig.T_BC * right))};
  const OrthonormalLineReprojectionRgbd paper(observed, {}, Weighting::kPaper, Projection(rig));
  EXPECT_EQ(Residual(paper, blocks).norm(), 0.0);
  const OrthonormalLineReprojectionRgbd covariance(observed, {}, Weighting::kCovariance,
                                                   Projection(rig));
  EXPECT_GT(Residual(covariance, blocks).norm(), 1.0);
}

TEST(LineReprojection, RefusesBadArguments) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const RgbdSegment good{{300.0, 200.0, 20.0}, {400.0, 200.0, 10.0}};
  RgbdSegment segment = good;
  const auto expect_refused = [&](const RgbdSegment& z, const SegmentNoise& noise,
                                  const std::string& name) {
    for (const Weighting weighting : kWeightings) {
      try {
        SegmentRows(z, noise, weighting);
        ADD_FAILURE() << name;
      } catch (const InvalidArgument& e) {
        EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
      }
      EXPECT_THROW(OrthonormalLineReprojectionRgbd(z, noise, weighting, SimpleProjection()),
                   InvalidArgument);
    }
  };
  expect_refused(good, {.px = 0.0}, "SegmentNoise::px");
  expect_refused(good, {.disparity_s = -1.0}, "SegmentNoise::disparity_s");
  expect_refused(good, {.disparity_e = nan}, "SegmentNoise::disparity_e");
  segment.s.y() = nan;
  expect_refused(segment, {}, "both ends must be finite");
  segment = good;
  segment.e.head<2>() = good.s.head<2>() + Eigen::Vector2d(0.5, 0.5);
  expect_refused(segment, {}, "closer than 1 px");
  segment = good;
  segment.e.z() = 0.0;
  expect_refused(segment, {}, "disparity of e");

  EXPECT_THROW(SegmentRows({0.0, 0.0}, {0.0, 0.5}, 1.0), InvalidArgument);
  EXPECT_THROW(SegmentRows({0.0, 0.0}, {0.0, 9.0}, 0.0), InvalidArgument);
  EXPECT_THROW(OrthonormalLineReprojection({0.0, 0.0}, {nan, 9.0}, 1.0, SimpleProjection()),
               InvalidArgument);
  // The virtual right camera sees the line end on, so the paper's right line does not exist.
  const RgbdSegment end_on{{300.0, 200.0, 20.0}, {310.0, 200.0, 30.0}};
  EXPECT_NO_THROW(SegmentRows(end_on, {}, Weighting::kCovariance));
  EXPECT_THROW(SegmentRows(end_on, {}, Weighting::kPaper), InvalidArgument);
}

}  // namespace
}  // namespace highwall::line_reprojection_test
