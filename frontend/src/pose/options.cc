#include <highwall/frontend/pose/options.h>

#include <highwall/frontend/pose/option_table.h>

namespace highwall {

void PoseSolverOptions::Validate() const {
  RequireInRange(*this, "PoseSolverOptions");
}

void DegeneracyOptions::Validate() const {
  RequireInRange(*this, "DegeneracyOptions");
}

void SurfaceMatcherOptions::Validate() const {
  RequireInRange(*this, "SurfaceMatcherOptions");
}

void DirectAlignmentOptions::Validate() const {
  RequireInRange(*this, "DirectAlignmentOptions");
}

void LandmarkMotionOptions::Validate() const {
  RequireInRange(*this, "LandmarkMotionOptions");
}

}  // namespace highwall
