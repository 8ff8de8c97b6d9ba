#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <highwall/frontend/input/sensor_verdict.h>

#include "misuses.h"
#include "stated_recording.h"

namespace highwall::bench {

// What a user learns from a run, and its figures.
struct Trial {
  std::string refusal;  // the error that ended the run; empty if it came to its end
  SensorVerdict verdict;
  std::optional<double> ape;  // [m] RMSE of the largest world; empty with too few poses
  double posed = 0.0;         // share of the frames with a pose in it
  double keyframes = 0.0;     // made, per frame
  double processor_ms = 0.0;  // per frame
};

// Runs a recording as it is stated in the way of `highwall slam --deterministic --no-map`, with all
// that it examines before the first frame.
Trial RunStated(const StatedSequence& sequence);

// Returns the recording with the wrong statement. Without the IMU unless the misuse concerns it.
StatedSequence Misstate(const TrueRecording& recording, const Misuse& misuse);

// Whether anything is reported to the user.
bool IsDetected(const Trial& trial);
// Whether a finding has one of the names. An error that ends the run is as good a name for stamps.
bool IsNamed(const Trial& trial, const std::vector<SensorFault>& expected);

}  // namespace highwall::bench
