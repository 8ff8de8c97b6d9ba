#pragma once

namespace [[gnu::visibility("default")]] highwall {

// Base of a factor whose rows are zero outside of its domain: r = 0 and J = 0, and Evaluate returns
// true, for example where a point lies behind the camera. To prevent such a row from counting as a
// perfect fit, FactorGraph::Solve() assigns a row that leaves its domain during the solve its last
// residual inside the domain, increased in magnitude by one, with J = 0. A step that moves many of
// them out of their domain increases the cost and is rejected; a single bad observation that leaves
// does not block the step. LinearSolver::kCompactSchur and
// kVariableProjection shorten the step of such a landmark.
//
// Not for a factor whose zero residual is meaningful, such as a bound that is satisfied.
class SilentOutsideDomain {
 protected:
  SilentOutsideDomain() = default;
  ~SilentOutsideDomain() = default;
};

}  // namespace highwall
