#include <cmath>
#include <memory>
#include <type_traits>

#include <ceres/loss_function.h>
#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/so3.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_solver.h>

#include "support/synthetic_scene.h"

namespace highwall::pose_solver_test {
namespace {

using testing::AngleError;
using testing::IdealSensor;
using testing::MakeScene;
using testing::PositionError;
using testing::Scene;
using testing::SyntheticView;

const Pose kTruth = Pose::FromTangent({0.1, -0.05, 0.2}, {0.03, -0.08, 0.05});
// The start is 7 cm and 3 degrees away.
const Pose kStart = Pose::FromTangent({0.15, -0.1, 0.2}, {0.06, -0.05, 0.08});

using Problem = PerKind<PoseObservations>;

// Lines are trimmed to the part seen by their observed ends from T_WC, as the tracker does.
Problem MakeProblem(const Scene& scene, const SyntheticView& view, const MeasurementModel& model,
                    const Pose& T_WC) {
  Problem problem;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const PointFeature& feature = view.features->points[i];
    problem.points.push_back({scene.points[static_cast<std::size_t>(view.points[i])].p_W,
                              model.Rows(feature), MeasurementModel::Dimension(feature)});
  }
  for (std::size_t i = 0; i < view.lines.size(); ++i) {
    const LineFeature& feature = view.features->lines[i];
    const Segment3& segment_W = scene.lines[static_cast<std::size_t>(view.lines[i])].segment_W;
    const auto piece = TrimToObservation(
        T_WC.Inverse() * PluckerLine::FromPoints(segment_W.p(), segment_W.q()),
        feature.segment.s.cast<double>(), feature.segment.e.cast<double>(), model.projection());
    if (!piece) continue;
    problem.lines.push_back(
        {T_WC * *piece, model.Rows(feature), MeasurementModel::Dimension(feature)});
  }
  return problem;
}

class PoseSolver : public ::testing::Test {
 protected:
  std::optional<PoseSolution> Solve(const Problem& problem, const Pose& start = kStart,
                                    const PoseSolverOptions& options = {}) const {
    return SolvePose(start, model.projection(), problem, options);
  }
  Problem Exact(int points, int lines, const Pose& start = kStart) const {
    const Scene scene = MakeScene(11, points, lines);
    return MakeProblem(scene, Look(scene, IdealSensor(), kTruth), model, start);
  }

  const MeasurementModel model{IdealSensor(), {.point_sigma = 1.0}};  // that of the noise
};

TEST_F(PoseSolver, FindsTheExactPoseFromPoints) {
  const auto solution = Solve(Exact(60, 0));
  ASSERT_TRUE(solution);
  // The solver stops once a step reduces the cost by less than 1e-6; the next step, which would
  // square the error, is not taken.
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-7);
  EXPECT_LT(AngleError(solution->T_WC, kTruth), 1e-7);
  EXPECT_EQ(solution->num_points, static_cast<int>(solution->inliers.points.size()));
  EXPECT_GT(solution->num_points, 20);
  EXPECT_EQ(solution->num_lines, 0);
}

TEST_F(PoseSolver, FindsThePoseFromPointsWithoutDepth) {
  const Scene scene = MakeScene(11, 60, 0);
  const SyntheticView view = Look(scene, IdealSensor(), kTruth);
  auto flat = std::make_shared<FrameFeatures>(*view.features);
  for (PointFeature& point : flat->points) point.depth = 0.0;
  const auto solution = Solve(MakeProblem(scene, {flat, view.points, {}}, model, kStart));
  ASSERT_TRUE(solution);
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-7);
  EXPECT_LT(AngleError(solution->T_WC, kTruth), 1e-7);
}

// Points near the optical axis, without depth, that are seen from much nearer: the first step would
// lead past them, where no observation is left to contradict it.
TEST_F(PoseSolver, AStepPastAllPointsIsNoPerfectFit) {
  Problem problem;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2.0 * M_PI * i / 24.0, radius = i % 2 == 0 ? 1.5e-3 : 1e-3;
    const Eigen::Vector3d p_W(radius * std::cos(angle), radius * std::sin(angle), 2.6);
    PointFeature seen;
    seen.uv = model.camera().Project(p_W - Eigen::Vector3d(0.0, 0.0, 2.0));
    problem.points.push_back({p_W, model.Rows(seen), 2});
  }
  const auto solution = Solve(problem, Pose());
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->num_points, 24);
  EXPECT_LT(solution->T_WC.p().z(), 2.6);
}

TEST_F(PoseSolver, FindsTheExactPoseFromLines) {
  // The ends of a map line move along it if the start is wrong, at no cost: only the error across
  // the line is measured. Pixels are floats, 3e-5 px, 1e-7 m at 3 m.
  const auto solution = Solve(Exact(0, 40));
  ASSERT_TRUE(solution);
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);
  EXPECT_LT(AngleError(solution->T_WC, kTruth), 1e-6);
  EXPECT_EQ(solution->num_points, 0);
  EXPECT_GT(solution->num_lines, 10);
}

TEST_F(PoseSolver, FindsTheExactPoseFromPointsAndLines) {
  const auto solution = Solve(Exact(30, 20));
  ASSERT_TRUE(solution);
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);
  EXPECT_LT(AngleError(solution->T_WC, kTruth), 1e-6);
  EXPECT_GT(solution->num_points, 10);
  EXPECT_GT(solution->num_lines, 5);
}

TEST_F(PoseSolver, FlagsThirtyPercentGrossOutliers) {
  Problem problem = Exact(100, 30, kTruth);
  std::mt19937 rng(4);
  std::vector<bool> point_good(problem.points.size(), true), line_good(problem.lines.size(), true);
  const auto shift = [&] { return testing::UniformInBox(rng, {0.3, 0.3, 0.3}, {1.0, 1.0, 1.0}); };
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    if (i % 10 >= 3) continue;
    point_good[i] = false;
    problem.points[i].p_W += shift();
  }
  for (std::size_t i = 0; i < problem.lines.size(); ++i) {
    if (i % 10 >= 3) continue;
    line_good[i] = false;
    Segment3& segment = problem.lines[i].segment_W;
    segment = Segment3(segment.p() + shift(), segment.q() - shift());
  }
  const auto solution = Solve(problem);
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->inliers.points, point_good);
  EXPECT_EQ(solution->inliers.lines, line_good);
  EXPECT_EQ(solution->num_points, std::count(point_good.begin(), point_good.end(), true));
  EXPECT_EQ(solution->num_lines, std::count(line_good.begin(), line_good.end(), true));
  // Observations that are masked out have no influence at all.
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);
  EXPECT_LT(AngleError(solution->T_WC, kTruth), 1e-6);
}

// Two in five depth readings belong to a surface 30 cm behind, as next to depth edges.
class PoseSolverAtEdges : public PoseSolver {
 protected:
  PoseSolverAtEdges() {
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (std::size_t i = 0; i < features->points.size(); ++i) {
      if (IsAtEdge(i)) features->points[i].depth += 0.3;
    }
    view.features = features;
  }
  static bool IsAtEdge(std::size_t i) { return i % 5 < 2; }
  std::optional<PoseSolution> SolveFor(int min_support) const {
    return Solve(MakeProblem(scene, view, model, kStart), kStart, {.min_support = min_support});
  }
  int all() const { return static_cast<int>(view.points.size()); }

  const Scene scene = MakeScene(11, 100, 0);
  SyntheticView view = Look(scene, IdealSensor(), kTruth);
};

TEST_F(PoseSolverAtEdges, ADepthThatContradictsItsPixelCostsNoPose) {
  const auto solution = SolveFor(all() * 3 / 4);
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->num_points, all());
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);
  EXPECT_LT(AngleError(solution->T_WC, kTruth), 1e-6);
  EXPECT_LT(solution->error, 1e-9) << "their depth says nothing of the fit";
  EXPECT_FALSE(SolveFor(all() + 1));
}

TEST_F(PoseSolverAtEdges, LeavesEdgesOutWhereThereIsAPoseWithoutThem) {
  const auto solution = SolveFor(6);
  ASSERT_TRUE(solution);
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    EXPECT_EQ(solution->inliers.points[i], !IsAtEdge(i)) << i;
  }
}

TEST_F(PoseSolver, RejectsAPointByItsPixelWhateverItsDepth) {
  const Scene scene = MakeScene(11, 100, 0);
  SyntheticView view = Look(scene, IdealSensor(), kTruth);
  auto wrong = std::make_shared<FrameFeatures>(*view.features);
  for (std::size_t i = 0; i < wrong->points.size(); i += 4) wrong->points[i].uv.x() += 12.0;
  view.features = wrong;
  const auto solution = Solve(MakeProblem(scene, view, model, kStart));
  ASSERT_TRUE(solution);
  for (std::size_t i = 0; i < wrong->points.size(); ++i) {
    EXPECT_EQ(solution->inliers.points[i], i % 4 != 0) << i;
  }
}

TEST_F(PoseSolver, PointsOnPlanesTakePartAndWrongOnesAreRejected) {
  // Two planes of W, and every tenth point is half a metre off.
  const Problem problem = Exact(60, 0);
  std::vector<PointToPlaneRow> planes;
  std::mt19937 rng(6);
  for (int i = 0; i < 100; ++i) {
    Eigen::Vector3d p_W = testing::UniformInBox(rng, {-1, -1, 2}, {1, 1, 4});
    p_W(i % 2) = 1.5;
    if (i % 10 == 0) p_W(i % 2) += 0.5;
    planes.push_back({Eigen::Vector3d::Unit(i % 2), {1.5, 1.5, 0.0}, kTruth.Inverse() * p_W, 50.0});
  }
  const auto without = Solve(problem);
  const auto solution = SolvePose(kStart, model.projection(), problem, {}, nullptr, planes);
  ASSERT_TRUE(without && solution);
  EXPECT_EQ(solution->num_planes, 90);
  EXPECT_EQ(without->num_planes, 0);
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);
  // All wrong points belong to the plane across x: 40 rows of (1 / 2 cm)^2 remain. The information
  // of the points is equal in both solutions up to 1e-7 m.
  const double added = solution->information(0, 0) - without->information(0, 0);
  EXPECT_NEAR(added, 40 * 2500.0, 1.0);
}

TEST_F(PoseSolver, ALandmarkBehindTheCameraIsAnOutlier) {
  Problem problem = Exact(30, 10);
  problem.points[0].p_W = kTruth * Eigen::Vector3d(0.0, 0.0, -2.0);
  problem.lines[0].segment_W = Segment3(kTruth * Eigen::Vector3d(-1.0, 0.0, -2.0),
                                        kTruth * Eigen::Vector3d(1.0, 0.0, -2.0));
  const auto solution = Solve(problem);
  ASSERT_TRUE(solution);
  EXPECT_FALSE(solution->inliers.points[0]);
  EXPECT_FALSE(solution->inliers.lines[0]);
  EXPECT_EQ(solution->num_points, static_cast<int>(problem.points.size()) - 1);
  EXPECT_EQ(solution->num_lines, static_cast<int>(problem.lines.size()) - 1);
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);
}

TEST_F(PoseSolver, AnObservationThatIsNotANumberIsAnOutlier) {
  Problem problem = Exact(30, 10);
  problem.points[3].rows.b[0] = std::numeric_limits<double>::quiet_NaN();
  const auto solution = Solve(problem);
  ASSERT_TRUE(solution);
  EXPECT_FALSE(solution->inliers.points[3]);
  EXPECT_TRUE(solution->information.allFinite());
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);
}

TEST_F(PoseSolver, TooFewInliersAreNoSolution) {
  const Problem all = Exact(60, 0);
  Problem problem{{all.points.begin(), all.points.begin() + 12}, {}};
  ASSERT_TRUE(Solve(problem));
  EXPECT_FALSE(Solve(problem, kStart, {.min_support = 13})) << "fewer than asked for";
  for (std::size_t i = 0; i < 3; ++i) problem.points[i].p_W += Eigen::Vector3d(1, 1, 1);
  EXPECT_TRUE(Solve(problem, kStart, {.min_support = 9}));
  EXPECT_FALSE(Solve(problem, kStart, {.min_support = 10})) << "fewer in the end";
  EXPECT_FALSE(Solve({}));
}

TEST_F(PoseSolver, ALineSupportsAsMuchAsTwoPoints) {
  const Problem all = Exact(60, 40);
  const Problem problem{{all.points.begin(), all.points.begin() + 4},
                        {all.lines.begin(), all.lines.begin() + 5}};
  EXPECT_TRUE(Solve(problem, kStart, {.min_support = 14}));
  EXPECT_FALSE(Solve(problem, kStart, {.min_support = 15}));
}

TEST_F(PoseSolver, PointsAndLinesBehindTheCameraAreOutliers) {
  Problem problem = Exact(60, 10);
  const std::size_t points = problem.points.size(), lines = problem.lines.size();
  PosePoint point = problem.points[0];
  point.p_W = kTruth * Eigen::Vector3d(0.1, 0.1, -1.0);
  problem.points.push_back(point);
  PoseLine line = problem.lines[0];
  line.segment_W = Segment3(line.segment_W.p(), kTruth * Eigen::Vector3d(0.1, 0.1, -1.0));
  problem.lines.push_back(line);
  const auto solution = Solve(problem);
  ASSERT_TRUE(solution);
  EXPECT_FALSE(solution->inliers.points.back());
  EXPECT_FALSE(solution->inliers.lines.back());
  EXPECT_EQ(solution->num_points, static_cast<int>(points));
  EXPECT_EQ(solution->num_lines, static_cast<int>(lines));
  EXPECT_LT(PositionError(solution->T_WC, kTruth), 1e-6);

  for (PosePoint& p : problem.points) p.p_W = kStart * Eigen::Vector3d(0.1, 0.1, -2.0);
  problem.lines.clear();
  EXPECT_FALSE(Solve(problem)) << "all behind: no residual and yet no solution";
}

// Ceres solves the same problem with ceres::HuberLoss, with noise far beyond the threshold: both
// must find the same minimum.
TEST_F(PoseSolver, MinimisesTheHuberCostExactly) {
  const Scene scene = MakeScene(21, 80, 25);
  const SyntheticView view = Look(scene, IdealSensor(), kTruth, {.px = 4.0, .depth = true});
  const Problem problem = MakeProblem(scene, view, model, kTruth);
  const PoseSolverOptions once{.point_huber = 1.5,
                               .line_huber = 2.5,
                               .inliers = {.chi2_2 = 1e9, .chi2_3 = 1e9, .chi2_4 = 1e9},
                               .rounds = 1,
                               .max_iterations = 50};
  const auto solution = Solve(problem, kStart, once);
  ASSERT_TRUE(solution);

  FactorGraph graph;
  const Variable<Pose> pose = graph.AddVariable(kStart);
  const auto point_loss = std::make_shared<ceres::HuberLoss>(once.point_huber);
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    const Variable<Point> p = graph.AddVariable(Point(problem.points[i].p_W));
    graph.Fix(p);
    graph.AddFactor(model.MakeFactor(view.features->points[i]), point_loss, pose, p);
  }
  const auto line_loss = std::make_shared<ceres::HuberLoss>(once.line_huber);
  for (std::size_t i = 0; i < problem.lines.size(); ++i) {
    const Variable<Segment3> segment = graph.AddVariable(problem.lines[i].segment_W);
    graph.Fix(segment);
    graph.AddFactor(
        std::make_unique<LineReprojectionRgbd>(problem.lines[i].rows, model.projection()),
        line_loss, pose, segment);
  }
  SolveOptions options;
  options.max_iterations = 100;
  options.gradient_tolerance = 1e-10;
  options.parameter_tolerance = 1e-12;
  options.function_tolerance = 1e-14;
  ASSERT_TRUE(graph.Solve(options).IsUsable());
  // The solver stops once a step reduces the cost by less than 1e-6: a thousandth of a standard
  // deviation, which is some millimetres for this noise.
  EXPECT_LT(PositionError(solution->T_WC, graph.Value(pose)), 5e-6);
  EXPECT_LT(AngleError(solution->T_WC, graph.Value(pose)), 5e-6);
  EXPECT_GT(PositionError(solution->T_WC, kTruth), 1e-4) << "the noise must matter";
}

TEST_F(PoseSolver, ForgetsTheStartWithinItsBasin) {
  const Scene scene = MakeScene(31, 80, 0);
  const Problem problem = MakeProblem(
      scene, Look(scene, IdealSensor(), kTruth, {.px = 1.0, .depth = true}), model, kTruth);
  const auto reference = Solve(problem, kTruth);
  ASSERT_TRUE(reference);
  std::mt19937 rng(8);
  for (int i = 0; i < 20; ++i) {
    // The start is up to 15 cm and 6 degrees off.
    Eigen::Matrix<double, 6, 1> step;
    step << testing::UniformInBox(rng, {-0.15, -0.15, -0.15}, {0.15, 0.15, 0.15}),
        testing::UniformInBox(rng, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
    const auto solution = Solve(problem, kTruth.Plus(step));
    ASSERT_TRUE(solution);
    EXPECT_EQ(solution->inliers.points, reference->inliers.points);
    EXPECT_LT(PositionError(solution->T_WC, reference->T_WC), 1e-5);
    EXPECT_LT(AngleError(solution->T_WC, reference->T_WC), 1e-5);
  }
}

// Without robustness the normalised estimation error squared is chi-square with 6 degrees of
// freedom: over N trials its mean is 6 +- sqrt(12 / N).
TEST_F(PoseSolver, ErrorIsConsistentWithTheNoise) {
  constexpr int kTrials = 200;
  const PoseSolverOptions plain{.point_huber = 1e6,
                                .line_huber = 1e6,
                                .inliers = {.chi2_2 = 1e9, .chi2_3 = 1e9, .chi2_4 = 1e9},
                                .rounds = 1,
                                .max_iterations = 20};
  const Scene scene = MakeScene(41, 60, 0);
  double sum = 0.0;
  for (unsigned trial = 0; trial < kTrials; ++trial) {
    const SyntheticView view =
        Look(scene, IdealSensor(), kTruth, {.px = 1.0, .depth = true, .seed = trial + 1});
    const Problem problem = MakeProblem(scene, view, model, kTruth);
    const auto solution = Solve(problem, kTruth, plain);
    ASSERT_TRUE(solution);
    Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
    for (const PosePoint& point : problem.points) {
      Eigen::Vector3d r;
      Eigen::Matrix<double, 3, 6> J;
      ASSERT_TRUE(model.projection().Evaluate<3>(RgbdProjection::At(solution->T_WC.data()),
                                                 point.rows, point.p_W, &r, &J, nullptr));
      information += J.transpose() * J;
    }
    Eigen::Matrix<double, 6, 1> error;
    error << kTruth.p() - solution->T_WC.p(), so3::Log(solution->T_WC.q().conjugate() * kTruth.q());
    sum += error.dot(information * error);
  }
  const double sigma = std::sqrt(12.0 / kTrials);
  EXPECT_NEAR(sum / kTrials, 6.0, 4.0 * sigma);
}

// J^T J and J^T r of points that all have depth, at a pose.
struct NormalEquations {
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
};
NormalEquations Sum(const std::vector<PosePoint>& points, const RgbdProjection& projection,
                    const Pose& T_WC) {
  NormalEquations sum;
  for (const PosePoint& point : points) {
    Eigen::Vector3d r;
    Eigen::Matrix<double, 3, 6> J;
    EXPECT_TRUE(projection.Evaluate<3>(RgbdProjection::At(T_WC.data()), point.rows, point.p_W, &r,
                                       &J, nullptr));
    sum.H += J.transpose() * J;
    sum.g += J.transpose() * r;
  }
  return sum;
}

TEST_F(PoseSolver, APriorDeterminesADirectionThatTheImageLeavesUnobservable) {
  // The lines are parallel: the position along them is unobservable.
  std::mt19937 rng(51);
  Scene scene = MakeScene(51, 0, 30);
  for (auto& line : scene.lines) {
    const Eigen::Vector3d p = line.segment_W.p();
    line.segment_W = Segment3(p, p + Eigen::Vector3d(testing::Uniform(rng, 0.4, 1.0), 0, 0));
  }
  const Problem problem = MakeProblem(scene, Look(scene, IdealSensor(), kTruth), model, kTruth);
  ASSERT_GT(problem.lines.size(), 8u);
  const PoseConstraint known{
      kTruth.Plus((Eigen::Matrix<double, 6, 1>() << 0.02, 0, 0, 0, 0, 0).finished()),
      100.0 * Eigen::Matrix<double, 6, 6>::Identity()};
  const auto solution = SolvePose(kTruth, model.projection(), problem, {}, &known);
  ASSERT_TRUE(solution);
  // The prior's centimetre yields by up to a millimetre to the better constraints of the lines.
  EXPECT_NEAR(solution->T_WC.p().x(), kTruth.p().x() + 0.02, 1e-3);
  EXPECT_LT((solution->T_WC.p() - kTruth.p()).tail<2>().norm(), 1e-3);
  EXPECT_LT(AngleError(solution->T_WC, kTruth), 1e-3);
  // The lines themselves still give no constraint in that direction.
  EXPECT_LT(solution->information(0, 0), 1e-6 * solution->information(1, 1));
}

TEST_F(PoseSolver, InformationAndGradientAreThoseOfTheImageAlone) {
  const Scene scene = MakeScene(52, 60, 0);
  const Problem problem = MakeProblem(
      scene, Look(scene, IdealSensor(), kTruth, {.px = 0.5, .depth = true}), model, kTruth);
  // A strong prior, a millimetre away.
  const PoseConstraint known{
      kTruth.Plus((Eigen::Matrix<double, 6, 1>() << 1e-3, 0, 0, 0, 5e-4, 0).finished()),
      1e4 * Eigen::Matrix<double, 6, 6>::Identity()};
  const PoseSolverOptions plain{.point_huber = 1e6,
                                .inliers = {.chi2_2 = 1e9, .chi2_3 = 1e9},
                                .rounds = 1,
                                .max_iterations = 20};
  const auto alone = Solve(problem, kTruth, plain);
  const auto held = SolvePose(kTruth, model.projection(), problem, plain, &known);
  ASSERT_TRUE(alone && held);
  ASSERT_EQ(held->num_points, static_cast<int>(problem.points.size()));
  ASSERT_EQ(alone->num_points, held->num_points);
  const NormalEquations sum = Sum(problem.points, model.projection(), held->T_WC);
  EXPECT_TRUE(held->information.isApprox(sum.H, 1e-12));
  EXPECT_TRUE(held->gradient.isApprox(sum.g, 1e-9));
  EXPECT_GT(PositionError(alone->T_WC, held->T_WC), 5e-4) << "it must be held";
  // One Gauss-Newton step leads to the optimum of the image alone, up to an error of second order
  // in the millimetre.
  const Pose stepped = held->T_WC.Plus(-held->information.ldlt().solve(held->gradient));
  EXPECT_LT(PositionError(alone->T_WC, stepped), 0.02 * PositionError(alone->T_WC, held->T_WC));
}

TEST_F(PoseSolver, APriorWithoutWeightChangesNothing) {
  const Problem problem = Exact(60, 10);
  const PoseConstraint nothing{Pose::FromTangent({9, 9, 9}, {1, 1, 1})};
  const auto alone = Solve(problem);
  const auto with = SolvePose(kStart, model.projection(), problem, {}, &nothing);
  ASSERT_TRUE(alone && with);
  EXPECT_LT(PositionError(alone->T_WC, with->T_WC), 1e-9);
  EXPECT_EQ(alone->inliers.points, with->inliers.points);
}

TEST_F(PoseSolver, FitIsOneForTheNoiseThatTheRowsState) {
  constexpr int kTrials = 30;
  const PoseSolverOptions plain{
      .point_huber = 1e6, .inliers = {.chi2_2 = 1e9, .chi2_3 = 1e9}, .rounds = 1};
  const Scene scene = MakeScene(53, 60, 0);
  double sum = 0.0, dof = 0.0;
  for (unsigned trial = 1; trial <= kTrials; ++trial) {
    const SyntheticView view =
        Look(scene, IdealSensor(), kTruth, {.px = 1.0, .depth = true, .seed = trial});
    const Problem problem = MakeProblem(scene, view, model, kTruth);
    const auto solution = Solve(problem, kTruth, plain);
    ASSERT_TRUE(solution);
    sum += solution->error;
    dof += 3.0 * static_cast<double>(problem.points.size()) - 6.0;
  }
  // Chi-squared of all degrees of freedom together.
  EXPECT_NEAR(sum / kTrials, 1.0, 4.0 * std::sqrt(2.0 / dof));
  const auto exact = Solve(Exact(60, 0));
  ASSERT_TRUE(exact);
  EXPECT_LT(exact->error, 1e-8);
}

TEST(TrimToObservation, CutsWhereTheObservedEndsLook) {
  const RgbdProjection camera(PinholeCamera{.fx = 500, .fy = 500, .cx = 320, .cy = 240}, Pose());
  // The line is along x at y = 0.4, z = 2; its image is v = 240 + 500 * 0.2 = 340.
  const auto line = PluckerLine::FromPoints({-5, 0.4, 2}, {5, 0.4, 2});
  const auto on_it = TrimToObservation(line, {195, 340}, {445, 340}, camera);
  ASSERT_TRUE(on_it);
  EXPECT_TRUE(on_it->p().isApprox(Eigen::Vector3d(-0.5, 0.4, 2), 1e-13));
  EXPECT_TRUE(on_it->q().isApprox(Eigen::Vector3d(0.5, 0.4, 2), 1e-13));
  // A ray (m_x, 0, 1) passes below: the nearest point of the line, d = x, has x = m_x (m . a) /
  // (|m|^2 - m_x^2) with m . a = 2 and |m|^2 - m_x^2 = 1.
  const auto off = TrimToObservation(line, {445, 240}, {570, 240}, camera);
  ASSERT_TRUE(off);
  EXPECT_TRUE(off->p().isApprox(Eigen::Vector3d(0.5, 0.4, 2), 1e-13));
  EXPECT_TRUE(off->q().isApprox(Eigen::Vector3d(1.0, 0.4, 2), 1e-13));
}

TEST(TrimToObservation, IsEmptyBehindTheCameraAndAlongTheRay) {
  const RgbdProjection camera(PinholeCamera{.fx = 500, .fy = 500, .cx = 320, .cy = 240}, Pose());
  const auto behind = PluckerLine::FromPoints({-5, 0.4, -2}, {5, 0.4, -2});
  EXPECT_FALSE(TrimToObservation(behind, {195, 340}, {445, 340}, camera));
  const auto along = PluckerLine::FromPoints({0, 0.1, 1}, {0, 0.1, 5});
  EXPECT_FALSE(TrimToObservation(along, {320, 240}, {320, 300}, camera));
}

}  // namespace
}  // namespace highwall::pose_solver_test
