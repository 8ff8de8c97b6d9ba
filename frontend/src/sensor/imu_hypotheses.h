#pragma once

#include <optional>
#include <span>
#include <string>

#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace highwall {

// What images and readings say of the configuration of the IMU.
enum class ImuAgreement {
  kUndecided,     // too little motion, or too few images
  kConsistent,    // the images turn as the gyroscope says
  kUnconfirmed,   // the images turn much, and neither the configuration nor another reading of the
                  // gyroscope explains it: the poses of the images may be as wrong as the IMU
  kContradicted,  // another reading of the IMU explains the images, the configuration does not
};

struct ImuJudgement {
  ImuAgreement agreement = ImuAgreement::kUndecided;
  // In kContradicted and kUnconfirmed: the reading that explains the images, if only one does or
  // the motion has been long enough, else kImuInconsistent.
  std::optional<SensorFinding> finding{};
  bool is_named = false;  // the finding is a single reading, and no other explains the images
};

// Judges the configuration by the poses T_WC of the camera over some seconds and the readings
// around them, both in the order of their stamps. max_step [s]: InertialOptions::buffer.
// docs/misconfiguration.md, IMU
ImuJudgement JudgeImu(const Trajectory& poses, std::span<const ImuSample> readings,
                      const ImuCalibration& calibration, double max_step = 0.1);

// Returns the finding that the stamps of the IMU are ahead of those of the images by `offset`
// instead of `stated` [s].
SensorFinding ClockFinding(double offset, double stated);

}  // namespace highwall
