#pragma once

namespace [[gnu::visibility("default")]] highwall {

// Base of a factor whose rows are silent outside of its domain: r = 0 and J = 0 in them, and
// Evaluate is true, as where a point lies behind the camera. So that silence does not pass for a
// perfect fit, FactorGraph::Solve() counts a row that falls silent on the way by one more than its
// residual r was before, with J = 0. A step that leads many of them out of their domain raises the
// cost and is rejected; one that leads a single bad observation there is not held up by it.
// LinearSolver::kVariableProjection shortens the step of such a landmark.
//
// Not for a factor whose silence is its meaning, such as a bound that is kept.
class SilentOutsideDomain {
 protected:
  SilentOutsideDomain() = default;
  ~SilentOutsideDomain() = default;
};

}  // namespace highwall
