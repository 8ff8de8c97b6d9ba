#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace [[gnu::visibility("default")]] highwall {

struct CameraCalibrationOptions {
  double focal_share = 0.1;   // > 0: standard deviation before, of the focal lengths, and
  double centre_share = 0.1;  // > 0: of the principal point, of the image's width and height
  double huber = 2.5;         // > 0: of an observation's error
  double good_share = 0.002;  // > 0: of a focal length; beyond it a number had better be seen
  int max_iterations = 50;    // >= 1

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A camera's focal lengths and principal point as a map tells them.
struct CameraCalibration {
  Eigen::Vector4d intrinsics;  // fx fy cx cy [px]
  Eigen::Vector4d sigma;       // [px]
  double error = 0.0;          // chi-squared per degree of freedom; beyond 1 sigma grows with it
  int keyframes = 0, points = 0, observations = 0;
  std::array<bool, 4> seen{};  // sigma is within good_share of a focal length
  // What the motion did not tell well, and which motion would; in words, a line each.
  std::vector<std::string> advice;
};

// Adjusts all keyframes and points of a submap, with all that is joined with it, together with the
// intrinsics of the camera that it was made with; the map stays as it is. Points without depth that
// were seen without parallax are left out. Pixels are undistorted with the distortion that was
// known. Throws InvalidArgument, saying so, on bad options, where the map has less than three
// keyframes or no such point that two of them see, and where the solver fails.
//                                                                docs/calibration.md, Intrinsics
CameraCalibration CalibrateCamera(const Map& map, const MeasurementModel& model,
                                  SubmapId submap = kFirstSubmap,
                                  const CameraCalibrationOptions& options = {});

}  // namespace highwall
