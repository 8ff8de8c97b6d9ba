#include "variable_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "tangent_blocks.h"

namespace highwall::internal {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Maximum number of separate steps of a landmark at one x, and the decrease that justifies a step,
// as a fraction of the mean cost of a landmark.
constexpr int kMaxSteps = 10;
constexpr double kWorthAStep = 1e-3;
// Factors of a landmark's damping after a step that failed and after one that did not.
constexpr double kAfterFailure = 100.0;
constexpr double kAfterSuccess = 0.3;

bool Plus(const LandmarkProblem::Block& block, const double* x, const double* delta, double* out) {
  if (block.manifold != nullptr) return block.manifold->Plus(x, delta, out);
  for (int i = 0; i < block.size; ++i) out[i] = x[i] + delta[i];
  return true;
}

bool Minus(const LandmarkProblem::Block& block, const double* y, const double* x, double* delta) {
  if (block.manifold != nullptr) return block.manifold->Minus(y, x, delta);
  for (int i = 0; i < block.size; ++i) delta[i] = y[i] - x[i];
  return true;
}

std::size_t Index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

bool VariableProjection::Evaluate(double const* const* parameters, double* residuals,
                                  double** jacobians) const {
  if (!MoveTo(parameters)) {
    if (!faults_->solving || jacobians == nullptr) return false;
    faults_->must_stop = true;  // as GuardedFactor
    FillWithZeros(*this, residuals, jacobians);
    return true;
  }
  if (jacobians == nullptr) {
    const Memory::State& here = memory_.trial.valid ? memory_.trial : memory_.accepted;
    std::fill_n(residuals, num_residuals(), 0.0);
    residuals[num_residuals() - 1] = std::sqrt(here.cost);
    return true;
  }
  if (memory_.trial.valid) std::swap(memory_.accepted, memory_.trial);
  memory_.trial.valid = false;
  memory_.trials = 0;
  WriteRows(residuals, jacobians);
  return true;
}

bool VariableProjection::AddInformation(Eigen::MatrixXd* sum, Eigen::VectorXd* eliminated) const {
  std::vector<const double*> present;
  for (const LandmarkProblem::Block& block : problem_.unknowns) present.push_back(block.values);
  if (!MoveTo(present.data())) return false;
  const Memory::State& here = memory_.trial.valid ? memory_.trial : memory_.accepted;
  if (here.open) return false;
  const Eigen::Index n = here.H.rows();
  sum->topLeftCorner(n, n).triangularView<Eigen::Upper>() += here.H;
  eliminated->head(n) += here.eliminated;
  return true;
}

template <class State>
bool VariableProjection::IsAt(const State& state, double const* const* parameters) const {
  if (!state.valid) return false;
  for (std::size_t i = 0; i < memory_.place.size(); ++i) {
    const int size = problem_.unknowns[i].size;
    if (!std::equal(parameters[i], parameters[i] + size, &state.x[memory_.place[i]])) return false;
  }
  return true;
}

// Evaluates the trial state at x, or leaves it invalid if x is the accepted state.
bool VariableProjection::MoveTo(double const* const* parameters) const {
  if (IsAt(memory_.trial, parameters)) return true;
  memory_.trial.valid = false;
  if (IsAt(memory_.accepted, parameters)) return true;

  for (std::size_t i = 0; i < memory_.place.size(); ++i) {
    std::copy_n(parameters[i], problem_.unknowns[i].size, &memory_.trial.x[memory_.place[i]]);
  }
  ++memory_.trials;
  if (!PrepareUnknowns()) return false;
  Memory::State& trial = memory_.trial;
  trial.Clear();
  for (std::size_t i = 0; i < memory_.layouts.size(); ++i) {
    const int dim = problem_.landmarks[i].block.tangent_size;
    const bool done = dim == 3   ? SolveLandmark<3>(i)
                      : dim == 4 ? SolveLandmark<4>(i)
                                 : SolveLandmark<Eigen::Dynamic>(i);
    if (!done) return false;
    trial.cost += trial.costs[i];
  }
  if (!std::isfinite(trial.H.diagonal().sum() + trial.g.sum())) {
    faults_->last = this;  // the factor can no longer be identified
    return false;
  }
  trial.valid = true;
  return true;
}

bool VariableProjection::PrepareUnknowns() const {
  for (std::size_t i = 0; i < memory_.place.size(); ++i) {
    const LandmarkProblem::Block& block = problem_.unknowns[i];
    const double* const x = &memory_.trial.x[memory_.place[i]];
    memory_.plus[i].setIdentity();
    if (block.manifold != nullptr && !block.manifold->PlusJacobian(x, memory_.plus[i].data())) {
      return false;
    }
    double* const step = memory_.step.data() + memory_.column[i];
    const double* const from = &memory_.accepted.x[memory_.place[i]];
    if (memory_.accepted.valid && !Minus(block, x, from, step)) return false;
  }
  return true;
}

template <int kDim>
bool VariableProjection::SolveLandmark(std::size_t index) const {
  LandmarkNormal<kDim> normal(problem_.landmarks[index].block.tangent_size);
  double* const value = &memory_.trial.landmarks[memory_.layouts[index].value];
  if (!FitLandmark<kDim>(index, value, &normal)) return false;
  memory_.trial.costs[index] = normal.cost;
  memory_.trial.gain += normal.Gain();
  memory_.trial.open |= normal.open;
  Accumulate<kDim>(index);
  Eliminate<kDim>(index, normal);
  return true;
}

// Predicts the landmark from the step of the unknowns and refines it by steps of its own, with
// damping only where it cannot be predicted. Leaves its factors evaluated in the scratch memory.
template <int kDim>
bool VariableProjection::FitLandmark(std::size_t index, double* value,
                                     LandmarkNormal<kDim>* normal) const {
  const LandmarkProblem::Landmark& landmark = problem_.landmarks[index];
  double& damping = memory_.trial.damping[index];
  if (!memory_.accepted.valid) {
    std::copy_n(landmark.block.values, landmark.block.size, value);
    memory_.begins = true;
    const bool done = Linearize<kDim>(landmark, value, damping, normal);
    memory_.begins = false;
    if (!done) return false;
    // Without unknowns it is refined immediately: there may be no step of the unknowns.
    return memory_.layouts[index].coupled > 0 || Descend<kDim>(landmark, value, normal);
  }
  damping = std::max(damping_, kAfterSuccess * memory_.accepted.damping[index]);
  Follow<kDim>(index, value);
  const bool followed = Linearize<kDim>(landmark, value, damping, normal);
  // After a failed first trial the old landmark may be better: with shorter and shorter steps of
  // the unknowns the cost then converges to its previous value.
  if (!followed || (memory_.trials > 1 && normal->cost > memory_.accepted.costs[index])) {
    if (!Stay<kDim>(index, value, followed, normal)) return false;
  }
  if (damping_ > 0.0 && followed) return Settle<kDim>(landmark, value, &damping, normal);
  return Descend<kDim>(landmark, value, normal);
}

// Sets the landmark back to its accepted value, with more damping, unless following the unknowns,
// if that was possible, costs less.
template <int kDim>
bool VariableProjection::Stay(std::size_t index, double* value, bool followed,
                              LandmarkNormal<kDim>* normal) const {
  const LandmarkProblem::Landmark& landmark = problem_.landmarks[index];
  const double* const before = &memory_.accepted.landmarks[memory_.layouts[index].value];
  double& damping = memory_.trial.damping[index];
  const double damping_if_followed = damping;
  const double cost = followed ? normal->cost : std::numeric_limits<double>::infinity();
  damping = kAfterFailure * memory_.accepted.damping[index];
  const bool stayed = Linearize<kDim>(landmark, before, damping, normal);
  if (!stayed && !followed) return false;
  if (stayed && normal->cost <= cost) {
    std::copy_n(before, landmark.block.size, value);
    return true;
  }
  damping = damping_if_followed;
  return Linearize<kDim>(landmark, value, damping, normal);
}

// Further steps of a damped landmark that is far from its minimum, mostly a new one. Few are, and
// in another iteration all others would be evaluated again for them. A failure increases the
// damping.
template <int kDim>
bool VariableProjection::Settle(const LandmarkProblem::Landmark& landmark, double* value,
                                double* damping, LandmarkNormal<kDim>* normal) const {
  const double worth =
      kWorthAStep * memory_.accepted.cost / static_cast<double>(problem_.landmarks.size());
  double* const tried = memory_.tried.data();
  for (int step = 0; step < kMaxSteps && normal->Gain() > worth; ++step) {
    const double cost = normal->cost;
    const Eigen::Matrix<double, kDim, 1> delta = -normal->u;
    if (!Plus(landmark.block, value, delta.data(), tried)) return false;
    const double less = std::max(damping_, kAfterSuccess * *damping);
    if (Linearize<kDim>(landmark, tried, less, normal) && normal->cost < cost) {
      std::copy_n(tried, landmark.block.size, value);
      *damping = less;
      continue;
    }
    *damping *= kAfterFailure;
    if (!Linearize<kDim>(landmark, value, *damping, normal)) return false;
  }
  return true;
}

// Gauss-Newton steps of the landmark alone, shortened if they increase the cost.
template <int kDim>
bool VariableProjection::Descend(const LandmarkProblem::Landmark& landmark, double* value,
                                 LandmarkNormal<kDim>* normal) const {
  const double worth =
      kWorthAStep * memory_.accepted.cost / static_cast<double>(problem_.landmarks.size());
  double* const tried = memory_.tried.data();
  double length = 1.0;
  for (int step = 0; step < kMaxSteps && normal->Gain() > worth; ++step) {
    const double cost = normal->cost;
    const Eigen::Matrix<double, kDim, 1> delta = -length * normal->u;
    if (!Plus(landmark.block, value, delta.data(), tried)) return false;
    if (Linearize<kDim>(landmark, tried, damping_, normal) && normal->cost < cost) {
      std::copy_n(tried, landmark.block.size, value);
      length = 1.0;
      continue;
    }
    if (!Linearize<kDim>(landmark, value, damping_, normal)) return false;
    length *= 0.25;
  }
  if (length < 1.0) normal->u *= length;  // the landmark must not take the full step later either
  return true;
}

template <int kDim>
void VariableProjection::Follow(std::size_t index, double* value) const {
  const LandmarkProblem::Block& block = problem_.landmarks[index].block;
  const Memory::Layout& layout = memory_.layouts[index];
  const int dim = block.tangent_size;
  const double* const feedback = &memory_.accepted.feedback[layout.feedback];
  Eigen::Matrix<double, kDim, 1> delta =
      -Eigen::Map<const Eigen::Matrix<double, kDim, 1>>(feedback, dim);
  const Eigen::Map<const Eigen::Matrix<double, kDim, Eigen::Dynamic>> W(feedback + dim, dim,
                                                                        layout.coupled);
  for (std::size_t c = layout.first_coupling; c < layout.end_coupling; ++c) {
    const auto [unknown, column] = memory_.couplings[c];
    const int tangent = problem_.unknowns[Index(unknown)].tangent_size;
    delta.noalias() -=
        W.middleCols(column, tangent)
            .lazyProduct(memory_.step.segment(memory_.column[Index(unknown)], tangent));
  }
  const double* const before = &memory_.accepted.landmarks[layout.value];
  if (!Plus(block, before, delta.data(), value)) std::copy_n(before, block.size, value);
}

// Evaluates the factors of the landmark into the scratch memory.
template <int kDim>
bool VariableProjection::Linearize(const LandmarkProblem::Landmark& landmark, const double* value,
                                   double damping, LandmarkNormal<kDim>* normal) const {
  const int dim = landmark.block.tangent_size, size = landmark.block.size;
  const ceres::Manifold* const manifold = landmark.block.manifold;
  double* const plus = memory_.landmark_plus.data();
  if (manifold != nullptr && !manifold->PlusJacobian(value, plus)) return false;
  normal->H.setZero();
  normal->g.setZero();
  normal->cost = 0.0;
  bool convex = false;
  double* numbers = memory_.numbers.data();
  double* tangent = memory_.of_landmark.data();
  for (std::size_t f = landmark.first_factor; f < landmark.end_factor; ++f) {
    const LandmarkProblem::Factor& factor = problem_.factors[f];
    // Factors are scattered in memory: fetching one takes as long as evaluating it.
    if (f + 2 < problem_.factors.size()) __builtin_prefetch(problem_.factors[f + 2].cost);
    const double* const ambient = EvaluateFactor(factor, value, numbers);
    if (ambient == nullptr) return Fail(factor);
    const auto silent = SilentRows(*factor.cost, numbers, memory_.jacobians.data());
    if (memory_.begins) memory_.silent[f] = silent;
    if ((silent & ~memory_.silent[f]) != 0) return Fail(factor);
    const int rows = factor.cost->num_residuals();
    double rho[3] = {0.0, 1.0, 0.0};
    const bool finite = WithRows(rows, [&](auto constant) {
      constexpr int kRows = constant;
      MutableRows<kDim, kRows> J(tangent, rows, dim);
      const ConstRows<kDim> to_tangent(plus, size, dim);
      if (manifold != nullptr) {
        J.noalias() = ConstRows<Eigen::Dynamic, kRows>(ambient, rows, size).lazyProduct(to_tangent);
      } else {
        J = ConstRows<kDim, kRows>(ambient, rows, dim);
      }
      const Eigen::Map<const Eigen::Matrix<double, kRows, 1>> r(numbers, rows);
      rho[0] = r.squaredNorm();
      if (factor.loss != nullptr) factor.loss->Evaluate(rho[0], rho);
      const double weight = std::max(0.0, rho[1]);
      memory_.weights[f - landmark.first_factor] = weight;
      for (int i = 0; i < rows; ++i) {
        const Eigen::Matrix<double, kDim, 1> j = weight * J.row(i).transpose();
        normal->H.noalias() += j * J.row(i);
        normal->g.noalias() += r[i] * j;
      }
      return std::isfinite(rho[0] + weight * J.squaredNorm());
    });
    if (!finite) return Fail(factor);
    normal->cost += rho[0];
    convex = convex || rho[2] > 0.0;
    numbers += NumbersOf(*factor.cost);
    tangent += rows * dim;
  }
  normal->Solve(damping);
  normal->open = normal->open || convex;
  return true;
}

bool VariableProjection::Fail(const LandmarkProblem::Factor& factor) const {
  faults_->last = factor.cost;
  return false;
}

// Computes residuals and Jacobians with respect to all but fixed blocks, at the unknowns of the
// trial. Returns the Jacobian with respect to the landmark; null if it cannot be evaluated.
const double* VariableProjection::EvaluateFactor(const LandmarkProblem::Factor& factor,
                                                 const double* landmark, double* out) const {
  const std::vector<int>& sizes = factor.cost->parameter_block_sizes();
  const int rows = factor.cost->num_residuals();
  double* next = out + rows;
  const double* of_landmark = nullptr;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const LandmarkProblem::Argument& argument = problem_.arguments[factor.first_argument + i];
    memory_.jacobians[i] = argument.fixed == nullptr ? next : nullptr;
    memory_.parameters[i] = argument.fixed != nullptr ? argument.fixed
                            : argument.IsLandmark()
                                ? landmark
                                : &memory_.trial.x[memory_.place[Index(argument.unknown)]];
    if (argument.IsLandmark()) of_landmark = next;
    next += rows * sizes[i];
  }
  try {
    if (factor.cost->Evaluate(memory_.parameters.data(), out, memory_.jacobians.data())) {
      return of_landmark;
    }
  } catch (...) {  // as GuardedFactor
  }
  return nullptr;
}

// Adds H_xx and g_x of the landmark's factors, and forms H_lx.
template <int kDim>
void VariableProjection::Accumulate(std::size_t index) const {
  const LandmarkProblem::Landmark& landmark = problem_.landmarks[index];
  const int dim = landmark.block.tangent_size;
  std::fill_n(memory_.coupling.data(), dim * memory_.layouts[index].coupled, 0.0);
  const double* numbers = memory_.numbers.data();
  const double* of_landmark = memory_.of_landmark.data();
  for (std::size_t f = landmark.first_factor; f < landmark.end_factor; ++f) {
    const LandmarkProblem::Factor& factor = problem_.factors[f];
    const int rows = factor.cost->num_residuals();
    WithRows(rows, [&](auto constant) {
      constexpr int kRows = constant;
      const ConstRows<kDim, kRows> J(of_landmark, rows, dim);
      AccumulateFactor<kDim, kRows>(memory_.layouts[index].coupled, factor,
                                    memory_.weights[f - landmark.first_factor], numbers, J);
    });
    numbers += NumbersOf(*factor.cost);
    of_landmark += rows * dim;
  }
}

template <int kDim, int kRows>
void VariableProjection::AccumulateFactor(int coupled, const LandmarkProblem::Factor& factor,
                                          double weight, const double* numbers,
                                          const ConstRows<kDim, kRows>& J_landmark) const {
  const std::vector<int>& sizes = factor.cost->parameter_block_sizes();
  const Eigen::Index rows = J_landmark.rows(), dim = J_landmark.cols();
  const Eigen::Map<const Eigen::Matrix<double, kRows, 1>> r(numbers, rows);
  const double* ambient = numbers + rows;
  double* tangent = memory_.tangent.data();
  double* weighted = memory_.weighted.data();
  Eigen::Map<Eigen::Matrix<double, kDim, Eigen::Dynamic>> E(memory_.coupling.data(), dim, coupled);
  for (std::size_t i = 0; i < sizes.size(); ambient += rows * sizes[i], ++i) {
    const std::size_t a = factor.first_argument + i;
    if (problem_.arguments[a].unknown < 0) continue;
    const std::size_t unknown = Index(problem_.arguments[a].unknown);
    const int dims = problem_.unknowns[unknown].tangent_size;
    memory_.jacobians[i] = tangent;
    WithSize(dims, [&](auto size) {
      constexpr int kTangent = size;
      MutableRows<kTangent, kRows> J(tangent, rows, dims), J_weighted(weighted, rows, dims);
      ToTangent<kTangent, kRows>(unknown, ambient, &J);
      J_weighted = weight * J;
      const int column = memory_.column_of[a];
      AddProduct<kDim, kTangent>(J_landmark, J_weighted, 0, column, &E);
      auto g_a = memory_.trial.g.template segment<kTangent>(memory_.column[unknown], dims);
      for (Eigen::Index row = 0; row < rows; ++row) g_a += r[row] * J_weighted.row(row).transpose();
      for (std::size_t k = 0; k <= i; ++k) {
        const int other = problem_.arguments[factor.first_argument + k].unknown;
        if (other >= 0) AddPair<kTangent, kRows>(J_weighted, unknown, k, Index(other));
      }
    });
    tangent += rows * dims;
  }
}

// Converts the Jacobian with respect to an unknown to its tangent space.
template <int kTangent, int kRows>
void VariableProjection::ToTangent(std::size_t unknown, const double* ambient,
                                   MutableRows<kTangent, kRows>* J) const {
  const LandmarkProblem::Block& block = problem_.unknowns[unknown];
  const double* const plus = memory_.plus[unknown].data();
  if (block.manifold == nullptr) {
    *J = ConstRows<kTangent, kRows>(ambient, J->rows(), J->cols());
  } else if (kTangent == 6 && block.size == 7) {
    J->noalias() = ConstRows<7, kRows>(ambient, J->rows(), 7)
                       .lazyProduct(ConstRows<kTangent, 7>(plus, 7, J->cols()));
  } else {
    J->noalias() = ConstRows<Eigen::Dynamic, kRows>(ambient, J->rows(), block.size)
                       .lazyProduct(ConstRows<kTangent>(plus, block.size, J->cols()));
  }
}

// Adds the block of H for argument k of a factor, which is the unknown `other`, and one whose
// weighted Jacobian is J.
template <int kTangent, int kRows>
void VariableProjection::AddPair(const MutableRows<kTangent, kRows>& J, std::size_t unknown,
                                 std::size_t k, std::size_t other) const {
  const int dims = problem_.unknowns[other].tangent_size;
  WithSize(dims, [&](auto size) {
    constexpr int kOther = size;
    const ConstRows<kOther, kRows> J_other(memory_.jacobians[k], J.rows(), dims);
    const int column = memory_.column[unknown], other_column = memory_.column[other];
    if (other <= unknown) {
      AddProduct<kOther, kTangent>(J_other, J, other_column, column, &memory_.trial.H);
    } else {
      AddProduct<kTangent, kOther>(J, J_other, column, other_column, &memory_.trial.H);
    }
  });
}

// Eliminates the landmark: subtracts H_xl H_ll^-1 H_lx and H_xl H_ll^-1 g_l.
template <int kDim>
void VariableProjection::Eliminate(std::size_t index, const LandmarkNormal<kDim>& normal) const {
  const Memory::Layout& layout = memory_.layouts[index];
  const int dim = problem_.landmarks[index].block.tangent_size;
  using Coupling = Eigen::Matrix<double, kDim, Eigen::Dynamic>;
  const Eigen::Map<const Coupling> E(memory_.coupling.data(), dim, layout.coupled);
  double* const feedback = &memory_.trial.feedback[layout.feedback];
  Eigen::Map<Eigen::Matrix<double, kDim, 1>>(feedback, dim) = normal.u;
  Eigen::Map<Coupling> W(feedback + dim, dim, layout.coupled);
  W.noalias() = normal.inverse.lazyProduct(E);
  for (std::size_t a = layout.first_coupling; a < layout.end_coupling; ++a) {
    const auto [unknown, column] = memory_.couplings[a];
    const int first = memory_.column[Index(unknown)];
    const int dims = problem_.unknowns[Index(unknown)].tangent_size;
    WithSize(dims, [&, c = column](auto size) {
      constexpr int kTangent = size;
      const Eigen::Matrix<double, kTangent, kDim> gain =
          W.template middleCols<kTangent>(c, dims).transpose();
      memory_.trial.g.template segment<kTangent>(first, dims).noalias() -=
          gain.lazyProduct(normal.g);
      memory_.trial.eliminated.template segment<kTangent>(first, dims) +=
          gain.cwiseProduct(E.template middleCols<kTangent>(c, dims).transpose()).rowwise().sum();
      for (std::size_t b = a; b < layout.end_coupling; ++b) {
        const auto [other, other_column] = memory_.couplings[b];
        const int others = problem_.unknowns[Index(other)].tangent_size;
        auto E_b = E.middleCols(other_column, others);
        WithSize(others, [&, place = memory_.column[Index(other)]](auto other_size) {
          constexpr int kOther = other_size;
          memory_.trial.H.template block<kTangent, kOther>(first, place, dims, others).noalias() -=
              gain.lazyProduct(E_b.template leftCols<kOther>(others));
        });
      }
    });
  }
}

// H = P^T L D L^T P: J = D^1/2 L^T P, r = D^-1/2 L^-1 P g. H may be singular: only J^T J matters.
void VariableProjection::WriteRows(double* residuals, double** jacobians) const {
  const Eigen::Index n = memory_.accepted.g.size();
  const Eigen::LDLT<Eigen::MatrixXd, Eigen::Upper> factors(memory_.accepted.H);
  const Eigen::VectorXd& D = factors.vectorD();
  const double least = n > 0 ? 1e-14 * std::max(0.0, D.maxCoeff()) : 0.0;
  const Eigen::VectorXi place =
      factors.transpositionsP() * Eigen::VectorXi::LinSpaced(n, 0, static_cast<int>(n) - 1);
  const Eigen::MatrixXd U = factors.matrixU();
  Eigen::MatrixXd J(n, n);
  for (Eigen::Index i = 0; i < n; ++i) J.col(place[i]) = U.col(i);
  Eigen::VectorXd r = factors.transpositionsP() * memory_.accepted.g;
  factors.matrixL().solveInPlace(r);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double root = D[i] > least ? std::sqrt(D[i]) : 0.0;
    J.row(i) *= root;
    r[i] = root > 0.0 ? r[i] / root : 0.0;
  }
  Eigen::Map<Eigen::VectorXd>(residuals, n) = r;
  memory_.decrease = r.squaredNorm();
  residuals[n] = std::sqrt(std::max(0.0, memory_.accepted.cost - memory_.decrease));
  for (std::size_t i = 0; i < memory_.place.size(); ++i) {
    if (jacobians[i] == nullptr) continue;
    const LandmarkProblem::Block& block = problem_.unknowns[i];
    Eigen::Map<RowMajor> out(jacobians[i], n + 1, block.size);
    RowMajor lift = RowMajor::Identity(block.tangent_size, block.size);
    if (block.manifold != nullptr) {
      block.manifold->MinusJacobian(&memory_.accepted.x[memory_.place[i]], lift.data());
    }
    out.topRows(n).noalias() = J.middleCols(memory_.column[i], block.tangent_size) * lift;
    out.row(n).setZero();
  }
}

void VariableProjection::WriteLandmarks() const {
  if (!memory_.accepted.valid) return;
  for (std::size_t i = 0; i < memory_.layouts.size(); ++i) {
    const LandmarkProblem::Block& block = problem_.landmarks[i].block;
    std::copy_n(&memory_.accepted.landmarks[memory_.layouts[i].value], block.size, block.values);
  }
}

}  // namespace highwall::internal
