#pragma once

#include <string>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/manifold.h>

// Checks the Jacobians of a ceres::CostFunction in the tangent space, where the optimizer uses
// them. Needs no test framework. ceres::GradientChecker is no substitute, since it rejects correct
// factors whose Jacobians have structural zeros.
namespace [[gnu::visibility("default")]] highwall {
namespace testing {

// Options of CheckJacobians().
struct JacobianCheckOptions {
  double step = 1e-6;      // tangent-space step of the central difference, > 0
  double absolute = 1e-7;  // >= 0; a block passes if |J - J_num| <= absolute + relative max|J_num|
  double relative = 1e-6;  // >= 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Result of CheckJacobians().
struct JacobianCheckResult {
  bool ok = false;
  std::string message;  // empty if ok; otherwise the failure, the block, and both matrices
  explicit operator bool() const { return ok; }
};

// Compares J PlusJacobian(x) with central differences along the manifold's Plus, block by block.
// Fails as well where
//   - Evaluate returns false or a residual is not finite,
//   - an entry of a Jacobian is left unwritten or is not finite,
//   - the residuals change when Jacobians are requested,
//   - a block's Jacobian changes when it is the only one that is requested.
//
// blocks[i]: the values of parameter block i (ambient size). manifolds[i]: its manifold, or null
// where the block is Euclidean. Throws InvalidArgument if their number or sizes are not the
// factor's. The factor should be smooth within `step` of the state.
JacobianCheckResult CheckJacobians(const ceres::CostFunction& factor,
                                   const std::vector<std::vector<double>>& blocks,
                                   const std::vector<const ceres::Manifold*>& manifolds,
                                   const JacobianCheckOptions& options = {});

}  // namespace testing
}  // namespace highwall
