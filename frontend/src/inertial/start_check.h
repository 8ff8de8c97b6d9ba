#pragma once

#include <optional>

#include <highwall/frontend/input/sensor_verdict.h>

#include "inertial/inertial_initializer.h"
#include "sensor/imu_hypotheses.h"

namespace highwall {

// Tests whether one solution of the initial state after the other is contradicted: an IMU that is
// never used because of that is a finding long before it is given up.
class StartCheck {
 public:
  // solution: the latest one. wrong_readings: the readings alone are not of gravity's norm.
  // agreement: as the configuration was judged last; one that is confirmed is contradicted by poor
  // poses at most. Returns a finding once.
  std::optional<SensorFinding> Update(const InitializationReport& solution, bool wrong_readings,
                                      ImuAgreement agreement);

 private:
  int in_a_row_ = 0;
  bool is_reported_ = false;
};

}  // namespace highwall
