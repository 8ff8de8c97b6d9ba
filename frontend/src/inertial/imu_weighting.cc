#include "inertial/imu_weighting.h"

#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

ImuWeight::ImuWeight(const ImuWeightingOptions& options)
    : options_((options.Validate(), options)),
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
