#include <highwall/frontend/system/slam_system.h>

#include <highwall/internal/require.h>

namespace highwall {

void SubmapOptions::Validate() const {
  RequireNotNegative(patience, "SubmapOptions::patience");
}

void SlamOptions::Validate() const {
  frame.Validate();
  measurement.Validate();
  tracker.Validate();
  keyframes.Validate();
  mapper.Validate();
  inertial.Validate();
  loops.Validate();
  factors.Validate();
  submaps.Validate();
}

SlamOptions Deterministic(SlamOptions options) {
  options.frame.parallel = false;
  options.mapper.background = options.loops.background = options.factors.background = false;
  // A sum that several threads form may round differently from run to run.
  options.mapper.bundle.threads = 1;
  options.loops.correction.threads = options.loops.bundle.threads = options.factors.threads = 1;
  return options;
}

}  // namespace highwall
