#include "inertial/window_graph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

using FactorKind = WindowFactor::Kind;

constexpr int kMostRows = 15;     // of a factor
constexpr int kMostColumns = 32;  // tangent dimensions of its variables
constexpr std::size_t kMostVariables = 7;
// Share of the unit diagonal below which a direction of a leaving state is unobservable, and by
// which the constant of a prior is damped.
constexpr double kOpenDirection = 1e-10;
constexpr double kDamping = 1e-9;

const double* BlockOf(const WindowFactor::Variable& variable, const WindowValues& values) {
  if (variable.kind == FactorKind::kGravityDirection) return values.gravity.data();
  const WindowState& state = values.states[static_cast<std::size_t>(variable.state)];
  switch (variable.kind) {
    case FactorKind::kBody:
      return state.T_VB.data();
    case FactorKind::kMap:
      return state.T_VW.data();
    case FactorKind::kVelocity:
      return state.velocity.data();
    default:
      return state.bias.data();
  }
}

int FirstRowOf(const WindowFactor::Variable& variable, const WindowLayout& layout) {
  const auto state = static_cast<std::size_t>(variable.state);
  switch (variable.kind) {
    case FactorKind::kBody:
      return layout.head[state];
    case FactorKind::kMap:
      return layout.head[state] + 6;
    case FactorKind::kVelocity:
      return layout.tail[state];
    case FactorKind::kBias:
      return layout.tail[state] + 3;
    default:
      return layout.gravity;
  }
}

using AmbientRows =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMostRows, 7>;

// Linearizes a factor in the tangent spaces of its variables.
struct LinearFactor {
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostRows, 1> r;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostRows, kMostColumns> J;
  std::array<int, kMostColumns> place;  // of each column

  bool Evaluate(const WindowFactor& factor, const WindowValues& values,
                const WindowLayout& layout) {
    const std::vector<int>& sizes = factor.cost->parameter_block_sizes();
    const int rows = factor.cost->num_residuals();
    std::array<AmbientRows, kMostVariables> ambient;
    std::array<const double*, kMostVariables> parameters;
    std::array<double*, kMostVariables> jacobians;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      ambient[i].resize(rows, sizes[i]);
      parameters[i] = BlockOf(factor.variables[i], values);
      jacobians[i] = ambient[i].data();
    }
    r.resize(rows);
    if (!factor.cost->Evaluate(parameters.data(), r.data(), jacobians.data())) return false;
    J.resize(rows, kMostColumns);
    int columns = 0;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const int first = columns;
      columns += Append(factor.variables[i].kind, ambient[i], parameters[i], first);
      for (int k = first; k < columns; ++k) {
        place[static_cast<std::size_t>(k)] = FirstRowOf(factor.variables[i], layout) + k - first;
      }
    }
    J.conservativeResize(rows, columns);
    return std::isfinite(r.squaredNorm() + J.squaredNorm());
  }

  // Writes the tangent columns of a variable; returns their number.
  int Append(FactorKind kind, const AmbientRows& ambient, const double* at, int column) {
    if (kind == FactorKind::kBody || kind == FactorKind::kMap) {
      Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
      PoseManifold().PlusJacobian(at, plus.data());
      J.middleCols<6>(column).noalias() = ambient.lazyProduct(plus);
      return 6;
    }
    if (kind == FactorKind::kGravityDirection) {
      J.middleCols<2>(column).noalias() = ambient.lazyProduct(UnitDirectionManifold::Basis(at));
      return 2;
    }
    J.middleCols(column, ambient.cols()) = ambient;
    return static_cast<int>(ambient.cols());
  }

  void AddTo(WindowNormal* normal) const {
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostColumns, kMostColumns> H =
        J.transpose().lazyProduct(J);
    for (Eigen::Index c = 0; c < H.cols(); ++c) {
      const int column = place[static_cast<std::size_t>(c)];
      for (Eigen::Index k = 0; k < H.rows(); ++k) {
        normal->H(place[static_cast<std::size_t>(k)], column) += H(k, c);
      }
      normal->g[column] += J.col(c).dot(r);
    }
    normal->cost += r.squaredNorm();
  }
};

// d((n [+] d) [-] n_0)/dd at d = 0, by central differences.
Eigen::Matrix2d DirectionDerivative(const double* n, const double* n_0) {
  constexpr double kStep = 6e-6;
  const UnitDirectionManifold manifold;
  Eigen::Matrix2d D;
  for (int i = 0; i < 2; ++i) {
    Eigen::Vector2d step = Eigen::Vector2d::Zero(), forward, backward;
    Eigen::Vector3d moved;
    step[i] = kStep;
    manifold.Plus(n, step.data(), moved.data());
    manifold.Minus(moved.data(), n_0, forward.data());
    step[i] = -kStep;
    manifold.Plus(n, step.data(), moved.data());
    manifold.Minus(moved.data(), n_0, backward.data());
    D.col(i) = (forward - backward) / (2.0 * kStep);
  }
  return D;
}

// Moves the equations of a prior, in place, to the tangent space at x, d = x [-] at.
void MoveEquations(const WindowValues& x, const WindowPrior& prior, const WindowLayout& by_state,
                   const WindowUnknowns& unknowns, const Eigen::VectorXd& d, Eigen::MatrixXd* H,
                   Eigen::VectorXd* g) {
  const auto apply = [&](int row, const auto& D) {
    constexpr int kSize = std::remove_cvref_t<decltype(D)>::RowsAtCompileTime;
    H->middleCols<kSize>(row) = (H->middleCols<kSize>(row) * D).eval();
    H->middleRows<kSize>(row) = (D.transpose() * H->middleRows<kSize>(row)).eval();
    g->segment<kSize>(row) = (D.transpose() * g->segment<kSize>(row)).eval();
  };
  const auto turn = [&](int row) {
    const Eigen::Vector3d theta = d.segment<3>(row);
    if (!theta.isZero(0.0)) apply(row, so3::RightJacobianInverse(theta));
  };
  for (const int head : by_state.head) {
    turn(head + 3);
    turn(head + 9);
  }
  if (unknowns.T_BC) turn(by_state.T_BC(unknowns) + 3);
  if (!d.segment<2>(by_state.gravity).isZero(0.0)) {
    apply(by_state.gravity, DirectionDerivative(x.gravity.data(), prior.at.gravity.data()));
  }
}

// Rows of equal order in two layouts.
struct RowSegment {
  int from, to, size;
};

std::vector<RowSegment> RowSegmentsOf(const WindowLayout& from, const WindowLayout& to) {
  std::vector<RowSegment> segments;
  for (std::size_t i = 0; i < from.head.size(); ++i) {
    segments.push_back({from.head[i], to.head[i], WindowState::kHead});
    segments.push_back({from.tail[i], to.tail[i], WindowState::kTail});
  }
  segments.push_back({from.gravity, to.gravity, from.size - from.gravity});
  return segments;
}

// Returns g^T H^-1 g of equations that may leave directions open, over the rows that are not zero.
double MinimumOf(const Eigen::MatrixXd& H, const Eigen::VectorXd& g) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    if (H(i, i) > 0.0) rows.push_back(i);
  }
  const Eigen::VectorXd scale = H.diagonal()(rows).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd scaled = scale.asDiagonal() * H(rows, rows) * scale.asDiagonal();
  scaled.diagonal().array() += kDamping;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(scaled);
  if (factors.info() != Eigen::Success) return 0.0;
  return factors.matrixL().solve(scale.cwiseProduct(g(rows))).squaredNorm();
}

// Returns X with X^T X = B^T H^-1 B, without the directions that H leaves open.
Eigen::MatrixXd HalfSolve(const Eigen::MatrixXd& H, const Eigen::MatrixXd& B) {
  const Eigen::VectorXd scale = (H.diagonal().array() + 1e-300).sqrt().inverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factors(scaled);
  if (factors.info() == Eigen::Success &&
      factors.matrixLLT().diagonal().cwiseAbs2().minCoeff() > kOpenDirection) {
    return factors.matrixL().solve(scale.asDiagonal() * B);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  const Eigen::VectorXd root = eigen.eigenvalues().unaryExpr(
      [](double x) { return x > kOpenDirection ? 1.0 / std::sqrt(x) : 0.0; });
  return root.asDiagonal() * (eigen.eigenvectors().transpose() * (scale.asDiagonal() * B).eval());
}

std::string AddFactor(const WindowFactor& factor, const WindowValues& at,
                      const WindowLayout& layout, WindowNormal* normal) {
  LinearFactor linear;
  if (!linear.Evaluate(factor, at, layout)) {
    return std::string("the ") + factor.name + " has no finite value";
  }
  linear.AddTo(normal);
  return "";
}

}  // namespace

void WindowGraph::AddPrior(const WindowValues& at, const WindowLayout& layout,
                           WindowNormal* normal) const {
  WindowLayout by_state;
  by_state.OrderByState(static_cast<int>(prior.at.states.size()), unknowns);
  Eigen::VectorXd d;
  Minus(at, prior.at, by_state, unknowns, &d);
  Eigen::MatrixXd H = prior.H;
  Eigen::VectorXd g = prior.g;
  g.noalias() += H.selfadjointView<Eigen::Lower>() * d;
  normal->cost += d.dot(g + prior.g) + prior.constant;
  MoveEquations(at, prior, by_state, unknowns, d, &H, &g);
  const std::vector<RowSegment> segments = RowSegmentsOf(by_state, layout);
  for (const RowSegment& column : segments) {
    normal->g.segment(column.to, column.size) += g.segment(column.from, column.size);
    for (const RowSegment& row : segments) {
      normal->H.block(row.to, column.to, row.size, column.size) +=
          H.block(row.from, column.from, row.size, column.size);
    }
  }
}

std::string WindowGraph::AddTo(const WindowValues& at, const WindowLayout& layout,
                               WindowNormal* normal) const {
  AddPrior(at, layout, normal);
  for (const std::vector<WindowFactor>& of_state : factors) {
    for (const WindowFactor& factor : of_state) {
      std::string fault = AddFactor(factor, at, layout, normal);
      if (!fault.empty()) return fault;
    }
  }
  return "";
}

std::string WindowGraph::RemoveOldest(WindowNormal* normal) {
  WindowLayout layout;
  layout.OrderByState(states(), unknowns);
  AddPrior(values, layout, normal);
  const auto involves_oldest = [](const WindowFactor& factor) {
    return std::ranges::any_of(factor.variables, [](const WindowFactor::Variable& variable) {
      return variable.kind != FactorKind::kGravityDirection && variable.state == 0;
    });
  };
  for (std::vector<WindowFactor>& of_state : factors) {
    for (const WindowFactor& factor : of_state) {
      if (!involves_oldest(factor)) continue;
      std::string fault = AddFactor(factor, values, layout, normal);
      if (!fault.empty()) return fault;
    }
    std::erase_if(of_state, involves_oldest);
    for (WindowFactor& factor : of_state) {
      for (WindowFactor::Variable& variable : factor.variables) --variable.state;
    }
  }
  constexpr int kState = WindowState::kHead + WindowState::kTail;
  const Eigen::Index rest = layout.size - kState;
  Eigen::MatrixXd B(kState, rest + 1);
  B << normal->H.topRightCorner(kState, rest), normal->g.head(kState);
  const Eigen::MatrixXd X = HalfSolve(normal->H.topLeftCorner(kState, kState), B);
  prior.H = normal->H.bottomRightCorner(rest, rest);
  prior.H.noalias() -= X.leftCols(rest).transpose() * X.leftCols(rest);
  prior.g = normal->g.tail(rest);
  prior.g.noalias() -= X.leftCols(rest).transpose() * X.col(rest);
  prior.constant = MinimumOf(prior.H, prior.g);
  values.states.erase(values.states.begin());
  images.erase(images.begin());
  factors.erase(factors.begin());
  prior.at = values;
  return "";
}

}  // namespace highwall
