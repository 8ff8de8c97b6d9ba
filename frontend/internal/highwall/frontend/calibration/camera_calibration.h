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
  bool intrinsics = true;  // false: they are known and fixed
  // The camera with its distortion, over whose image the depth distortion is estimated; empty: it
  // is known and fixed.
  std::optional<PinholeCamera> pattern_of{};
  double focal_share = 0.1;  // > 0: prior standard deviation of the focal lengths, relative
  // > 0: of the principal point, relative to the image's width and height
  double centre_share = 0.1;
  double inverse_depth = 0.02;  // [1/m] > 0: of the offset of the inverse depth
  double pattern_step = 0.005;  // [1/m] > 0: between neighbouring nodes of the depth distortion
  double huber = 2.5;           // > 0: Huber threshold on an observation's error
  // > 0: sigma, relative to a focal length, below which a value counts as observed
  double good_share = 0.002;
  double good_depth = 0.005;  // > 0: the same for depth, relative, at the median of the points
  int max_iterations = 50;    // >= 1

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A camera's focal lengths and principal point, the offset of its depth and its depth distortion,
// as estimated from a map.
struct CameraCalibration {
  Eigen::Vector4d intrinsics;  // fx fy cx cy [px]
  Eigen::Vector4d sigma;       // [px] 0 if known
  std::array<bool, 4> seen{};  // sigma is within good_share of a focal length; false if known
  // Remaining error of the map's depth, as RgbdSensor::inverse_depth_offset.
  double inverse_depth_offset = 0.0, inverse_depth_sigma = 0.0;  // [1/m]
  bool inverse_depth_seen = false;                               // to good_depth
  // Remaining depth distortion, as RgbdSensor::depth_pattern, with zero mean over the image, and
  // the standard deviations of its nodes; 0 if not estimated. Observed if it is known to good_depth
  // in the root mean square of the nodes.
  DepthPattern depth_pattern, depth_pattern_sigma;
  bool depth_pattern_seen = false;
  double error = 0.0;  // chi-squared per degree of freedom; above 1 sigma is scaled with it
  int keyframes = 0, points = 0, observations = 0;
  // Values that the motion did not observe well, and motions that would; in words, a line each.
  std::vector<std::string> advice;
};

// Adjusts all keyframes and points of a submap, and of all merged with it, together with the camera
// that recorded it; the map is not changed. Points without depth and without parallax are left out.
// Pixels are undistorted with the known distortion. Returns empty if the map has fewer than three
// keyframes or no such point that two of them see, if the solver fails, and if the solution has no
// covariance. reason: if not null, output of which of these, one line. Throws InvalidArgument for
// bad options.
// See docs/calibration.md, Intrinsics and Depth that reads too long.
std::optional<CameraCalibration> CalibrateCamera(const Map& map, const MeasurementModel& model,
                                                 SubmapId submap = kFirstSubmap,
                                                 const CameraCalibrationOptions& options = {},
                                                 std::string* reason = nullptr);
// The same for these keyframes, active and ascending, and the points that they see.
std::optional<CameraCalibration> CalibrateCamera(const Map& map, const MeasurementModel& model,
                                                 std::span<const KeyFrameId> keyframes,
                                                 const CameraCalibrationOptions& options = {},
                                                 std::string* reason = nullptr);

}  // namespace highwall
