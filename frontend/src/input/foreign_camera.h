#pragma once

#include <functional>
#include <span>
#include <string>

#include <opencv2/core/types.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/input/sensor.h>

#include "input/foreign_map.h"

// What the readers of calibrations of other systems share. Each function throws IoError with the
// line of the key.
namespace highwall {

// Returns the size of the images that a calibration is for. Throws IoError if it is not known.
using ImageSizeSource = std::function<cv::Size()>;

// Returns a calibration that states nothing yet but its format: depth is in millimetres, as most
// programs store it, and all keys are SensorCalibration::defaults.
SensorCalibration StartForeignCalibration(const std::string& format);
// Removes a key from SensorCalibration::defaults.
void MarkStated(const std::string& key, SensorCalibration* calibration);

// Returns the camera of a matrix under a key, which has these nine numbers, without its lens.
PinholeCamera ForeignMatrixCamera(const ForeignMap& file, const std::string& key,
                                  std::span<const double> numbers, const std::string& width_key,
                                  const std::string& height_key);
// Returns the camera of the lists "intrinsics" (fx, fy, cx, cy) and "resolution" (width, height),
// without its lens.
PinholeCamera ForeignListCamera(const ForeignMap& file);
// As SetLens(). model_key: states the model; it may be absent. Throws for a model, a number of
// coefficients or a coefficient that PinholeCamera does not have.
void SetForeignLens(const ForeignMap& file, const std::string& model_key, const std::string& model,
                    const std::string& key, std::span<const double> coefficients,
                    PinholeCamera* camera);
// Throws unless the camera is one, with the line of this key.
void CheckForeignCamera(const ForeignMap& file, const std::string& key,
                        const PinholeCamera& camera);

// Reads a positive depth factor under a key.
void ReadForeignDepthFactor(const ForeignMap& file, const std::string& key,
                            SensorCalibration* calibration);
// Returns the pose of 16 numbers, row by row, which the file has under this key.
Pose ForeignPose(const ForeignMap& file, const std::string& key, std::span<const double> numbers);
// Adds the IMU, whose noise is not stated yet.
ImuCalibration& AddForeignImu(const Pose& T_BC, SensorCalibration* calibration);
// Throws unless the IMU is one, with the line of this key.
void CheckForeignImu(const ForeignMap& file, const std::string& key, const ImuCalibration& imu);

}  // namespace highwall
