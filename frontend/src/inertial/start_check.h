#pragma once

#include <optional>

#include <highwall/frontend/input/sensor_verdict.h>

#include "inertial/inertial_initializer.h"

namespace highwall {

// Tests whether one solution of the initial state after the other is contradicted: an IMU that is
// never used because of that is a finding long before it is given up.
class StartCheck {
 public:
  // solution: the latest one. is_contradicted: its error is that of readings, not of poor images.
  // Returns a finding once.
  std::optional<SensorFinding> Update(const InitializationReport& solution, bool is_contradicted);

 private:
  int in_a_row_ = 0;
  bool is_reported_ = false;
};

}  // namespace highwall
