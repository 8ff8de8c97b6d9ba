#include <highwall/core/marginalization.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <ceres/manifold.h>

#include <highwall/core/error.h>

namespace highwall {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// About the cube root of the rounding unit: optimal for central differences.
constexpr double kStep = 6e-6;

int TangentSizeOf(const MarginalPrior::Block& block) {
  return block.manifold != nullptr ? block.manifold->TangentSize()
                                   : static_cast<int>(block.linearization_point.size());
}

// d((x [+] d) [-] x0)/dd at d = 0. A manifold provides no formula for it away from x = x0.
bool MinusDerivative(const MarginalPrior::Block& block, const double* x, Eigen::MatrixXd* D) {
  const std::vector<double>& x_0 = block.linearization_point;
  const Eigen::Index n = TangentSizeOf(block);
  D->setIdentity(n, n);
  if (std::equal(x_0.begin(), x_0.end(), x)) return true;
  std::vector<double> moved(x_0.size());
  Eigen::VectorXd step = Eigen::VectorXd::Zero(n), forward(n), backward(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    step[i] = kStep;
    if (!block.manifold->Plus(x, step.data(), moved.data())) return false;
    if (!block.manifold->Minus(moved.data(), x_0.data(), forward.data())) return false;
    step[i] = -kStep;
    if (!block.manifold->Plus(x, step.data(), moved.data())) return false;
    if (!block.manifold->Minus(moved.data(), x_0.data(), backward.data())) return false;
    step[i] = 0.0;
    D->col(i) = (forward - backward) / (2.0 * kStep);
  }
  return true;
}

}  // namespace

MarginalPrior::MarginalPrior(std::vector<Block> blocks, const Eigen::MatrixXd& A,
                             const Eigen::VectorXd& b)
    : blocks_(std::move(blocks)), A_(A), b_(b), columns_{0} {
  HIGHWALL_REQUIRE(A.rows() > 0 && A.rows() == b.size(),
                   "MarginalPrior: A and b must have the same number of rows, at least 1");
  HIGHWALL_REQUIRE(A.allFinite() && b.allFinite(), "MarginalPrior: A and b must be finite");
  for (const Block& block : blocks_) {
    const std::vector<double>& x_0 = block.linearization_point;
    HIGHWALL_REQUIRE(std::all_of(x_0.begin(), x_0.end(), [](double x) { return std::isfinite(x); }),
                     "MarginalPrior: the linearization points must be finite");
    const auto size = static_cast<int>(x_0.size());
    HIGHWALL_REQUIRE(
        size > 0 && (block.manifold == nullptr || block.manifold->AmbientSize() == size),
        "MarginalPrior: a linearization point does not fit its manifold");
    mutable_parameter_block_sizes()->push_back(size);
    columns_.push_back(columns_.back() + TangentSizeOf(block));
  }
  HIGHWALL_REQUIRE(
      columns_.back() == A.cols(),
      "MarginalPrior: A must have as many columns as the blocks have tangent dimensions");
  set_num_residuals(static_cast<int>(A.rows()));
}

bool MarginalPrior::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  Eigen::VectorXd difference(A_.cols());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    double* out = difference.data() + Column(i);
    if (block.manifold != nullptr) {
      const double* x_0 = block.linearization_point.data();
      if (!block.manifold->Minus(parameters[i], x_0, out)) return false;
    } else {
      for (Eigen::Index k = 0; k < TangentSize(i); ++k) {
        out[k] = parameters[i][k] - block.linearization_point[static_cast<std::size_t>(k)];
      }
    }
  }
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = A_ * difference + b_;  // Eq. 7
  if (jacobians == nullptr) return true;

  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (jacobians[i] == nullptr) continue;
    const Block& block = blocks_[i];
    Eigen::Map<RowMajor> J(jacobians[i], num_residuals(), parameter_block_sizes()[i]);
    const auto A_i = A_.middleCols(Column(i), TangentSize(i));
    if (block.manifold == nullptr) {
      J = A_i;
      continue;
    }
    Eigen::MatrixXd D;
    RowMajor lift(TangentSize(i), parameter_block_sizes()[i]);
    if (!MinusDerivative(block, parameters[i], &D)) return false;
    if (!block.manifold->MinusJacobian(parameters[i], lift.data())) return false;
    J.noalias() = A_i * (D * lift);  // Eq. 8
  }
  return true;
}

}  // namespace highwall
