#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace highwall {

// What the readings of an IMU are taken for, and the finding if this is right and the configuration
// is not.
struct ImuReading {
  Eigen::Matrix3d gyroscope, accelerometer;  // to C's axes
  Eigen::Vector3d lever_arm;                 // R_CB p_BC [m]
  double lever_sigma = 0.03;                 // [m]
  SensorFault fault = SensorFault::kImuInconsistent;
  std::string text{}, remedy{};
};

// As configured.
ImuReading ConfiguredReading(const Pose& T_BC);
// Other units, signs, an inverted T_BC, a translation in cm or mm.
std::vector<ImuReading> SimpleReadings(const Pose& T_BC);
// Another rotation of T_BC, given as R_CB (orthonormal).
ImuReading TurnedReading(const Pose& T_BC, const Eigen::Matrix3d& R_CB);

}  // namespace highwall
