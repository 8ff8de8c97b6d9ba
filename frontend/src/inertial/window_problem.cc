#include "inertial/window_problem.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <highwall/internal/quiet_glog.h>

namespace highwall {
namespace {

constexpr int kMaxIterations = 10;
constexpr double kFunctionTolerance = 1e-3;
// Pivot of the equations, relative to their diagonal before any elimination, below which a
// direction is unobservable.
constexpr double kMinPivot = 1e-13;

// Stops the solver on request, or where the last step is predicted to gain little: the actual
// decrease also contains the steps of landmarks alone, mostly new ones.
class WindowCallback final : public ceres::IterationCallback {
 public:
  explicit WindowCallback(const std::atomic<bool>& stop) : stop_(stop) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    const bool is_last =
        iteration.iteration > 0 && iteration.step_is_successful &&
        iteration.cost_change <= iteration.relative_decrease * kFunctionTolerance * iteration.cost;
    return is_last || stop_.load(std::memory_order_relaxed) ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                            : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::atomic<bool>& stop_;
};

ceres::Solver::Options WindowSolverOptions(ceres::IterationCallback* callback) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = kMaxIterations;
  options.function_tolerance = kFunctionTolerance;
  options.logging_type = ceres::SILENT;
  options.callbacks.push_back(callback);
  return options;
}

}  // namespace

std::string WindowProblem::Begin(WindowGraph* graph, WindowLandmarks* landmarks) {
  graph_ = graph;
  landmarks_ = landmarks;
  landmarks_->Begin();
  unknowns_ = graph->unknowns;
  layout_.OrderForSolver(graph->states(), graph->unknowns);
  const int unknowns = layout_.size - layout_.inner;
  *mutable_parameter_block_sizes() = {unknowns};
  set_num_residuals(unknowns + 1);
  accepted_.valid = trial_.valid = false;
  trials_ = 0;
  fault_.clear();
  const Eigen::VectorXd start = Eigen::VectorXd::Zero(unknowns);
  if (!MoveTo(start.data())) return fault_.empty() ? "a landmark cannot be evaluated" : fault_;
  return "";
}

std::string WindowProblem::Solve(const std::atomic<bool>& stop, WindowGraph* graph,
                                 WindowLandmarks* landmarks) {
  std::string fault = Begin(graph, landmarks);
  if (!fault.empty()) return fault;
  ceres::Problem::Options shared;
  shared.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(shared);
  std::vector<double> x(static_cast<std::size_t>(layout_.size - layout_.inner), 0.0);
  problem.AddResidualBlock(this, nullptr, x.data());
  WindowCallback callback(stop);
  ceres::Solver::Summary summary;
  {
    const internal::QuietGlog quiet;
    ceres::Solve(WindowSolverOptions(&callback), &problem, &summary);
  }
  if (!summary.IsSolutionUsable()) return "the solver failed: " + summary.message;
  graph->values = accepted_.values;
  landmarks->SetValues(accepted_.landmarks);
  return "";
}

std::string WindowProblem::Linearize(WindowGraph* graph, WindowLandmarks* landmarks) {
  std::string fault = Begin(graph, landmarks);
  if (fault.empty()) Accept();
  return fault;
}

bool WindowProblem::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  if (!MoveTo(parameters[0])) return false;
  if (jacobians == nullptr || jacobians[0] == nullptr) {
    std::fill_n(residuals, num_residuals(), 0.0);
    residuals[num_residuals() - 1] = std::sqrt((trial_.valid ? trial_ : accepted_).cost);
    return true;
  }
  Accept();
  WriteRows(residuals, jacobians[0]);
  return true;
}

// Evaluates the trial point at x, or leaves it invalid if x is the accepted point.
bool WindowProblem::MoveTo(const double* x) const {
  const Eigen::Map<const Eigen::VectorXd> at(x, layout_.size - layout_.inner);
  if (trial_.valid && trial_.x == at) return true;
  trial_.valid = false;
  if (accepted_.valid && accepted_.x == at) return true;
  ++trials_;
  trial_.x = at;
  if (accepted_.valid) {
    StepTo(trial_.x);
  } else {
    trial_.values = graph_->values;
  }
  if (!trial_.values.IsFinite()) return false;
  trial_.frames.MoveTo(trial_.values, graph_->images, graph_->unknowns);
  system_.Reset(static_cast<int>(trial_.frames.frames.size()));
  const WindowLandmarks::Step step{accepted_.landmarks, frame_step_, trials_ > 1};
  if (!landmarks_->Evaluate(trial_.frames, accepted_.valid ? &step : nullptr, &trial_.landmarks,
                            &system_)) {
    return false;
  }
  normal_.Reset(layout_.size);
  system_.AddTo(trial_.frames, layout_, &normal_);
  normal_.cost = trial_.landmarks.cost;
  fault_ = graph_->AddTo(trial_.values, layout_, &normal_);
  if (!fault_.empty()) return false;
  trial_.cost = std::max(0.0, normal_.cost);
  trial_.valid = Reduce();
  return trial_.valid;
}

// Moves all variables from the accepted point by the step to x, the inner ones by their feedback.
// After a failed trial that is their feedback to the step alone, so that the cost converges to the
// previous one with shorter and shorter steps.
void WindowProblem::StepTo(const Eigen::VectorXd& x) const {
  const Eigen::Index inner = layout_.inner;
  step_.resize(layout_.size);
  step_.tail(x.size()) = x - accepted_.x;
  auto of_inner = step_.head(inner);
  of_inner.noalias() = -accepted_.B * step_.tail(x.size());
  if (trials_ == 1) of_inner -= accepted_.l;
  accepted_.inner.matrixU().solveInPlace(of_inner);
  Plus(accepted_.values, step_, layout_, graph_->unknowns, &trial_.values);
  accepted_.frames.StepsOf(step_, layout_, &frame_step_);
}

// Eliminates the inner rows from the equations at the trial point.
bool WindowProblem::Reduce() const {
  const Eigen::Index inner = layout_.inner, outer = layout_.size - inner;
  if (!std::isfinite(normal_.cost + normal_.H.diagonal().sum() + normal_.g.sum())) {
    fault_ = "the equations are not finite";
    return false;
  }
  trial_.H = normal_.H.bottomRightCorner(outer, outer);
  trial_.g = normal_.g.tail(outer);
  trial_.eliminated = normal_.eliminated.tail(outer);
  trial_.B = normal_.H.topRightCorner(inner, outer);
  trial_.l = normal_.g.head(inner);
  if (inner == 0) return true;
  trial_.inner.compute(normal_.H.topLeftCorner(inner, inner));
  if (trial_.inner.info() != Eigen::Success) {
    fault_ = "a velocity or a bias is not observable";
    return false;
  }
  trial_.inner.matrixL().solveInPlace(trial_.B);
  trial_.inner.matrixL().solveInPlace(trial_.l);
  trial_.H.selfadjointView<Eigen::Lower>().rankUpdate(trial_.B.transpose(), -1.0);
  trial_.eliminated += trial_.B.colwise().squaredNorm().transpose();
  trial_.g.noalias() -= trial_.B.transpose() * trial_.l;
  return true;
}

void WindowProblem::Accept() const {
  if (trial_.valid) std::swap(accepted_, trial_);
  trial_.valid = false;
  trials_ = 0;
  factors_.compute(accepted_.H);
}

// H = L L^T: J = L^T, r = L^-1 g. Where H is singular, by rounding, P^T L D^1/2 instead of L.
void WindowProblem::WriteRows(double* residuals, double* jacobian) const {
  const Eigen::Index n = accepted_.g.size();
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<RowMajor> J(jacobian, n + 1, n);
  Eigen::Map<Eigen::VectorXd> r(residuals, n);
  J.setZero();
  if (factors_.info() == Eigen::Success) {
    J.topRows(n).triangularView<Eigen::Upper>() = factors_.matrixU();
    r = factors_.matrixL().solve(accepted_.g);
  } else {
    const Eigen::LDLT<Eigen::MatrixXd> pivoted(accepted_.H);
    const Eigen::VectorXd& D = pivoted.vectorD();
    const double least = 1e-14 * std::max(0.0, D.maxCoeff());
    const Eigen::VectorXd root =
        D.unaryExpr([&](double d) { return d > least ? std::sqrt(d) : 0.0; });
    const Eigen::MatrixXd U = pivoted.matrixU();
    J.topRows(n) = root.asDiagonal() * U * pivoted.transpositionsP();
    r = pivoted.transpositionsP() * accepted_.g;
    pivoted.matrixL().solveInPlace(r);
    r = r.binaryExpr(root, [](double value, double d) { return d > 0.0 ? value / d : 0.0; }).eval();
  }
  residuals[n] = std::sqrt(std::max(0.0, accepted_.cost - r.squaredNorm()));
}

std::optional<Eigen::MatrixXd> WindowProblem::Covariance() const {
  if (factors_.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd diagonal = accepted_.H.diagonal();
  const Eigen::VectorXd pivots =
      factors_.matrixLLT().diagonal().cwiseAbs2().cwiseQuotient(diagonal + accepted_.eliminated);
  if (!(pivots.minCoeff() > kMinPivot)) return std::nullopt;
  std::vector<int> rows;  // among the unknowns, -1 if known
  const auto add = [&](int first, int count) {
    for (int k = 0; k < count; ++k) rows.push_back(first - layout_.inner + k);
  };
  add(layout_.head.back(), 6);
  add(layout_.tail.back(), WindowState::kTail);
  add(layout_.gravity, WindowLayout::kGravity);
  if (!unknowns_.time_offset) rows.push_back(-1);
  add(layout_.cameras, unknowns_.size());
  add(layout_.head.back() + 6, 6);
  Eigen::MatrixXd X =
      Eigen::MatrixXd::Zero(diagonal.size(), static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows[k] >= 0) X(rows[k], static_cast<Eigen::Index>(k)) = 1.0;
  }
  factors_.matrixL().solveInPlace(X);
  return X.transpose() * X;
}

}  // namespace highwall
