#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace [[gnu::visibility("default")]] highwall {

struct CameraCalibrationOptions {
  bool intrinsics = true;  // false: they are known
  // The camera with its distortion, over whose image the pattern of depth is looked for; empty: it
  // is known.
  std::optional<PinholeCamera> pattern_of{};
  double focal_share = 0.1;     // > 0: standard deviation before, of the focal lengths, and
  double centre_share = 0.1;    // > 0: of the principal point, of the image's width and height
  double inverse_depth = 0.02;  // [1/m] > 0: and of the offset of depth
  double pattern_step = 0.005;  // [1/m] > 0: and from one node of its pattern to the next
  double huber = 2.5;           // > 0: of an observation's error
  double good_share = 0.002;    // > 0: of a focal length; beyond it a number had better be seen
  double good_depth = 0.005;    // > 0: of depth, at the median of the points, likewise
  int max_iterations = 50;      // >= 1

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A camera's focal lengths and principal point, the offset of its depth and its pattern over the
// image, as a map tells them.
struct CameraCalibration {
  Eigen::Vector4d intrinsics;  // fx fy cx cy [px]
  Eigen::Vector4d sigma;       // [px] 0 where they are known
  std::array<bool, 4> seen{};  // sigma is within good_share of a focal length; none that is known
  // RgbdSensor::inverse_depth_offset of what the map's depth still is off by.
  double inverse_depth_offset = 0.0, inverse_depth_sigma = 0.0;  // [1/m]
  bool inverse_depth_seen = false;                               // to good_depth
  // RgbdSensor::depth_pattern, likewise, 0 in the mean over the image, and the deviations of its
  // nodes; 0 where none is looked for. Seen where it is known to good_depth in the root mean
  // square of the nodes.
  DepthPattern depth_pattern, depth_pattern_sigma;
  bool depth_pattern_seen = false;
  double error = 0.0;  // chi-squared per degree of freedom; beyond 1 sigma grows with it
  int keyframes = 0, points = 0, observations = 0;
  // What the motion did not tell well, and which motion would; in words, a line each.
  std::vector<std::string> advice;
};

// Adjusts all keyframes and points of a submap, with all that is joined with it, together with the
// camera that it was made with; the map stays as it is. Points without depth that were seen without
// parallax are left out. Pixels are undistorted with the distortion that was known. Throws
// InvalidArgument, saying so, on bad options, where the map has less than three keyframes or no
// such point that two of them see, and where the solver fails.
//                                docs/calibration.md, Intrinsics and Depth that reads too long
CameraCalibration CalibrateCamera(const Map& map, const MeasurementModel& model,
                                  SubmapId submap = kFirstSubmap,
                                  const CameraCalibrationOptions& options = {});
// The same of these keyframes, live and ascending, and of what they see.
CameraCalibration CalibrateCamera(const Map& map, const MeasurementModel& model,
                                  std::span<const KeyFrameId> keyframes,
                                  const CameraCalibrationOptions& options = {});

}  // namespace highwall
