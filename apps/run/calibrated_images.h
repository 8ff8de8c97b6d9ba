#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/calibration/camera_calibration.h>
#include <highwall/frontend/input/sensor.h>

#include "run/calibration_file.h"
#include "run/opened_dataset.h"

// Calibration from images alone, for highwall calibrate.
namespace highwall::apps {

struct ImageCalibrationOptions {
  bool intrinsics = false;  // whether to estimate them
  bool keep_depth = false;  // keep the stated depth calibration
  DatasetOptions images{};  // as in OpenWithConfig()
};

struct CalibratedImages {
  Trajectory trajectory;       // all frames, jointly adjusted
  CameraCalibration camera;    // total depth offset and distortion, including the stated values
  FrameTimingEstimate timing;  // rolling shutter
  int rounds = 0;              // number of tracking passes
};

// Tracks a dataset with the stated calibration of its sensor, and again if the estimate differs,
// because a wrong camera degrades tracking. A map built with wrong rolling-shutter times is biased
// towards them, so it is rebuilt, at most six times, until they converge. The sensor receives the
// observable intrinsics of the last round, and the depth offset and distortion where they are
// observable and significantly different; everything else stays as stated. Throws IoError as the
// dataset does, and if too little can be tracked.
CalibratedImages CalibrateImages(const std::filesystem::path& dataset,
                                 const ImageCalibrationOptions& options, RgbdSensor* sensor);

// Replaces the stated rolling-shutter times that differ significantly from the estimates. Returns
// the standard deviations of the values that `sensor` takes from `found`; 0 for stated values.
CalibrationSigma TakeFound(const CalibratedImages& found, RgbdSensor* sensor);

// Print the estimates, one per line, or add them as members to a JSON object.
void Print(const CalibratedImages& found, const ImageCalibrationOptions& options);
void AddTo(nlohmann::ordered_json* report, const CalibratedImages& found,
           const ImageCalibrationOptions& options);

}  // namespace highwall::apps
