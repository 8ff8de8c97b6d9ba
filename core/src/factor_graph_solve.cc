#include <highwall/core/factor_graph.h>

#include <algorithm>
#include <optional>
#include <utility>

#include <ceres/solver.h>

#include <highwall/internal/quiet_glog.h>
#include "factor_graph_impl.h"
#include "one_openmp_thread.h"
#include "projected_problem.h"
#include "solve_callback.h"

namespace highwall {
namespace {

// Reduced systems up to this many tangent dimensions are solved densely.
constexpr int kMaxDenseDimensions = 400;

ceres::LinearSolverType ToCeres(LinearSolver solver, bool has_landmarks, int other_dimensions) {
  switch (solver) {
    case LinearSolver::kDenseCholesky:
      return ceres::DENSE_NORMAL_CHOLESKY;
    case LinearSolver::kSparseCholesky:
      return ceres::SPARSE_NORMAL_CHOLESKY;
    case LinearSolver::kDenseSchur:
      return ceres::DENSE_SCHUR;
    case LinearSolver::kSparseSchur:
      return ceres::SPARSE_SCHUR;
    case LinearSolver::kCompactSchur:        // without landmarks, or with many other variables
    case LinearSolver::kVariableProjection:  // without landmarks
    case LinearSolver::kAuto:
      break;
  }
  const bool dense = other_dimensions <= kMaxDenseDimensions;
  if (has_landmarks) return dense ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  return dense ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
}

// Returns whether the landmarks are eliminated by a cost function, not by Ceres.
bool EliminatesByItself(LinearSolver solver, int other_dimensions) {
  if (other_dimensions == 0) return false;
  return solver == LinearSolver::kVariableProjection ||
         (solver == LinearSolver::kCompactSchur && other_dimensions <= kMaxDenseDimensions);
}

double DampingOfLandmarks(const SolveOptions& options) {
  const bool damps = options.linear_solver == LinearSolver::kCompactSchur;
  return damps ? 1.0 / options.initial_trust_region_radius : 0.0;
}

ceres::Solver::Options ToCeres(const SolveOptions& options) {
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.max_solver_time_in_seconds = options.max_seconds;
  solver.num_threads = options.threads;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = options.gradient_tolerance;
  solver.parameter_tolerance = options.parameter_tolerance;
  solver.initial_trust_region_radius = options.initial_trust_region_radius;
  solver.max_trust_region_radius =
      std::max(solver.max_trust_region_radius, options.initial_trust_region_radius);
  solver.logging_type = ceres::SILENT;
  return solver;
}

SolveStatus ToStatus(ceres::TerminationType type) {
  switch (type) {
    case ceres::CONVERGENCE:
      return SolveStatus::kConverged;
    case ceres::NO_CONVERGENCE:
      return SolveStatus::kLimit;
    case ceres::USER_SUCCESS:
      return SolveStatus::kStopped;
    default:
      return SolveStatus::kFailed;
  }
}

// Ceres knows only that a callback ended the solve.
SolveSummary WithConvergenceOf(const internal::SolveCallback& callback, SolveSummary summary) {
  if (callback.converged() && summary.IsUsable()) {
    summary.status = SolveStatus::kConverged;
    summary.message = "a step is predicted to gain less than function_tolerance";
  }
  return summary;
}

}  // namespace

SolveSummary FactorGraph::Impl::Summarize(const ceres::Solver::Summary& ceres_summary) {
  SolveSummary summary;
  summary.status = ToStatus(ceres_summary.termination_type);
  summary.message = ceres_summary.message;
  if (!summary.IsUsable()) {
    const std::string fault = faults.last != nullptr ? FirstFault() : FirstUndetermined();
    if (!fault.empty()) summary.message = fault;
  }
  summary.initial_cost = ceres_summary.initial_cost;
  summary.final_cost = ceres_summary.final_cost;
  summary.iterations =
      std::max(0, ceres_summary.num_successful_steps) +  // -1 if there was nothing to solve
      std::max(0, ceres_summary.num_unsuccessful_steps);
  summary.rejected_steps = std::max(0, ceres_summary.num_unsuccessful_steps);
  summary.seconds = ceres_summary.total_time_in_seconds;
  return summary;
}

SolveSummary FactorGraph::Impl::RunWhole(const SolveOptions& options,
                                         ceres::Solver::Options solver) {
  internal::SolveCallback callback(options, faults,
                                   {.by_gradients = FindUnknowns().are_of_one_type});
  solver.callbacks = {&callback};
  CompleteProblem();
  ceres::Solver::Summary of_ceres;
  {
    const internal::QuietGlog quiet;
    ceres::Solve(solver, &problem, &of_ceres);
  }
  return WithConvergenceOf(callback, Summarize(of_ceres));
}

SolveSummary FactorGraph::Impl::Run(const SolveOptions& options, ceres::Solver::Options solver,
                                    internal::ProjectedProblem& projected) {
  internal::SolveCallback callback(options, faults, {.projected = &projected});
  solver.callbacks = {&callback};
  ceres::Solver::Summary of_ceres;
  {
    const internal::QuietGlog quiet;
    projected.Solve(solver, &of_ceres);
  }
  return WithConvergenceOf(callback, Summarize(of_ceres));
}

SolveSummary FactorGraph::Impl::Continue(const SolveOptions& options, ceres::Solver::Options solver,
                                         const SolveSummary& first) {
  // The evaluation at the start is the first iteration.
  solver.max_num_iterations = std::max(0, options.max_iterations - first.iterations + 1);
  if (solver.max_num_iterations == 0) {
    SolveSummary summary = first;
    summary.status = SolveStatus::kLimit;
    summary.message = "no iteration is left for the landmarks";
    return summary;
  }
  solver.max_solver_time_in_seconds = std::max(0.0, options.max_seconds - first.seconds);
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  SolveSummary summary = RunWhole(options, solver);
  if (!summary.IsUsable()) return first;
  summary.initial_cost = first.initial_cost;
  summary.iterations += first.iterations - 1;
  summary.rejected_steps += first.rejected_steps;
  summary.seconds += first.seconds;
  return summary;
}

SolveSummary FactorGraph::Solve(const SolveOptions& options) {
  std::optional<Eigen::MatrixXd> none;
  return SolveWithCovariance(options, {}, &none);
}

SolveSummary FactorGraph::SolveWithCovariance(const SolveOptions& options,
                                              std::span<const VariableId> variables,
                                              std::optional<Eigen::MatrixXd>* covariance) {
  options.Validate();
  covariance->reset();
  const Impl::Unknowns unknowns = impl_->FindUnknowns();
  const int dimensions = unknowns.other_dimensions;
  const bool has_landmarks = unknowns.HasLandmarks();
  const bool project = has_landmarks && EliminatesByItself(options.linear_solver, dimensions);
  ceres::Solver::Options solver = ToCeres(options);
  solver.linear_solver_type = ToCeres(options.linear_solver, has_landmarks && !project, dimensions);
  // The choice of eliminated blocks is left to Ceres, which finds the landmarks by itself: it would
  // sort a given set by address, and runs would no longer be bit-identical.
  if ((project || ceres::IsSchurType(solver.linear_solver_type)) &&
      impl_->LandmarksDependOnEachOther()) {
    SolveSummary refused;
    refused.message = "a factor joins two landmarks: they are not an independent set";
    return refused;
  }

  const internal::OneOpenMpThread one_thread(options.threads == 1);
  const double damping = DampingOfLandmarks(options);
  std::optional<internal::ProjectedProblem> projected;
  if (project) {
    std::vector<ceres::ResidualBlockId> others;
    internal::LandmarkProblem landmarks = impl_->Split(&others);
    // No unknown is connected to a landmark: each landmark is a separate problem.
    if (landmarks.unknowns.empty()) {
      solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    } else {
      projected.emplace(impl_->problem, std::move(landmarks), std::move(others), damping,
                        &impl_->faults, &impl_->projection_memory);
    }
  }
  impl_->faults.last = nullptr;
  impl_->faults.must_stop = false;
  impl_->faults.solving = true;
  ++impl_->faults.solve;
  SolveSummary summary =
      projected ? impl_->Run(options, solver, *projected) : impl_->RunWhole(options, solver);
  // The rules of Ceres see the poses only: landmarks may be far from the minimum when these rest.
  if (projected && summary.status == SolveStatus::kConverged &&
      !projected->LandmarksRest(options.function_tolerance)) {
    summary = impl_->Continue(options, solver, summary);
  }
  impl_->faults.solving = false;
  if (projected && !variables.empty() && summary.IsUsable()) {
    *covariance = damping > 0.0 ? ReducedCovariance(variables)
                                : impl_->CovarianceOf(variables, *projected, unknowns);
  }
  return summary;
}

std::optional<Eigen::MatrixXd> FactorGraph::Covariance(
    std::span<const VariableId> variables) const {
  // With landmarks eliminated one by one a small dense system is left.
  // A solve that is running, whose callback asks, uses the memory of the elimination.
  const int left = impl_->FindUnknowns().other_dimensions;
  if (!impl_->faults.solving && left > 0 && left <= kMaxDenseDimensions) {
    if (auto reduced = ReducedCovariance(variables)) return reduced;
  }
  std::vector<double*> wanted;
  for (const VariableId& id : variables) wanted.push_back(impl_->At(id).block);
  impl_->CompleteProblem();
  return internal::TangentCovariance(impl_->problem, impl_->FindUnknowns().all, wanted);
}

std::string FactorGraph::Undetermined() const {
  return impl_->FirstUndetermined();
}

std::optional<Eigen::MatrixXd> FactorGraph::ReducedCovariance(
    std::span<const VariableId> variables) const {
  const Impl::Unknowns unknowns = impl_->FindUnknowns();
  if (!unknowns.HasLandmarks() || impl_->LandmarksDependOnEachOther()) return std::nullopt;
  impl_->faults.last = nullptr;
  std::vector<ceres::ResidualBlockId> others;
  internal::LandmarkProblem landmarks = impl_->Split(&others);
  const internal::ProjectedProblem projected(impl_->problem, std::move(landmarks),
                                             std::move(others), 0.0, &impl_->faults,
                                             &impl_->projection_memory);
  return impl_->CovarianceOf(variables, projected, unknowns);
}

}  // namespace highwall
