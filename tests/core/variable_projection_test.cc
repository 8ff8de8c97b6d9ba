#include "variable_projection.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>
#include <Eigen/LU>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>

#include "landmark_problem.h"
#include "point_observation.h"
#include "random_states.h"

namespace highwall::variable_projection_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// A scaled observation of a point from a pose: three variables, with a landmark in the middle.
struct StretchedObservation {
  Eigen::Vector3d z;

  template <class S>
  bool operator()(const S* scale, const S* x, const S* pose, S* r) const {
    PointObservation{Eigen::Vector3d::Zero()}(pose, x, r);
    for (int i = 0; i < 3; ++i) r[i] = scale[0] * r[i] - z[i];
    return true;
  }
};

std::unique_ptr<ceres::CostFunction> MakeStretched(const Eigen::Vector3d& z) {
  return std::make_unique<ceres::AutoDiffCostFunction<StretchedObservation, 3, 1, 3, 7>>(
      new StretchedObservation{z});
}

// Poses and points, all observed from all poses and disturbed. The first pose has a prior with
// sigma 1.
struct Bundle {
  explicit Bundle(unsigned seed, double noise = 0.0, bool stretched = false) : random(seed) {
    if (stretched) {
      using Scalar = Eigen::Matrix<double, 1, 1>;
      scale = graph.AddVariable(1.1);
      graph.AddFactor(std::make_unique<VectorPrior<1>>(Scalar(1.0), Scalar(1.0)), scale);
    }
    for (int i = 0; i < 4; ++i) {
      truth.push_back(random.RandomPose(1.0, 0.5));
      poses.push_back(graph.AddVariable(truth[Index(i)].Plus(Vector6(0.05))));
    }
    graph.AddFactor(std::make_unique<PosePrior>(truth[0], Matrix6::Identity()), poses[0]);
    for (int j = 0; j < 12; ++j) {
      const Point x = random.Vector(4.0);
      points.push_back(graph.AddLandmark(Point(x + random.Vector(0.1))));
      for (int i = 0; i < 4; ++i) {
        if (i == j % 4) continue;
        const Point z = truth[Index(i)].Inverse() * x + random.Vector(noise);
        if (stretched) {
          graph.AddFactor(MakeStretched(z), loss, scale, points.back(), poses[Index(i)]);
        } else {
          graph.AddFactor(MakeObservation(z), loss, poses[Index(i)], points.back());
        }
      }
    }
  }

  static std::size_t Index(int i) { return static_cast<std::size_t>(i); }
  Eigen::Matrix<double, 6, 1> Vector6(double sigma) {
    Eigen::Matrix<double, 6, 1> out;
    const Eigen::Vector3d p = random.Vector(sigma), q = random.Vector(sigma);
    out << p, q;
    return out;
  }
  // The landmarks with their factors, and the residuals of the other factors.
  struct Parts {
    internal::LandmarkProblem landmarks;
    std::vector<ceres::ResidualBlockId> others;
  };
  Parts Split() {
    std::vector<VariableId> ids(poses.begin(), poses.end());
    ids.insert(ids.end(), points.begin(), points.end());
    if (graph.Contains(scale)) ids.push_back(scale);
    std::vector<internal::LandmarkProblemBuilder::Variable> variables(graph.NumVariables());
    ceres::Problem& problem = graph.problem();
    for (const VariableId& id : ids) {
      double* const block = graph.MutableBlock(id);
      variables[id.index] = {{block, problem.ParameterBlockSize(block),
                              problem.ParameterBlockTangentSize(block), problem.GetManifold(block)},
                             graph.IsFixed(id),
                             std::ranges::find(points, id) != points.end()};
    }
    internal::LandmarkProblemBuilder builder(variables);
    for (const VariableId& point : points) {
      for (const FactorId& factor : graph.FactorsOf(point)) {
        EXPECT_TRUE(builder.Add(graph.Factor(factor), loss.get(), graph.VariablesOf(factor)));
      }
    }
    Parts parts{builder.Finish(), {}};
    problem.GetResidualBlocks(&parts.others);
    std::erase_if(parts.others, [&](ceres::ResidualBlockId residual) {
      std::vector<double*> blocks;
      problem.GetParameterBlocksForResidualBlock(residual, &blocks);
      return blocks.size() > 1;
    });
    return parts;
  }

  RandomStates random;
  std::shared_ptr<ceres::LossFunction> loss = std::make_shared<ceres::HuberLoss>(0.05);
  FactorGraph graph;
  std::vector<Pose> truth;
  std::vector<Variable<Pose>> poses;
  std::vector<Variable<Point>> points;
  Variable<double> scale;
};

SolveOptions Exact(LinearSolver solver) {
  return {.max_iterations = 100,
          .function_tolerance = 1e-16,
          .parameter_tolerance = 1e-14,
          .linear_solver = solver};
}

// Fails to evaluate landmarks of 2 and more, or throws.
class OnlyBelowTwo final : public ceres::SizedCostFunction<1, 1, 7> {
 public:
  explicit OnlyBelowTwo(bool throws) : throws_(throws) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    if (x[0][0] >= 2.0 && throws_) throw std::runtime_error("two and more");
    if (x[0][0] >= 2.0) return false;
    residuals[0] = x[0][0] - x[1][0];
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = 1.0;
    for (int i = 0; jacobians != nullptr && jacobians[1] != nullptr && i < 7; ++i) {
      jacobians[1][i] = i == 0 ? -1.0 : 0.0;
    }
    return true;
  }

 private:
  bool throws_;
};

// Computes H and g of the factors on landmarks with the landmarks minimized out, by dense algebra.
// damping: of the landmarks, a fraction of their diagonal.
struct Reduced {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double cost = 0.0;
};
Reduced SchurComplement(ceres::Problem& problem, const Bundle::Parts& split, double damping) {
  ceres::Problem::EvaluateOptions options;
  int unknowns = 0;
  for (const auto& block : split.landmarks.unknowns) {
    options.parameter_blocks.push_back(block.values);
    unknowns += block.tangent_size;
  }
  for (const auto& landmark : split.landmarks.landmarks) {
    options.parameter_blocks.push_back(landmark.block.values);
  }
  problem.GetResidualBlocks(&options.residual_blocks);
  for (const auto& other : split.others) std::erase(options.residual_blocks, other);
  Reduced reduced;
  std::vector<double> residuals;
  ceres::CRSMatrix sparse;
  problem.Evaluate(options, &reduced.cost, &residuals, nullptr, &sparse);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int row = 0; row < sparse.num_rows; ++row) {
    for (int k = sparse.rows[Bundle::Index(row)]; k < sparse.rows[Bundle::Index(row + 1)]; ++k) {
      J(row, sparse.cols[Bundle::Index(k)]) = sparse.values[Bundle::Index(k)];
    }
  }
  const Eigen::Map<const Eigen::VectorXd> r(residuals.data(), sparse.num_rows);
  const Eigen::MatrixXd X = J.leftCols(unknowns), L = J.rightCols(J.cols() - unknowns);
  Eigen::MatrixXd of_landmarks = L.transpose() * L;
  of_landmarks.diagonal() *= 1.0 + damping;
  const Eigen::MatrixXd gain = X.transpose() * L * of_landmarks.inverse();
  reduced.H = X.transpose() * X - gain * L.transpose() * X;
  reduced.g = X.transpose() * r - gain * L.transpose() * r;
  return reduced;
}

TEST(VariableProjection, AFixedLandmarkWithoutFactorsIsKnown) {
  Bundle bundle(4);
  const Variable<Point> known = bundle.graph.AddLandmark(Point(0.0, 0.0, 2.0));
  bundle.graph.Fix(known);
  ASSERT_TRUE(bundle.graph.Solve(Exact(LinearSolver::kVariableProjection)).IsUsable());
  const std::vector<VariableId> wanted = {known, bundle.poses[0]};
  const auto covariance = bundle.graph.Covariance(wanted);
  ASSERT_TRUE(covariance);
  EXPECT_TRUE(covariance->topRows<3>().isZero(0.0));
  EXPECT_GT(covariance->bottomRightCorner(6, 6).trace(), 0.0);
}

// Landmarks and their factors enter the problem of Ceres only when something needs them there.
TEST(VariableProjection, ItsProblemHoldsTheGraphAtEveryTime) {
  Bundle bundle(3, 0.02);
  FactorGraph& graph = bundle.graph;
  const auto expect_whole = [&] {
    double sum = 0.0;
    std::size_t observations = 0;
    for (const VariableId& point : bundle.points) {
      if (!graph.Contains(point)) continue;
      for (const FactorId& factor : graph.FactorsOf(point)) {
        double rho[3];
        bundle.loss->Evaluate(graph.SquaredError(factor), rho);
        sum += 0.5 * rho[0];
        ++observations;
      }
    }
    sum += 0.5 * graph.SquaredError(graph.FactorsOf(bundle.poses[0]).front());  // the prior
    EXPECT_EQ(graph.NumFactors(), observations + 1);
    EXPECT_NEAR(graph.Cost(), sum, 1e-12 * sum);  // the order of the sum
    EXPECT_EQ(graph.problem().NumResidualBlocks(), static_cast<int>(graph.NumFactors()));
    EXPECT_EQ(graph.problem().NumParameterBlocks(), static_cast<int>(graph.NumVariables()));
  };
  const SolveOptions project = Exact(LinearSolver::kVariableProjection);
  ASSERT_TRUE(graph.Solve(project).IsUsable());
  expect_whole();
  graph.Remove(bundle.points[2]);
  graph.RemoveFactor(graph.FactorsOf(bundle.points[5]).back());
  bundle.points.push_back(graph.AddLandmark(Point(0.3, 0.2, 2.0)));
  for (int i = 0; i < 2; ++i) {
    graph.AddFactor(MakeObservation(Point(0.1, 0.2, 2.0)), bundle.loss,
                    bundle.poses[Bundle::Index(i)], bundle.points.back());
  }
  graph.Fix(bundle.points[7]);
  ASSERT_TRUE(graph.Solve(project).IsUsable());
  expect_whole();
  EXPECT_TRUE(graph.problem().IsParameterBlockConstant(graph.Block(bundle.points[7])));
  const double cost = graph.Cost();
  ASSERT_TRUE(graph.Solve(Exact(LinearSolver::kDenseSchur)).IsUsable());
  EXPECT_NEAR(graph.Cost(), cost, 1e-9 * cost);  // both are at the minimum
}

TEST(VariableProjection, HasTheCostTheGradientAndTheSchurComplementOfItsFactors) {
  for (const auto& [stretched, damping] :
       {std::pair(false, 0.0), {true, 0.0}, {false, 0.3}, {true, 1e-4}}) {
    Bundle bundle(1, 0.02, stretched);
    bundle.graph.Fix(bundle.poses[1]);
    ceres::Problem& problem = bundle.graph.problem();
    const Bundle::Parts split = bundle.Split();
    const Reduced expected = SchurComplement(problem, split, damping);
    ASSERT_EQ(split.landmarks.landmarks.size(), 12u);
    ASSERT_EQ(split.others.size(), stretched ? 2u : 1u);  // priors

    internal::FactorFaults faults;
    internal::VariableProjection::Memory memory;
    const internal::VariableProjection projection(split.landmarks, damping, &faults, &memory);
    std::vector<double*> blocks;
    for (const auto& block : projection.unknowns()) blocks.push_back(block.values);
    std::vector<double> residuals(static_cast<std::size_t>(projection.num_residuals()));
    std::vector<std::vector<double>> storage;
    std::vector<double*> jacobians;
    for (const auto& block : projection.unknowns()) {
      storage.emplace_back(residuals.size() * static_cast<std::size_t>(block.size));
    }
    for (auto& values : storage) jacobians.push_back(values.data());
    // An entry that another thread has recorded meanwhile is kept.
    const auto other = std::make_unique<OnlyBelowTwo>(false);
    faults.last = other.get();
    ASSERT_TRUE(projection.Evaluate(blocks.data(), residuals.data(), jacobians.data()));
    EXPECT_EQ(faults.last, other.get());

    const Eigen::Index n = projection.num_residuals() - 1;
    const Eigen::Map<const Eigen::VectorXd> r(residuals.data(), n + 1);
    Eigen::MatrixXd J(n + 1, n);
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      const auto& block = projection.unknowns()[i];
      RowMajor plus = RowMajor::Identity(block.size, block.tangent_size);
      if (block.manifold != nullptr) block.manifold->PlusJacobian(block.values, plus.data());
      J.middleCols(column, block.tangent_size) =
          Eigen::Map<RowMajor>(storage[i].data(), n + 1, block.size) * plus;
      column += block.tangent_size;
    }
    ASSERT_EQ(column, n);
    EXPECT_NEAR(0.5 * r.squaredNorm(), expected.cost, 1e-12 * expected.cost);
    // An open landmark is damped by 1e-8.
    EXPECT_TRUE((J.transpose() * J).isApprox(expected.H, 1e-7));
    EXPECT_TRUE((J.transpose() * r).isApprox(expected.g, 1e-7));
    EXPECT_TRUE(J.row(n).isZero(0.0));
  }
}

// With the landmarks' damping alone: that of Ceres is 1e-12 of the reduced diagonal here.
TEST(VariableProjection, CompactSchurTakesTheStepsOfDenseSchur) {
  Bundle expected(7, 0.05, true), bundle(7, 0.05, true);
  for (Bundle* const each : {&expected, &bundle}) {
    // Beside the cost of this landmark no other is far from its minimum and takes further steps.
    const auto fixed = each->graph.AddVariable(Pose());
    each->graph.Fix(fixed);
    const auto doubtful = each->graph.AddLandmark(Point(0, 0, 2));
    for (const double x : {-100.0, 100.0}) {
      each->graph.AddFactor(MakeObservation({x, 0, 2}), fixed, doubtful);
    }
  }
  SolveOptions options{.max_iterations = 3,
                       .function_tolerance = 0.0,
                       .initial_trust_region_radius = 1e12,
                       .linear_solver = LinearSolver::kDenseSchur};
  ASSERT_TRUE(expected.graph.Solve(options).IsUsable());
  options.linear_solver = LinearSolver::kCompactSchur;
  ASSERT_TRUE(bundle.graph.Solve(options).IsUsable());
  // Rounding of a system with condition numbers of about 1e6.
  for (std::size_t j = 0; j < bundle.points.size(); ++j) {
    const Point x = expected.graph.Value(expected.points[j]);
    EXPECT_LT((bundle.graph.Value(bundle.points[j]) - x).norm(), 1e-9);
  }
  for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
    const Pose T = expected.graph.Value(expected.poses[i]);
    const Pose apart = T.Inverse() * bundle.graph.Value(bundle.poses[i]);
    EXPECT_LT(apart.p().norm() + apart.Angle(), 1e-9);
  }
}

TEST(VariableProjection, ACovarianceWithinACallbackDoesNotDisturbTheSolve) {
  for (const LinearSolver solver :
       {LinearSolver::kCompactSchur, LinearSolver::kVariableProjection}) {
    Bundle undisturbed(6, 0.02), bundle(6, 0.02);
    SolveOptions options = Exact(solver);
    ASSERT_TRUE(undisturbed.graph.Solve(options).IsUsable());
    options.on_iteration = [&](int, double) {
      EXPECT_TRUE(bundle.graph.Covariance(bundle.poses[1]));
    };
    ASSERT_TRUE(bundle.graph.Solve(options).IsUsable());
    EXPECT_EQ(bundle.graph.Cost(), undisturbed.graph.Cost());
  }
}

TEST(VariableProjection, FindsTheMinimumThatDenseSchurFinds) {
  for (const bool stretched : {false, true}) {
    Bundle expected(2, 0.05, stretched), bundle(2, 0.05, stretched);
    const SolveSummary wanted = expected.graph.Solve(Exact(LinearSolver::kDenseSchur));
    const SolveSummary summary = bundle.graph.Solve(Exact(LinearSolver::kVariableProjection));
    ASSERT_TRUE(wanted.IsUsable() && summary.IsUsable()) << summary.message;
    EXPECT_NEAR(summary.initial_cost, wanted.initial_cost, 1e-12 * wanted.initial_cost);
    EXPECT_NEAR(summary.final_cost, wanted.final_cost, 1e-9 * wanted.final_cost);
    EXPECT_NEAR(summary.final_cost, bundle.graph.Cost(), 1e-12 * summary.final_cost);
    // Both solvers stop where the cost is flat to rounding, within 1e-8 m of the minimum.
    for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
      const Pose apart =
          bundle.graph.Value(bundle.poses[i]).Inverse() * expected.graph.Value(expected.poses[i]);
      EXPECT_LT(apart.p().norm() + apart.Angle(), 1e-6);
    }
    for (std::size_t j = 0; j < bundle.points.size(); ++j) {
      EXPECT_LT(
          (bundle.graph.Value(bundle.points[j]) - expected.graph.Value(expected.points[j])).norm(),
          1e-6);
    }
  }
}

TEST(VariableProjection, FewIterationsLeadAsFarAsTheyDoWithAllVariables) {
  Bundle expected(3, 0.05), bundle(3, 0.05);
  SolveOptions options{.max_iterations = 3, .linear_solver = LinearSolver::kDenseSchur};
  const SolveSummary wanted = expected.graph.Solve(options);
  options.linear_solver = LinearSolver::kVariableProjection;
  const SolveSummary summary = bundle.graph.Solve(options);
  EXPECT_LE(summary.final_cost, 1.001 * wanted.final_cost);
  EXPECT_NEAR(summary.final_cost, bundle.graph.Cost(), 1e-12 * summary.final_cost);
}

// Has a zero residual and counts how often a step was evaluated.
class CountsTrials final : public ceres::SizedCostFunction<1, 7> {
 public:
  explicit CountsTrials(int* trials) : trials_(trials) {}
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    residuals[0] = 0.0;
    if (jacobians == nullptr) ++*trials_;
    if (jacobians != nullptr && jacobians[0] != nullptr) std::fill_n(jacobians[0], 7, 0.0);
    return true;
  }

 private:
  int* const trials_;
};

// The landmarks are displaced and the poses are at the optimum: a further step would be useless,
// although the last one has lowered the cost considerably.
TEST(VariableProjection, TheGainOfLandmarksAloneNeedsNoFurtherStep) {
  Bundle settled(3, 0.01);
  const SolveOptions exact = Exact(LinearSolver::kVariableProjection);
  const double least = settled.graph.Solve(exact).final_cost;
  for (const auto& point : settled.points) {
    const Point x = settled.graph.Value(point);
    settled.graph.SetValue(point, Point(x + settled.random.Vector(0.03)));
  }
  int trials = 0;
  settled.graph.AddFactor(std::make_unique<CountsTrials>(&trials), settled.poses[1]);
  SolveOptions options = exact;
  options.function_tolerance = 0.05;
  const SolveSummary summary = settled.graph.Solve(options);
  EXPECT_EQ(summary.status, SolveStatus::kConverged) << summary.message;
  EXPECT_EQ(trials, 1);
  EXPECT_GT(summary.initial_cost, 2.0 * least);
  EXPECT_LE(summary.final_cost, 1.01 * least);
}

TEST(VariableProjection, TheSameProblemGivesTheSameBitsWithinOneProcess) {
  const auto run = [] {
    Bundle bundle(4, 0.05);
    bundle.graph.Solve({.linear_solver = LinearSolver::kVariableProjection});
    const Pose pose = bundle.graph.Value(bundle.poses[3]);
    return std::vector<double>(pose.data(), pose.data() + Pose::kSize);
  };
  EXPECT_EQ(run(), run());
}

TEST(VariableProjection, FixedLandmarksAndThoseWithoutFactorsStay) {
  Bundle bundle(5);
  bundle.graph.Fix(bundle.points[0]);
  const Point known = bundle.graph.Value(bundle.points[0]);
  const auto alone = bundle.graph.AddLandmark(Point(1, 2, 3));
  ASSERT_TRUE(bundle.graph.Solve({.linear_solver = LinearSolver::kVariableProjection}).IsUsable());
  EXPECT_EQ(bundle.graph.Value(bundle.points[0]), known);
  EXPECT_EQ(bundle.graph.Value(alone), Point(1, 2, 3));
}

TEST(VariableProjection, LandmarksMoveWhereAllElseIsFixed) {
  Bundle bundle(6);
  for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
    bundle.graph.SetValue(bundle.poses[i], bundle.truth[i]);
    bundle.graph.Fix(bundle.poses[i]);
  }
  const SolveSummary summary = bundle.graph.Solve(Exact(LinearSolver::kVariableProjection));
  ASSERT_TRUE(summary.IsUsable());
  EXPECT_LT(summary.final_cost, 1e-18);
}

// Observes the first coordinate of a landmark. The other two are unobservable.
struct FirstCoordinate {
  double z;

  template <class S>
  bool operator()(const S* pose, const S* x, S* r) const {
    r[0] = x[0] - pose[0] - S(z);
    return true;
  }
};

// This holds whatever other variable is free, and whatever its value is.
TEST(VariableProjection, LandmarksMoveWhereNothingPullsThemAlong) {
  for (const double start : {0.5, 0.0}) {
    Bundle bundle(6);
    for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
      bundle.graph.SetValue(bundle.poses[i], bundle.truth[i]);
      bundle.graph.Fix(bundle.poses[i]);
    }
    const auto apart = bundle.graph.AddVariable(Eigen::Vector3d(start, 0.0, 0.0));
    bundle.graph.AddFactor(
        std::make_unique<VectorPrior<3>>(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()),
        apart);
    const SolveSummary summary = bundle.graph.Solve(Exact(LinearSolver::kVariableProjection));
    ASSERT_TRUE(summary.IsUsable());
    EXPECT_LT(summary.final_cost, 1e-18) << start;
  }
}

TEST(VariableProjection, ALandmarkSeenFromFixedPosesAloneMovesWhereTheOthersStandAlready) {
  Bundle bundle(6);
  for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
    bundle.graph.SetValue(bundle.poses[i], bundle.truth[i]);
  }
  ASSERT_TRUE(bundle.graph.Solve(Exact(LinearSolver::kVariableProjection)).IsUsable());
  const auto fixed = bundle.graph.AddVariable(Pose());
  bundle.graph.Fix(fixed);
  const auto alone = bundle.graph.AddLandmark(Point(1.0, 0.0, 0.0));
  bundle.graph.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<FirstCoordinate, 1, 7, 3>>(
                             new FirstCoordinate{0.25}),
                         fixed, alone);
  const SolveSummary summary = bundle.graph.Solve(Exact(LinearSolver::kVariableProjection));
  ASSERT_TRUE(summary.IsUsable());
  EXPECT_NEAR(bundle.graph.Value(alone)[0], 0.25, 1e-6);
}

TEST(VariableProjection, ForgetsTheCostOfThePreviousSolve) {
  Bundle bundle(6);
  for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
    bundle.graph.SetValue(bundle.poses[i], bundle.truth[i]);
    if (i > 0) bundle.graph.Fix(bundle.poses[i]);
  }
  const auto fixed = bundle.graph.AddVariable(Pose());
  bundle.graph.Fix(fixed);
  const auto observe = [&](double z, const Variable<Point>& x) {
    bundle.graph.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<FirstCoordinate, 1, 7, 3>>(
                               new FirstCoordinate{z}),
                           fixed, x);
  };
  // Contradictory observations: the squared residuals sum up to at least 8e4, a thousandth of which
  // exceeds the contribution of the other landmark.
  const auto torn = bundle.graph.AddLandmark(Point(200.0, 0.0, 0.0));
  observe(0.0, torn);
  observe(400.0, torn);
  ASSERT_TRUE(bundle.graph.Solve(Exact(LinearSolver::kVariableProjection)).IsUsable());
  const auto alone = bundle.graph.AddLandmark(Point(1.0, 0.0, 0.0));
  observe(0.25, alone);
  // With no iterations, no step of the poses moves landmarks.
  const SolveOptions stay{.max_iterations = 0, .linear_solver = LinearSolver::kVariableProjection};
  ASSERT_TRUE(bundle.graph.Solve(stay).IsUsable());
  EXPECT_NEAR(bundle.graph.Value(alone)[0], 0.25, 1e-6);
}

TEST(VariableProjection, ALandmarkThatItsFactorsLeaveOpenStaysWhereTheyDo) {
  Bundle bundle(7);
  const auto open = bundle.graph.AddLandmark(Point(1, 2, 3));
  bundle.graph.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<FirstCoordinate, 1, 7, 3>>(
                             new FirstCoordinate{0.5}),
                         bundle.poses[0], open);
  const SolveSummary summary = bundle.graph.Solve(Exact(LinearSolver::kVariableProjection));
  ASSERT_TRUE(summary.IsUsable()) << summary.message;
  EXPECT_LT(summary.final_cost, 1e-16);
  EXPECT_EQ(bundle.graph.Value(open).tail<2>(), Point(1, 2, 3).tail<2>());
  EXPECT_NEAR(bundle.graph.Value(open).x() - bundle.graph.Value(bundle.poses[0]).p().x(), 0.5,
              1e-8);
}

// Gauss-Newton steps from beyond 1.39 diverge.
struct Arctangent {
  template <class S>
  bool operator()(const S* x, const S* pose, S* r) const {
    using std::atan;
    r[0] = atan(x[0] - pose[0]);
    r[1] = S(0.01) * (x[0] - pose[0]);
    return true;
  }
};

TEST(VariableProjection, StepsOfALandmarkThatLeadUpAreShortened) {
  Bundle bundle(8);
  const auto far = bundle.graph.AddLandmark(8.0);
  bundle.graph.AddFactor(
      std::make_unique<ceres::AutoDiffCostFunction<Arctangent, 2, 1, 7>>(new Arctangent), far,
      bundle.poses[0]);
  const SolveSummary summary = bundle.graph.Solve(Exact(LinearSolver::kVariableProjection));
  ASSERT_TRUE(summary.IsUsable()) << summary.message;
  EXPECT_LT(summary.final_cost, 1e-14);
  EXPECT_NEAR(bundle.graph.Value(far), bundle.graph.Value(bundle.poses[0]).p().x(), 1e-6);
}

TEST(VariableProjection, AFactorThatCannotBeEvaluatedIsNamedAndLeavesAllAsItWas) {
  for (const bool throws : {false, true}) {
    Bundle bundle(9);
    const Pose before = bundle.graph.Value(bundle.poses[0]);
    const auto beyond = bundle.graph.AddLandmark(3.0);
    bundle.graph.AddFactor(std::make_unique<OnlyBelowTwo>(throws), beyond, bundle.poses[0]);
    const SolveSummary summary =
        bundle.graph.Solve({.linear_solver = LinearSolver::kVariableProjection});
    EXPECT_EQ(summary.status, SolveStatus::kFailed);
    EXPECT_NE(summary.message.find("OnlyBelowTwo"), std::string::npos) << summary.message;
    EXPECT_EQ(bundle.graph.Value(beyond), 3.0);
    EXPECT_EQ(bundle.graph.Value(bundle.poses[0]).p(), before.p());
  }
}

}  // namespace
}  // namespace highwall::variable_projection_test
