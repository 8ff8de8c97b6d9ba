#pragma once

#include <functional>
#include <string>
#include <vector>

#include <highwall/frontend/input/sensor_verdict.h>

#include "stated_recording.h"

namespace highwall::bench {

// A way to state a recording wrongly, at one strength.
struct Misuse {
  std::string fault;                  // "depth factor"; the same for all strengths
  std::string strength;               // "x 5"; empty if there is only one
  std::vector<SensorFault> expected;  // the names that a finding may rightly have
  bool inertial = false;              // concerns the IMU: compared with the run without it
  std::function<void(StatedRecording*)> apply;
};

// Returns "depth factor x 5".
std::string NameOf(const Misuse& misuse);

// Misuses of each kind.
std::vector<Misuse> DepthMisuses();
std::vector<Misuse> LensMisuses();
std::vector<Misuse> ImuMisuses();
std::vector<Misuse> StampMisuses();
// Returns all of them.
std::vector<Misuse> AllMisuses();
// Returns the faults of all of them, each once.
std::vector<std::string> AllFaults();

// Recordings whose configuration is as right as sensors are: nothing must be found in them. Those
// of the first kind are of the images as they are.
std::vector<Misuse> RightRecordings();

}  // namespace highwall::bench
