#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace [[gnu::visibility("default")]] highwall {

// How the linear system of a step is solved.
enum class LinearSolver {
  kAuto,           // Schur where there are landmarks, else a Cholesky by the size of the problem
  kDenseCholesky,  // up to a few hundred tangent dimensions
  kSparseCholesky,
  kDenseSchur,  // landmarks first, dense reduced system: up to some 100 poses
  kSparseSchur,
  // Landmarks follow the others at each step, eliminated one by one in blocks of fixed size: least
  // overhead in windows of some 20 poses. Also ends where a step was foretold to gain less than the
  // tolerance. One thread; losses must be concave (rho'' <= 0). kAuto where there are no landmarks.
  kVariableProjection,
};

// Levenberg-Marquardt; the stopping rules are those of Ceres, and one of kVariableProjection.
struct SolveOptions {
  int max_iterations = 50;                   // >= 0
  int threads = 1;                           // >= 1; 1 gives bit-equal results on every run
  double max_seconds = 1e6;                  // [s] > 0
  double function_tolerance = 1e-6;          // >= 0; relative decrease of the cost
  double gradient_tolerance = 1e-10;         // >= 0; largest entry of the projected gradient
  double parameter_tolerance = 1e-8;         // >= 0; relative step
  double initial_trust_region_radius = 1e4;  // > 0; smaller: more careful first steps
  LinearSolver linear_solver = LinearSolver::kAuto;
  // Solving ends after the running iteration once *stop is true. May be null; not owned.
  const std::atomic<bool>* stop = nullptr;
  // Called after each iteration with its number and the cost. May be empty; must not throw.
  std::function<void(int iteration, double cost)> on_iteration = {};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How a solve ended.
enum class SolveStatus {
  kConverged,  // a tolerance was met
  kLimit,      // iterations or seconds ran out; the estimate is the best so far
  kStopped,    // SolveOptions::stop
  kFailed,     // no usable estimate; the variables are as they were
};
// "converged", "limit", "stopped" or "failed".
const char* ToString(SolveStatus status);

// What became of a solve.
struct SolveSummary {
  SolveStatus status = SolveStatus::kFailed;
  std::string message;        // the solver's own words
  double initial_cost = 0.0;  // sum over factors of rho(|r|^2) / 2, fixed parts included
  double final_cost = 0.0;
  int iterations = 0;  // the evaluation at the start and steps tried, accepted or not
  // Of these, steps that would have raised the cost, by SilentOutsideDomain too, or led where a
  // factor cannot be evaluated.
  int rejected_steps = 0;
  double seconds = 0.0;  // wall time, preprocessing included

  bool IsUsable() const { return status != SolveStatus::kFailed; }
};

}  // namespace highwall
