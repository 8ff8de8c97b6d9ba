#include <highwall/frontend/system/options.h>

namespace highwall {

void SlamOptions::Validate() const {
  frame.Validate();
  measurement.Validate();
  tracker.Validate();
  keyframes.Validate();
  mapper.Validate();
  inertial.Validate();
  loops.Validate();
}

SlamOptions Deterministic(SlamOptions options) {
  options.frame.parallel = false;
  options.mapper.background = options.loops.background = false;
  // A sum that several threads form may round differently from run to run.
  options.mapper.bundle.threads = 1;
  options.loops.correction.threads = options.loops.bundle.threads = 1;
  return options;
}

}  // namespace highwall
