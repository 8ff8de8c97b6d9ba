#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/manifolds.h>

#include "support/simulated_window.h"

// Monte-Carlo consistency: over many runs the error of the newest pose, normalised by the
// covariance that the smoother states (NEES), is chi-squared with six degrees of freedom. Source:
// Bar-Shalom, Li, Kirubarajan, "Estimation with applications to tracking and navigation", 2001,
// section 5.4.2.
namespace highwall::smoother_consistency_test {
namespace {

constexpr int kRuns = 40;
constexpr int kKeyframes = 20;
constexpr int kWindow = 6;

// Returns e^T P^-1 e of the newest pose after a run.
double Nees(const SimulatedWindowOptions& simulation, const SlidingWindowOptions& options,
            unsigned seed) {
  SimulatedWindow world(simulation, seed);
  SlidingWindowSmoother smoother(options);
  Variable<Pose> newest;
  for (int k = 0; k < kKeyframes; ++k) {
    newest = world.AddKeyframe(&smoother);
    const UpdateReport report = smoother.Update();
    EXPECT_TRUE(report.accepted) << report.message;
  }
  const Pose truth = SimulatedWindow::Truth(kKeyframes - 1), estimate = smoother.Value(newest);
  Eigen::Matrix<double, 6, 1> error;
  PoseManifold().Minus(truth.data(), estimate.data(), error.data());
  const std::optional<Eigen::MatrixXd> covariance = smoother.NewestCovariance();
  EXPECT_TRUE(covariance.has_value());
  return error.dot(covariance->ldlt().solve(error));
}

// The sum over runs is chi-squared with 6 kRuns degrees of freedom. Its 99.8 % band uses the
// approximation of Wilson and Hilferty, exact to three digits at this size.
void ExpectConsistent(const SimulatedWindowOptions& simulation,
                      const SlidingWindowOptions& options) {
  double sum = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) sum += Nees(simulation, options, seed);
  ::testing::Test::RecordProperty("mean_nees", std::to_string(sum / kRuns));
  const double n = 6.0 * kRuns, z = 3.09;
  const auto quantile = [n](double deviate) {
    return n * std::pow(1.0 - 2.0 / (9.0 * n) + deviate * std::sqrt(2.0 / (9.0 * n)), 3.0);
  };
  EXPECT_GT(sum, quantile(-z)) << "mean " << sum / kRuns << ": too pessimistic";
  EXPECT_LT(sum, quantile(z)) << "mean " << sum / kRuns << ": too sure of itself";
}

SlidingWindowOptions Window() {
  return {.max_states = kWindow, .solve = {.max_iterations = 10, .function_tolerance = 1e-6}};
}

SimulatedWindowOptions Only(int points, int lines) {
  SimulatedWindowOptions simulation;
  simulation.new_points = points;
  simulation.new_lines = lines;
  simulation.track_length = 5;
  simulation.odometry_sigma = 0.0;
  return simulation;
}

TEST(SmootherConsistency, OfPoints) {
  ExpectConsistent(Only(6, 0), Window());
}

TEST(SmootherConsistency, OfLines) {
  ExpectConsistent(Only(0, 6), Window());
}

TEST(SmootherConsistency, OfRelativePoses) {
  SimulatedWindowOptions simulation = Only(0, 0);
  simulation.odometry_sigma = 0.02;
  ExpectConsistent(simulation, Window());
}

TEST(SmootherConsistency, OfAllTogetherWithEveryPolicy) {
  SimulatedWindowOptions simulation = Only(2, 2);
  simulation.odometry_sigma = 0.02;
  SlidingWindowOptions options = Window();
  for (const LandmarkPolicy landmarks :
       {LandmarkPolicy::kKeepTracked, LandmarkPolicy::kMarginalize}) {
    for (const bool first_estimates : {false, true}) {
      options.landmarks = landmarks;
      options.marginalization.first_estimate_jacobians = first_estimates;
      ExpectConsistent(simulation, options);
    }
  }
}

TEST(SmootherConsistency, OfTheLeastInformationPolicy) {
  SlidingWindowOptions options = Window();
  options.leaving = LeavingPolicy::kLeastInformation;
  SimulatedWindowOptions simulation = Only(3, 2);
  simulation.odometry_sigma = 0.02;
  ExpectConsistent(simulation, options);
}

TEST(SmootherConsistency, TheSameRunGivesTheSameBits) {
  SimulatedWindowOptions simulation = Only(5, 5);
  simulation.odometry_sigma = 0.02;
  SlidingWindowOptions options = Window();
  options.leaving = LeavingPolicy::kLeastInformation;
  const auto run = [&] {
    SimulatedWindow world(simulation, 1);
    SlidingWindowSmoother smoother(options);
    Variable<Pose> newest;
    for (int k = 0; k < kKeyframes; ++k) {
      newest = world.AddKeyframe(&smoother);
      smoother.Update();
    }
    const Pose pose = smoother.Value(newest);
    return std::vector<double>(pose.data(), pose.data() + Pose::kSize);
  };
  // Solvers that leave the Schur complement to Ceres are excluded: Ceres sorts the landmarks by
  // address, and addresses differ within one process.
  for (const LinearSolver solver :
       {LinearSolver::kSparseCholesky, LinearSolver::kVariableProjection}) {
    options.solve.linear_solver = solver;
    EXPECT_EQ(run(), run());
  }
}

}  // namespace
}  // namespace highwall::smoother_consistency_test
