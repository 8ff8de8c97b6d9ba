#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/local/camera_calibration.h>

#include "calibration_file.h"
#include "opened_dataset.h"

// What highwall calibrate finds out from images alone.
namespace highwall::apps {

struct ImageCalibrationOptions {
  bool intrinsics = false;                          // to be found as well
  bool keep_depth = false;                          // depth is right as it is stated
  double max_pair_difference = kMaxPairDifference;  // [s] as OpenImages()
};

struct CalibratedImages {
  Trajectory trajectory;       // all frames, adjusted together
  CameraCalibration camera;    // offset and pattern of depth in all, what was stated included
  FrameTimingEstimate timing;  // of the rows
  int rounds = 0;              // that tracked them
};

// Tracks a dataset with what is stated of its sensor, and once more where that was wrong: what is
// tracked with a wrong camera is tracked worse. A map that was made with wrong times of its rows
// holds on to them: it is made anew, six times at most, until they settle. The sensor gets the
// intrinsics that the last round finds and sees, the offset of depth and its pattern where they are
// seen and off beyond doubt; the rest stays as it was stated. Throws IoError as the dataset, and
// where too little can be tracked.
CalibratedImages CalibrateImages(const std::filesystem::path& dataset,
                                 const ImageCalibrationOptions& options, RgbdSensor* sensor);

// The stated times of the rows become those that were found to be off. Returns the deviations of
// what the sensor has from `found` now, 0 of what stays as it was stated.
CalibrationSigma TakeFound(const CalibratedImages& found, RgbdSensor* sensor);

// What was found, a line each, and as members of a JSON object.
void Print(const CalibratedImages& found, const ImageCalibrationOptions& options);
void AddTo(nlohmann::ordered_json* report, const CalibratedImages& found,
           const ImageCalibrationOptions& options);

}  // namespace highwall::apps
