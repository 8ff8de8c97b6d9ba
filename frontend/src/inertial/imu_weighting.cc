#include <highwall/frontend/inertial/imu_weighting.h>

#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

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

void ImuWeightingOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(fixed_weight) && fixed_weight > 0.0,
                   "ImuWeightingOptions::fixed_weight must be positive");
  paper.Validate();
  consistent.Validate();
}

ImuWeight::ImuWeight(const ImuWeightingOptions& options)
    : options_((options.Validate(), options)),
      paper_(options.paper),
      consistent_(options.consistent),
      weight_(options.policy == ImuWeighting::kFixed ? options.fixed_weight : 1.0) {}

double ImuWeight::Update(const ImuWeightInput& input) {
  switch (options_.policy) {
    case ImuWeighting::kPaper:
      weight_ = paper_.Update(input.motion);
      break;
    case ImuWeighting::kConsistent:
      if (input.dof > 0) weight_ = consistent_.Update(input.squared_innovation, input.dof);
      break;
    case ImuWeighting::kFixed:
      break;
  }
  return weight_;
}

}  // namespace highwall
