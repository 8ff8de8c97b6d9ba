#pragma once

#include <highwall/factors/adaptive_imu_weight.h>
#include <highwall/frontend/inertial/options.h>

namespace highwall {

// What an interval between two images tells the policies.
struct ImuWeightInput {
  MotionMeasures motion;
  double squared_innovation = 0.0;  // of the image's pose against the IMU's prediction
  int dof = 0;                      // of it; 0: no image, or one that leaves a direction open
};

// One of the policies, by its name.
class ImuWeight {
 public:
  // Throws InvalidArgument on bad options.
  explicit ImuWeight(const ImuWeightingOptions& options);

  // Once an interval: the weight of its IMU factor.
  double Update(const ImuWeightInput& input);
  double weight() const { return weight_; }

 private:
  ImuWeightingOptions options_;
  PaperImuWeight paper_;
  ConsistentImuWeight consistent_;
  double weight_;
};

}  // namespace highwall
