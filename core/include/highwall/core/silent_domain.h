#pragma once

namespace [[gnu::visibility("default")]] highwall {

// Base of a factor whose rows are silent outside of its domain: r = 0 and J = 0 in them, and
// Evaluate is true, as where a point lies behind the camera. So that silence does not pass for a
// perfect fit, FactorGraph::Solve() takes no step that silences a row which was not silent when the
// solve began: it counts as one where the factor cannot be evaluated.
//
// Not for a factor whose silence is its meaning, such as a bound that is kept.
class SilentOutsideDomain {
 protected:
  SilentOutsideDomain() = default;
  ~SilentOutsideDomain() = default;
};

}  // namespace highwall
