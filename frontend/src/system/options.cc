#include <highwall/frontend/system/slam_system.h>

#include <highwall/frontend/system/option_table.h>

namespace highwall {

void SubmapOptions::Validate() const {
  RequireInRange(*this, "SubmapOptions");
}

void SlamOptions::Validate() const {
  RequireInRange(*this, "SlamOptions");
}

SlamOptions Deterministic(SlamOptions options) {
  options.frame.parallel = false;
  options.mapper.background = options.loops.background = options.factors.background = false;
  options.depth_pattern.background = options.refinement.background = false;
  options.inertial.tight.background = false;
  // A sum that several threads form may round differently from run to run.
  options.mapper.bundle.threads = 1;
  options.loops.correction.threads = options.loops.bundle.threads = options.factors.threads = 1;
  return options;
}

}  // namespace highwall
