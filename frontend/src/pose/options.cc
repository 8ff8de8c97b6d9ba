#include <highwall/frontend/pose/options.h>

#include <highwall/frontend/pose/option_table.h>

namespace highwall {

void PoseSolverOptions::Validate() const {
  RequireInRange(*this, "PoseSolverOptions");
}

void DegeneracyOptions::Validate() const {
  RequireInRange(*this, "DegeneracyOptions");
}

}  // namespace highwall
