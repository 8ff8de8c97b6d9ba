#pragma once

#include <vector>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/input/sensor.h>

#include "input/frame_list_dataset.h"

// What the recordings of Apple's phones and tablets have in common.
namespace highwall {

// ARKit's confidence in a reading: low (0), medium (1), high (2). Readings of low confidence are
// off by several per cent of their depth, by a bias rather than by noise: they are holes.
inline constexpr int kLowConfidence = 0, kMediumConfidence = 1;
// Noise of readings of medium confidence over that of those of high confidence, as two recordings
// show it from frame to frame (docs/lab/2026-11-any-recording.md).
inline constexpr float kMediumConfidenceNoise = 2.0F;

// Returns the calibration of a phone with this colour camera, which may be of unknown size (0 x 0):
// the depth of its LiDAR is in millimetres.
SensorCalibration PhoneCalibration(const PinholeCamera& camera);

// Returns T_WC with z forward and y down from ARKit's, whose z is backward and whose y is up.
Pose FromArkit(const Pose& T_WC);

// Returns the camera with the median focal length: that of the recording. cameras: not empty.
PinholeCamera MedianCamera(std::vector<PinholeCamera> cameras);

}  // namespace highwall
