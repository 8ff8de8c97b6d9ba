#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/local/camera_calibration.h>

// What highwall calibrate finds out from images alone: intrinsics, and when rows are taken.
namespace highwall::apps {

struct CalibratedImages {
  Trajectory trajectory;                        // all frames, adjusted together
  std::optional<CameraCalibration> intrinsics;  // where asked for
  std::optional<FrameTimingEstimate> timing;    // where images were tracked
};

// Throws what stops the tracking.
CalibratedImages CalibrateImages(const Dataset& dataset, const RgbdSensor& sensor);
// Finds the intrinsics as well. Twice: what is tracked with a wrong camera is tracked worse. The
// sensor gets what the last round finds and sees; the rest stays as it was known before both.
CalibratedImages CalibrateImagesAndIntrinsics(const Dataset& dataset, RgbdSensor* sensor);

// The calibration's times become those that were found to be off; returns their deviations, 0 of
// what stays as it was stated.
FrameTiming TakeTiming(const std::optional<FrameTimingEstimate>& found, FrameTiming* stated);

// What was found, a line each, and as members of a JSON object.
void Print(const CalibratedImages& found);
void AddTo(nlohmann::ordered_json* report, const CalibratedImages& found);

}  // namespace highwall::apps
