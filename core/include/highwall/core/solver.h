#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace [[gnu::visibility("default")]] highwall {

// Solver of the linear system of a step.
enum class LinearSolver {
  kAuto,           // Schur with landmarks, else a Cholesky by the size of the problem
  kDenseCholesky,  // up to a few hundred tangent dimensions
  kSparseCholesky,
  kDenseSchur,  // landmarks first, dense reduced system: up to about 100 poses
  kSparseSchur,
  // As kDenseSchur, with the landmarks eliminated one by one in blocks of fixed size, without any
  // object of Ceres for a landmark: less overhead in a bundle adjustment of a few iterations. The
  // landmarks keep the damping of the first step, and a higher one after a step that failed; those
  // far from their minimum take further damped steps in each iteration. Also terminates when the
  // predicted decrease of the next step is below the tolerance, and continues with kDenseSchur if
  // the poses converge before the landmarks do. One thread; losses must be concave. Same as kAuto
  // if there are no landmarks, or if the other variables have more than 400 tangent dimensions (66
  // poses).
  kCompactSchur,
  // Variable projection: at each step the landmarks are re-estimated after the other variables and
  // eliminated one by one in blocks of fixed size: least overhead in windows of about 20 poses.
  // Also terminates when the predicted decrease of the next step is below the tolerance (of the
  // last one, with factors that do not depend on a landmark). One thread; losses must be concave
  // (rho'' <= 0). Same as kAuto if there are no landmarks.
  kVariableProjection,
};

// Options of the Levenberg-Marquardt solver. The stopping rules are those of Ceres; kCompactSchur,
// kVariableProjection and a solve for variables of one type also end when the next step is
// predicted to gain less than function_tolerance.
struct SolveOptions {
  int max_iterations = 50;  // >= 0
  int threads = 1;          // >= 1; 1: bit-equal results on every run, and OpenMP starts no threads
  double max_seconds = 1e6;                  // [s] > 0
  double function_tolerance = 1e-6;          // >= 0; relative decrease of the cost
  double gradient_tolerance = 1e-10;         // >= 0; largest entry of the projected gradient
  double parameter_tolerance = 1e-8;         // >= 0; relative step
  double initial_trust_region_radius = 1e4;  // > 0; smaller: more careful first steps
  LinearSolver linear_solver = LinearSolver::kAuto;
  // The solver stops after the current iteration once *stop is true. May be null; not owned.
  const std::atomic<bool>* stop = nullptr;
  // Called after each iteration with its number and the cost. May be empty; must not throw.
  std::function<void(int iteration, double cost)> on_iteration = {};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Termination status of the solver.
enum class SolveStatus {
  kConverged,  // a tolerance was met
  kLimit,      // iterations or seconds ran out; the estimate is the best so far
  kStopped,    // SolveOptions::stop
  kFailed,     // no usable estimate; the variables are as they were
};
// "converged", "limit", "stopped" or "failed".
const char* ToString(SolveStatus status);

// Summary of FactorGraph::Solve().
struct SolveSummary {
  SolveStatus status = SolveStatus::kFailed;
  std::string message;        // message of the solver
  double initial_cost = 0.0;  // sum over factors of rho(|r|^2) / 2, fixed parts included
  double final_cost = 0.0;
  int iterations = 0;  // the initial evaluation plus all steps tried, accepted or not
  // Of these, the steps that increased the cost (penalty of SilentOutsideDomain included) or at
  // which a factor could not be evaluated.
  int rejected_steps = 0;
  double seconds = 0.0;  // wall time, preprocessing included

  bool IsUsable() const { return status != SolveStatus::kFailed; }
};

}  // namespace highwall
