#include <highwall/core/marginalization.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <highwall/core/error.h>
#include <highwall/core/line3.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/testing/jacobian_check.h>

#include "point_observation.h"
#include "random_states.h"

namespace highwall::marginalization_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// An observation of the bearing of a point only.
struct Bearing {
  Eigen::Vector2d z;
  template <class S>
  bool operator()(const S* pose, const S* x, S* r) const {
    const Eigen::Map<const Eigen::Matrix<S, 3, 1>> p(pose), point(x);
    const Eigen::Map<const Eigen::Quaternion<S>> q(pose + 3);
    const Eigen::Matrix<S, 3, 1> p_B = q.conjugate() * (point - p);
    r[0] = p_B.x() / p_B.z() - z.x();
    r[1] = p_B.y() / p_B.z() - z.y();
    return true;
  }
};

// A raw ceres::Problem with poses and points, away from its optimum.
struct Scene {
  explicit Scene(unsigned seed, int num_poses = 4, int num_points = 12) : random(seed) {
    for (int i = 0; i < num_poses; ++i) {
      poses.push_back(random.RandomPose(1.0, 0.4));
      estimates.push_back(poses.back().Plus(random.Matrix<6>().col(0) * 0.05));
    }
    for (int j = 0; j < num_points; ++j) {
      truth.emplace_back(random.Vector(2.0) + Eigen::Vector3d(0, 0, 6.0));
      points.emplace_back(truth.back() + random.Vector(0.05));
    }
    for (Pose& pose : estimates) problem.AddParameterBlock(pose.data(), 7, new PoseManifold);
    for (Point& point : points) problem.AddParameterBlock(point.data(), 3);
  }
  double* pose(std::size_t i) { return estimates[i].data(); }
  double* point(std::size_t j) { return points[j].data(); }

  void See(std::size_t i, std::size_t j, ceres::LossFunction* loss = nullptr) {
    const Eigen::Vector3d z = poses[i].Inverse() * truth[j] + random.Vector(0.05);
    problem.AddResidualBlock(MakeObservation(z).release(), loss, pose(i), point(j));
  }
  void SeeEverything() {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      for (std::size_t j = 0; j < points.size(); ++j) See(i, j);
    }
  }
  void Link(std::size_t i, std::size_t j) {
    problem.AddResidualBlock(new RelativePose(poses[i].Inverse() * poses[j], 3.0 * W()), nullptr,
                             pose(i), pose(j));
  }
  void Anchor(std::size_t i) {
    problem.AddResidualBlock(new PosePrior(poses[i], W()), nullptr, pose(i));
  }
  Matrix6 W() { return 2.0 * Matrix6::Identity() + 0.3 * random.Matrix<6>(); }

  RandomStates random;
  std::vector<Pose> poses, estimates;
  std::vector<Point> truth, points;
  ceres::Problem problem;
};

struct Information {
  Eigen::MatrixXd Lambda;
  Eigen::VectorXd g;
};

// Computes the Gauss-Newton matrix and gradient of the residuals that touch `touching`, over
// [removed, kept], as Ceres itself linearizes them (other blocks count as known), then the Schur
// complement on `kept`.
Information SchurComplement(ceres::Problem& problem, const std::vector<double*>& touching,
                            const std::vector<double*>& removed, const std::vector<double*>& kept) {
  ceres::Problem::EvaluateOptions options;
  for (double* block : touching) {
    std::vector<ceres::ResidualBlockId> ids;
    problem.GetResidualBlocksForParameterBlock(block, &ids);
    for (const ceres::ResidualBlockId id : ids) {
      auto& all = options.residual_blocks;
      if (std::find(all.begin(), all.end(), id) == all.end()) all.push_back(id);
    }
  }
  options.parameter_blocks = removed;
  options.parameter_blocks.insert(options.parameter_blocks.end(), kept.begin(), kept.end());
  std::vector<double> r;
  ceres::CRSMatrix sparse;
  EXPECT_TRUE(problem.Evaluate(options, nullptr, &r, nullptr, &sparse));
  RowMajor J = RowMajor::Zero(sparse.num_rows, sparse.num_cols);
  for (int i = 0; i < sparse.num_rows; ++i) {
    for (int k = sparse.rows[static_cast<std::size_t>(i)];
         k < sparse.rows[static_cast<std::size_t>(i) + 1]; ++k) {
      J(i, sparse.cols[static_cast<std::size_t>(k)]) = sparse.values[static_cast<std::size_t>(k)];
    }
  }
  Eigen::Index m = 0;
  for (const double* block : removed) m += problem.ParameterBlockTangentSize(block);
  const Eigen::MatrixXd H = J.transpose() * J;
  const Eigen::VectorXd g = J.transpose() * Eigen::Map<Eigen::VectorXd>(r.data(), J.rows());
  const Eigen::Index n = H.rows() - m;
  // The pseudo-inverse also covers rank-deficient problems.
  const Eigen::MatrixXd H_mm_inverse =
      H.topLeftCorner(m, m).completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::MatrixXd K = H.bottomLeftCorner(n, m) * H_mm_inverse;
  return {H.bottomRightCorner(n, n) - K * H.topRightCorner(m, n), g.tail(n) - K * g.head(m)};
}

Information SchurComplement(ceres::Problem& problem, const std::vector<double*>& removed,
                            const std::vector<double*>& kept) {
  return SchurComplement(problem, removed, removed, kept);
}

// The same information from a prior, which must list the blocks in the order `kept`.
void ExpectEqual(const Marginal& marginal, const std::vector<double*>& kept,
                 const Information& expected, double tolerance) {
  ASSERT_NE(marginal.prior, nullptr);
  ASSERT_EQ(marginal.blocks.size(), kept.size());
  Eigen::MatrixXd A(marginal.prior->A().rows(), marginal.prior->A().cols());
  Eigen::Index column = 0;
  for (const double* block : kept) {
    const auto at = std::find(marginal.blocks.begin(), marginal.blocks.end(), block);
    ASSERT_NE(at, marginal.blocks.end());
    const auto i = static_cast<std::size_t>(at - marginal.blocks.begin());
    const Eigen::Index size = marginal.prior->TangentSize(i);
    A.middleCols(column, size) = marginal.prior->A().middleCols(marginal.prior->Column(i), size);
    column += size;
  }
  const double scale = expected.Lambda.cwiseAbs().maxCoeff();
  EXPECT_LT((A.transpose() * A - expected.Lambda).cwiseAbs().maxCoeff(), tolerance * scale);
  EXPECT_LT((A.transpose() * marginal.prior->b() - expected.g).cwiseAbs().maxCoeff(),
            tolerance * (scale + expected.g.cwiseAbs().maxCoeff()));
}

// Ratio of the largest to the smallest nonzero singular value of A with its columns scaled to unit
// length.
double ConditionBySvd(const MarginalPrior& prior) {
  const Eigen::MatrixXd A = prior.A() * prior.A().colwise().norm().cwiseInverse().asDiagonal();
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(A).singularValues();
  return singular[0] / singular[A.rows() - 1];
}

TEST(Marginalization, EqualsTheSchurComplement) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Scene scene(seed);
    scene.SeeEverything();
    scene.Anchor(0);
    scene.Link(0, 1);
    scene.Link(1, 2);
    std::vector<double*> removed = {scene.pose(0)};
    for (std::size_t j = 0; j < 8; ++j) removed.push_back(scene.point(j));
    std::vector<double*> kept = {scene.pose(1), scene.pose(2), scene.pose(3)};
    for (std::size_t j = 8; j < 12; ++j) kept.push_back(scene.point(j));
    const Marginal marginal = Marginalize(scene.problem, removed);
    ExpectEqual(marginal, kept, SchurComplement(scene.problem, removed, kept), 1e-9);
    EXPECT_EQ(marginal.report.factors, 4 * 8 + 4 + 1 + 1);
    EXPECT_EQ(marginal.report.rows, 3 * 36 + 12);
    EXPECT_EQ(marginal.report.removed_dimensions, 6 + 24);
    EXPECT_EQ(marginal.report.removed_rank, 6 + 24);
    EXPECT_EQ(marginal.report.dimensions, 18 + 12);
    EXPECT_EQ(marginal.report.rank, 30);
    EXPECT_EQ(marginal.report.null_space, 0);
    EXPECT_GT(marginal.report.condition, 1.0);
    EXPECT_NEAR(marginal.report.condition / ConditionBySvd(*marginal.prior), 1.0, 1e-9);
  }
}

TEST(Marginalization, AppliesRobustLossesAsCeresDoes) {
  Scene scene(21);
  ceres::HuberLoss huber(0.05);
  ceres::CauchyLoss cauchy(0.03);
  ceres::TukeyLoss tukey(0.1);  // some residuals exceed it and get weight 0
  ceres::LossFunction* losses[] = {&huber, &cauchy, &tukey, nullptr};
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.cost_function_ownership = ceres::TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  for (Pose& pose : scene.estimates) problem.AddParameterBlock(pose.data(), 7, new PoseManifold);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 12; ++j) {
      const Eigen::Vector3d z = scene.poses[i].Inverse() * scene.truth[j];
      problem.AddResidualBlock(MakeObservation(z).release(), losses[(i + j) % 4], scene.pose(i),
                               scene.point(j));
    }
  }
  std::vector<double*> removed;
  for (std::size_t j = 0; j < 12; ++j) removed.push_back(scene.point(j));
  const std::vector<double*> kept = {scene.pose(0), scene.pose(1), scene.pose(2), scene.pose(3)};
  ExpectEqual(Marginalize(problem, removed), kept, SchurComplement(problem, removed, kept), 1e-9);
}

TEST(Marginalization, WithoutAGaugeKeepsTheNullSpaceAndStaysSemidefinite) {
  Scene scene(3);
  scene.SeeEverything();
  std::vector<double*> removed = {scene.pose(0)};
  for (std::size_t j = 0; j < 12; ++j) removed.push_back(scene.point(j));
  const std::vector<double*> kept = {scene.pose(1), scene.pose(2), scene.pose(3)};
  const Marginal marginal = Marginalize(scene.problem, removed);
  EXPECT_EQ(marginal.report.rank, 12);
  EXPECT_EQ(marginal.report.null_space, 6);   // a common translation and rotation
  EXPECT_LT(marginal.report.condition, 1e6);  // of the observable part
  EXPECT_NEAR(marginal.report.condition / ConditionBySvd(*marginal.prior), 1.0, 1e-9);
  ExpectEqual(marginal, kept, SchurComplement(scene.problem, removed, kept), 1e-9);

  const Eigen::MatrixXd Lambda = marginal.prior->A().transpose() * marginal.prior->A();
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Lambda).eigenvalues();
  EXPECT_GT(eigenvalues[0], -1e-12 * eigenvalues[17]);
  EXPECT_LT(eigenvalues[5], 1e-12 * eigenvalues[17]);
  EXPECT_GT(eigenvalues[6], 1e-6 * eigenvalues[17]);
}

TEST(Marginalization, ADirectionThatNothingObservesTakesNoInformationAway) {
  // One bearing does not give the depth of a point, and the information on the pose must not
  // suffer.
  Scene scene(4, 2, 1);
  scene.Anchor(0);
  scene.Link(0, 1);
  const auto bearing = [&](std::size_t i) {
    const Eigen::Vector3d p_B = scene.poses[i].Inverse() * scene.truth[0];
    scene.problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Bearing, 2, 7, 3>(
            new Bearing{Eigen::Vector2d(p_B.x() / p_B.z() + 0.01, p_B.y() / p_B.z())}),
        nullptr, scene.pose(i), scene.point(0));
  };
  bearing(0);
  double* point = scene.point(0);
  Marginal marginal = Marginalize(scene.problem, std::vector<double*>{point});
  EXPECT_EQ(marginal.report.removed_rank, 2);
  EXPECT_EQ(marginal.report.removed_dimensions, 3);
  EXPECT_EQ(marginal.prior, nullptr);  // both rows are consumed by the point
  bearing(1);
  marginal = Marginalize(scene.problem, std::vector<double*>{point});
  EXPECT_EQ(marginal.report.removed_rank, 3);
  EXPECT_EQ(marginal.report.rank, 1);  // the epipolar constraint
  EXPECT_EQ(marginal.report.null_space, 11);
}

TEST(Marginalization, OneByOneEqualsAllAtOnce) {
  // An earlier prior is a residual like any other; at fixed linearization points nothing is lost.
  Scene scene(5);
  scene.SeeEverything();
  scene.Anchor(0);
  std::vector<double*> removed = {scene.pose(0), scene.pose(1)};
  for (std::size_t j = 0; j < 12; ++j) removed.push_back(scene.point(j));
  const std::vector<double*> kept = {scene.pose(2), scene.pose(3)};
  const Information at_once = SchurComplement(scene.problem, removed, kept);

  std::vector<double*> points(removed.begin() + 2, removed.end());
  for (const std::vector<double*>& some :
       {points, std::vector<double*>{scene.pose(0)}, std::vector<double*>{scene.pose(1)}}) {
    Marginal marginal = Marginalize(scene.problem, some);
    for (double* block : some) scene.problem.RemoveParameterBlock(block);
    ASSERT_NE(marginal.prior, nullptr);
    if (scene.problem.NumParameterBlocks() == 2) {
      ExpectEqual(marginal, kept, at_once, 1e-9);
      return;
    }
    scene.problem.AddResidualBlock(marginal.prior.release(), nullptr, marginal.blocks);
  }
  FAIL();
}

TEST(Marginalization, FixedBlocksAreKnown) {
  Scene scene(6);
  scene.SeeEverything();
  scene.problem.SetParameterBlockConstant(scene.pose(1));
  scene.problem.SetParameterBlockConstant(scene.point(3));
  scene.problem.SetParameterBlockConstant(scene.pose(0));  // it is marginalized itself
  std::vector<double*> removed = {scene.pose(0)};
  for (std::size_t j = 0; j < 6; ++j) removed.push_back(scene.point(j));
  const Marginal marginal = Marginalize(scene.problem, removed);
  std::vector<double*> unknown;
  for (std::size_t j = 0; j < 6; ++j) {
    if (j != 3) unknown.push_back(scene.point(j));
  }
  std::vector<double*> kept = {scene.pose(2), scene.pose(3)};
  for (std::size_t j = 6; j < 12; ++j) kept.push_back(scene.point(j));
  EXPECT_EQ(marginal.report.removed_dimensions, 15);
  ExpectEqual(marginal, kept, SchurComplement(scene.problem, removed, unknown, kept), 1e-9);
}

TEST(Marginalization, BlocksWithoutResidualsLeaveNothingBehind) {
  Scene scene(7);
  const Marginal marginal =
      Marginalize(scene.problem, std::vector<double*>{scene.pose(0), scene.point(1)});
  EXPECT_EQ(marginal.prior, nullptr);
  EXPECT_TRUE(marginal.blocks.empty());
  EXPECT_EQ(marginal.report.factors, 0);
  EXPECT_EQ(marginal.report.removed_dimensions, 9);
  EXPECT_EQ(marginal.report.removed_rank, 0);
  EXPECT_EQ(Marginalize(scene.problem, {}).prior, nullptr);
}

TEST(Marginalization, NeverFormsAMatrixOverAllLandmarks) {
  // 20,000 points: 60,000 dimensions, 29 GB as one matrix. Also tested without fast removal.
  Scene scene(8, 5, 20000);
  std::vector<double*> removed;
  for (std::size_t j = 0; j < scene.points.size(); ++j) {
    removed.push_back(scene.point(j));
    for (std::size_t i = 0; i < 3; ++i) scene.See((i + j) % 5, j);
  }
  const Marginal marginal = Marginalize(scene.problem, removed);
  EXPECT_EQ(marginal.report.removed_rank, 60000);
  EXPECT_EQ(marginal.report.dimensions, 30);
  EXPECT_EQ(marginal.report.null_space, 6);
}

TEST(Marginalization, SummarizeEqualsTheMarginalOfTheWholeProblem) {
  Scene scene(9);
  scene.SeeEverything();
  scene.Anchor(0);
  scene.Link(2, 3);
  const std::vector<double*> kept = {scene.pose(3), scene.point(5)};
  std::vector<double*> others = {scene.pose(0), scene.pose(1), scene.pose(2)};
  for (std::size_t j = 0; j < 12; ++j) {
    if (j != 5) others.push_back(scene.point(j));
  }
  std::vector<double*> all = others;
  all.insert(all.end(), kept.begin(), kept.end());
  ExpectEqual(Summarize(scene.problem, kept), kept,
              SchurComplement(scene.problem, all, others, kept), 1e-9);
}

TEST(Marginalization, TheProblemIsNotChanged) {
  Scene scene(10);
  scene.SeeEverything();
  const std::vector<double> before = Block(scene.estimates[0]);
  Marginalize(scene.problem, std::vector<double*>{scene.pose(0)});
  EXPECT_EQ(Block(scene.estimates[0]), before);
  EXPECT_EQ(scene.problem.NumParameterBlocks(), 16);
  EXPECT_EQ(scene.problem.NumResidualBlocks(), 48);
}

TEST(Marginalization, RefusesUnknownBlocks) {
  Scene scene(11);
  scene.SeeEverything();
  double stranger = 0.0;
  EXPECT_THROW(Marginalize(scene.problem, std::vector<double*>{&stranger}), InvalidArgument);
  EXPECT_THROW(Marginalize(scene.problem, std::vector<double*>{scene.pose(0), scene.pose(0)}),
               InvalidArgument);
  EXPECT_THROW(Summarize(scene.problem, std::vector<double*>{&stranger}), InvalidArgument);
  EXPECT_THROW(Marginalize(scene.problem, {}, {.rank_tolerance = 0.0}), InvalidArgument);
  EXPECT_THROW(Marginalize(scene.problem, {}, {.rank_tolerance = 1.0}), InvalidArgument);
  scene.points[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Marginalize(scene.problem, std::vector<double*>{scene.pose(0)}), InvalidArgument);
}

// Calibration c and states x_i on a line, r = x_i + c - z: with first-estimate Jacobians the states
// keep their linearization point, but the calibration does not.
struct Offset {
  double z;
  template <class S>
  bool operator()(const S* x, const S* c, S* r) const {
    r[0] = x[0] * c[0] - z;
    return true;
  }
};

TEST(Marginalization, FirstEstimatesHoldForStatesUnderAPriorButNotForCalibration) {
  double x[3] = {1.0, 2.0, 3.0}, c = 1.5;
  ceres::Problem problem;
  const auto add = [&](int i) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Offset, 1, 1, 1>(new Offset{1.0}),
                             nullptr, &x[i], &c);
  };
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(2, 2);
  problem.AddResidualBlock(
      new MarginalPrior({{{1.2}, nullptr}, {{1.4}, nullptr}}, A, Eigen::Vector2d::Zero()), nullptr,
      &x[0], &c);
  add(0);
  add(1);
  // Returns the linearization points of the new prior's blocks.
  const auto points = [&](const MarginalizationOptions& options) {
    const Marginal marginal = Marginalize(problem, std::vector<double*>{&x[1]}, options);
    EXPECT_EQ(marginal.prior, nullptr);  // its only row is consumed by x[1]
    const Marginal whole = Summarize(problem, std::vector<double*>{&x[0], &c}, options);
    std::vector<double> result;
    for (const auto& block : whole.prior->blocks()) result.push_back(block.linearization_point[0]);
    return result;
  };
  EXPECT_EQ(points({}), (std::vector<double>{1.0, 1.5}));
  EXPECT_EQ(points({.first_estimate_jacobians = true}), (std::vector<double>{1.2, 1.4}));
  EXPECT_EQ(points({.first_estimate_jacobians = true, .relinearized = {&c}}),
            (std::vector<double>{1.2, 1.5}));
  // Eq. 9 computed by hand: the rows of the prior at rest and r = x c - 1 = 0.5 with the Jacobian
  // [c, x] at (1.2, 1.4). The residual at the present estimate is preserved to first order.
  const Marginal whole =
      Summarize(problem, std::vector<double*>{&x[0], &c}, {.first_estimate_jacobians = true});
  Eigen::Matrix<double, 3, 2> J;
  J << 1, 0, 0, 1, 1.4, 1.2;
  const Eigen::Vector3d r(0.0, 0.0, 0.5 - 1.4 * (1.0 - 1.2) - 1.2 * (1.5 - 1.4));
  const Eigen::MatrixXd& A_whole = whole.prior->A();
  EXPECT_LT((A_whole.transpose() * A_whole - J.transpose() * J).norm(), 1e-14);
  EXPECT_LT((A_whole.transpose() * whole.prior->b() - J.transpose() * r).norm(), 1e-14);
}

TEST(MarginalPrior, JacobiansMatchCentralDifferences) {
  const PoseManifold pose;
  const LineManifold line;
  RandomStates random(12);
  for (int i = 0; i < 50; ++i) {
    const Pose T_0 = random.RandomPose(2.0, 3.0);
    const OrthonormalLine line_0(PluckerLine::FromPoints(random.Vector(2.0), random.Vector(2.0)));
    const Eigen::MatrixXd A = random.Matrix<13>().topRows(9);
    const MarginalPrior prior({{Block(T_0), &pose},
                               {{line_0.data(), line_0.data() + 6}, &line},
                               {{0.1, 0.2, 0.3}, nullptr}},
                              A, A.col(0));
    EXPECT_EQ(prior.Column(2), 10);
    std::vector<double> moved_line(6);
    const Eigen::Vector4d step(0.3, -0.2, 0.4, 0.5);
    line.Plus(line_0.data(), step.data(), moved_line.data());
    const Pose T = i == 0 ? T_0 : T_0.Plus(random.Matrix<6>().col(0));
    const auto check =
        testing::CheckJacobians(prior, {Block(T), moved_line, {1, 2, 3}}, {&pose, &line, nullptr});
    EXPECT_TRUE(check) << check.message;
  }
}

TEST(MarginalPrior, OfAQuarterTurnComputedByHand) {
  const PoseManifold pose;
  const Pose T_0 = Pose::FromTangent({1, 2, 3}, {0, 0, 0});
  const MarginalPrior prior({{Block(T_0), &pose}}, 2.0 * Matrix6::Identity(),
                            Eigen::VectorXd::Constant(6, 0.5));
  const Pose T = Pose::FromTangent({1.5, 2, 2}, {0, 0, M_PI_2});
  const double* parameters[] = {T.data()};
  Eigen::Matrix<double, 6, 1> r;
  ASSERT_TRUE(prior.Evaluate(parameters, r.data(), nullptr));
  EXPECT_LT((r - Eigen::Matrix<double, 6, 1>(1.5, 0.5, -1.5, 0.5, 0.5, M_PI + 0.5)).norm(), 1e-14);
}

TEST(MarginalPrior, RefusesMismatchedSizesAndNonFiniteValues) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(2, 2);
  const Eigen::Vector2d b(0, 0);
  EXPECT_THROW(MarginalPrior({{{0.0}, nullptr}}, A, b), InvalidArgument);
  EXPECT_THROW(MarginalPrior({{{0.0, 1.0}, nullptr}}, A, Eigen::Vector3d::Zero()), InvalidArgument);
  EXPECT_THROW(MarginalPrior({{{0.0, 1.0}, nullptr}}, A * NAN, b), InvalidArgument);
  EXPECT_THROW(MarginalPrior({{{0.0, NAN}, nullptr}}, A, b), InvalidArgument);
  const PoseManifold pose;
  EXPECT_THROW(MarginalPrior({{{0.0, 1.0}, &pose}}, A, b), InvalidArgument);
}

}  // namespace
}  // namespace highwall::marginalization_test
