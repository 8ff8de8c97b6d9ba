#include <highwall/frontend/inertial/options.h>

#include <highwall/frontend/inertial/option_table.h>

namespace highwall {

void ImuWeightingOptions::Validate() const {
  RequireInRange(*this, "ImuWeightingOptions");
}

void InertialInitializerOptions::Validate() const {
  RequireInRange(*this, "InertialInitializerOptions");
}

void VisualNoise::Validate() const {
  RequireInRange(*this, "VisualNoise");
}

void TightWindowOptions::Validate() const {
  RequireInRange(*this, "TightWindowOptions");
}

void InertialOptions::Validate() const {
  RequireInRange(*this, "InertialOptions");
}

const char* ToString(InertialCoupling coupling) {
  return coupling == InertialCoupling::kTight ? "tight" : "loose";
}

const char* ToString(ImuWeighting policy) {
  switch (policy) {
    case ImuWeighting::kPaper:
      return "paper";
    case ImuWeighting::kConsistent:
      return "consistent";
    case ImuWeighting::kFixed:
      return "fixed";
  }
  return "unknown";
}

}  // namespace highwall
