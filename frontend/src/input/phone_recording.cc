#include "input/phone_recording.h"

#include <algorithm>

#include <highwall/frontend/input/sensor_profile.h>

namespace highwall {

SensorCalibration PhoneCalibration(const PinholeCamera& camera) {
  SensorCalibration calibration;
  calibration.sensor = FindSensorProfile("iphone")->SensorFor(PinholeCamera());
  calibration.sensor.camera = camera;
  calibration.sensor.depth_factor = 1000.0;
  return calibration;
}

Pose FromArkit(const Pose& T_WC) {
  const Eigen::Quaterniond half_turn_about_x(0.0, 1.0, 0.0, 0.0);
  return T_WC * Pose(half_turn_about_x, Eigen::Vector3d::Zero());
}

PinholeCamera MedianCamera(std::vector<PinholeCamera> cameras) {
  std::ranges::stable_sort(cameras, {}, &PinholeCamera::fx);
  return cameras[cameras.size() / 2];
}

}  // namespace highwall
