#pragma once

#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// An IMU that is fixed to a camera.
struct ImuCalibration {
  Pose T_BC;                 // the camera in the body frame, whose axes are those of the IMU
  ImuNoise noise{};          // of the readings
  double rate = 200.0;       // [Hz] > 0; nominal
  double time_offset = 0.0;  // [s] in [-1, 1]; a first guess of t_d: t_imu = t_cam + t_d

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
