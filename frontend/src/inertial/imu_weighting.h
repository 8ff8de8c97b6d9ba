#pragma once

#include <highwall/factors/adaptive_imu_weight.h>
#include <highwall/frontend/inertial/options.h>

namespace highwall {

// Input of the weighting policies from an interval between two images.
struct ImuWeightInput {
  MotionMeasures motion;
  double squared_innovation = 0.0;  // of the image's pose against the IMU's prediction
  int dof = 0;                      // of it; 0: no image, or one with an unobservable direction
};

// Weight of IMU factors by the selected policy.
class ImuWeight {
 public:
  // Throws InvalidArgument on bad options.
  explicit ImuWeight(const ImuWeightingOptions& options);

  // Returns the weight of the IMU factor of an interval; to be called once per interval.
  double Update(const ImuWeightInput& input);
  double weight() const { return weight_; }

 private:
  ImuWeightingOptions options_;
  PaperImuWeight paper_;
  ConsistentImuWeight consistent_;
  double weight_;
};

}  // namespace highwall
