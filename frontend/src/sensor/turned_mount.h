#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "sensor/imu_alignment.h"

namespace highwall {

// A rotation of an IMU's axes to the camera's that fits the images better than the stated one.
struct TurnedMount {
  Eigen::Matrix3d R_CB = Eigen::Matrix3d::Identity();
  std::size_t fit = 0;  // the index of the fit in which it is best
  // Decrease of the squared residuals against the best rotation within 3 degrees of the stated one,
  // in variances.
  double gain = 0.0;
};

// Returns the rotation that fits the gyroscope best if it is more than 6 degrees from the stated
// one (orthonormal, to C's axes); empty otherwise, and if there are too few rotations. fits: of the
// same images, at least one, one for each offset of the clocks that is tolerated. Axes about which
// the camera does not turn stay as stated.
std::optional<TurnedMount> FindTurnedMount(std::span<const GyroscopeFit> fits,
                                           const Eigen::Matrix3d& R_CB);

}  // namespace highwall
