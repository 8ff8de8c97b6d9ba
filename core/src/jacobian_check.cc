#include <highwall/core/testing/jacobian_check.h>

#include <cmath>
#include <limits>

#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall::testing {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Blocks = std::vector<std::vector<double>>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Repeated evaluations of one state may differ by rounding in another order of operations.
constexpr double kRepeatTolerance = 1e-12;

bool Same(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const double scale = 1.0 + b.cwiseAbs().maxCoeff();
  return ((a - b).cwiseAbs().array() <= kRepeatTolerance * scale).all();  // false for NaN
}

std::vector<const double*> Pointers(const Blocks& blocks) {
  std::vector<const double*> pointers;
  for (const std::vector<double>& block : blocks) pointers.push_back(block.data());
  return pointers;
}

// One evaluation; every output is initialized with NaN to detect entries that are not written.
struct Evaluation {
  bool valid = false;
  Eigen::VectorXd residuals;
  std::vector<RowMajorMatrix> jacobians;  // ambient; empty where not requested
};

// requested[i]: whether the Jacobian of block i is requested; empty: pass no Jacobians at all.
Evaluation Evaluate(const ceres::CostFunction& factor, const Blocks& blocks,
                    const std::vector<bool>& requested) {
  Evaluation e;
  e.residuals = Eigen::VectorXd::Constant(factor.num_residuals(), kNaN);
  e.jacobians.resize(blocks.size());
  std::vector<double*> pointers(blocks.size(), nullptr);
  for (std::size_t i = 0; i < requested.size(); ++i) {
    if (!requested[i]) continue;
    const auto columns = static_cast<Eigen::Index>(blocks[i].size());
    e.jacobians[i] = RowMajorMatrix::Constant(factor.num_residuals(), columns, kNaN);
    pointers[i] = e.jacobians[i].data();
  }
  e.valid = factor.Evaluate(Pointers(blocks).data(), e.residuals.data(),
                            requested.empty() ? nullptr : pointers.data());
  return e;
}

int TangentSize(const std::vector<double>& block, const ceres::Manifold* manifold) {
  return manifold != nullptr ? manifold->TangentSize() : static_cast<int>(block.size());
}

// Moves x by `distance` along tangent direction k; returns false if the manifold does.
bool Step(const std::vector<double>& x, const ceres::Manifold* manifold, int k, double distance,
          std::vector<double>* moved) {
  std::vector<double> delta(static_cast<std::size_t>(TangentSize(x, manifold)), 0.0);
  delta[static_cast<std::size_t>(k)] = distance;
  *moved = x;
  if (manifold != nullptr) return manifold->Plus(x.data(), delta.data(), moved->data());
  for (std::size_t i = 0; i < x.size(); ++i) (*moved)[i] += delta[i];
  return true;
}

// num_residuals x tangent size; columns stay NaN if a step could not be evaluated.
Eigen::MatrixXd NumericJacobian(const ceres::CostFunction& factor, Blocks blocks, std::size_t i,
                                const ceres::Manifold* manifold, double step) {
  const std::vector<double> x = blocks[i];
  const int size = TangentSize(x, manifold);
  Eigen::MatrixXd J = Eigen::MatrixXd::Constant(factor.num_residuals(), size, kNaN);
  for (int k = 0; k < size; ++k) {
    if (!Step(x, manifold, k, step, &blocks[i])) continue;
    const Evaluation ahead = Evaluate(factor, blocks, {});
    if (!Step(x, manifold, k, -step, &blocks[i])) continue;
    const Evaluation behind = Evaluate(factor, blocks, {});
    if (!ahead.valid || !behind.valid) continue;
    J.col(k) = (ahead.residuals - behind.residuals) / (2.0 * step);
  }
  return J;
}

Eigen::MatrixXd ToTangent(const RowMajorMatrix& ambient, const std::vector<double>& x,
                          const ceres::Manifold* manifold) {
  if (manifold == nullptr) return ambient;
  RowMajorMatrix plus(manifold->AmbientSize(), manifold->TangentSize());
  if (!manifold->PlusJacobian(x.data(), plus.data())) plus.setConstant(kNaN);
  return ambient * plus;
}

JacobianCheckResult Failure(const std::string& message) {
  return {false, message};
}

JacobianCheckResult Failure(const std::string& message, const Eigen::MatrixXd& actual,
                            const std::string& expected_name, const Eigen::MatrixXd& expected) {
  TextWriter text;
  text << message << "\nJacobian:\n" << actual << "\n" << expected_name << ":\n" << expected;
  return Failure(text.str());
}

void RequireMatchingBlocks(const ceres::CostFunction& factor, const Blocks& blocks,
                           const std::vector<const ceres::Manifold*>& manifolds) {
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  HIGHWALL_REQUIRE(blocks.size() == sizes.size(),
                   "CheckJacobians: the factor has " + std::to_string(sizes.size()) +
                       " blocks, given " + std::to_string(blocks.size()));
  HIGHWALL_REQUIRE(manifolds.size() == sizes.size(),
                   "CheckJacobians: the factor has " + std::to_string(sizes.size()) +
                       " blocks, given manifolds: " + std::to_string(manifolds.size()));
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const std::string name = "CheckJacobians: block " + std::to_string(i);
    HIGHWALL_REQUIRE(static_cast<int>(blocks[i].size()) == sizes[i],
                     name + " has size " + std::to_string(sizes[i]) + ", given " +
                         std::to_string(blocks[i].size()));
    HIGHWALL_REQUIRE(manifolds[i] == nullptr || manifolds[i]->AmbientSize() == sizes[i],
                     name + " has size " + std::to_string(sizes[i]) + ", not its manifold's");
  }
}

}  // namespace

void JacobianCheckOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(step) && step > 0.0,
                   "JacobianCheckOptions::step must be positive");
  HIGHWALL_REQUIRE(absolute >= 0.0, "JacobianCheckOptions::absolute must not be negative");
  HIGHWALL_REQUIRE(relative >= 0.0, "JacobianCheckOptions::relative must not be negative");
}

JacobianCheckResult CheckJacobians(const ceres::CostFunction& factor,
                                   const std::vector<std::vector<double>>& blocks,
                                   const std::vector<const ceres::Manifold*>& manifolds,
                                   const JacobianCheckOptions& options) {
  options.Validate();
  RequireMatchingBlocks(factor, blocks, manifolds);

  const Evaluation plain = Evaluate(factor, blocks, {});
  const Evaluation full = Evaluate(factor, blocks, std::vector<bool>(blocks.size(), true));
  if (!plain.valid || !full.valid) return Failure("Evaluate returned false");
  if (!plain.residuals.allFinite()) return Failure("a residual is not finite or not written");
  if (!Same(full.residuals, plain.residuals)) {
    return Failure("the residuals change when Jacobians are requested");
  }

  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const std::string name = "block " + std::to_string(i);
    if (!full.jacobians[i].allFinite()) {
      TextWriter text;
      text << name << ": an entry is not written or not finite\n" << full.jacobians[i];
      return Failure(text.str());
    }
    std::vector<bool> alone(blocks.size(), false);
    alone[i] = true;
    const Evaluation single = Evaluate(factor, blocks, alone);
    if (!single.valid || !Same(single.residuals, plain.residuals) ||
        !Same(single.jacobians[i], full.jacobians[i])) {
      return Failure(name + ": differs when it is requested alone", single.jacobians[i],
                     "requested with the others", full.jacobians[i]);
    }
    const Eigen::MatrixXd J = ToTangent(full.jacobians[i], blocks[i], manifolds[i]);
    const Eigen::MatrixXd J_num = NumericJacobian(factor, blocks, i, manifolds[i], options.step);
    const double tolerance = options.absolute + options.relative * J_num.cwiseAbs().maxCoeff();
    if (!((J - J_num).cwiseAbs().array() <= tolerance).all()) {  // true for NaN
      return Failure(name + ": differs from central differences in the tangent space", J,
                     "central differences", J_num);
    }
  }
  return {true, ""};
}

}  // namespace highwall::testing
