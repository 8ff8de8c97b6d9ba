#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// How a camera finds depth.
enum class DepthPrinciple {
  kUnknown,
  kTriangulation,  // a pair of cameras, or a projector and a camera: steps and noise grow as z^2
  kTimeOfFlight,   // steps of one size
};

// The two eyes of a sensor that triangulates.
struct StereoPair {
  double baseline = 0.05;              // [m] > 0
  double disparity_step = 1.0 / 32.0;  // [px] > 0, of the disparities it finds
  double max_disparity = 126.0;        // [px] that it looks for
  // [px] focal lengths of its modes, the most used first; 0: no further mode.
  std::array<double, 4> focals{};
  // Of focals to the real ones, as a standard deviation of their ratio.
  double focal_tolerance = 0.02;

  // [1/m] > 0: the step of inverse depth in a mode.
  double InverseDepthStep(double focal) const { return disparity_step / (focal * baseline); }
};

// What data sheets and papers say of the depth of a camera that is sold, whatever the lens of the
// single one (sources in sensor_profile.cc and docs/sensors.md).
struct SensorProfile {
  std::string_view name;   // in calibration.yaml: sensor: NAME
  std::string_view title;  // for people
  DepthPrinciple principle = DepthPrinciple::kUnknown;
  double min_depth = 0.05, max_depth = 20.0;  // [m] in any mode
  double depth_factor = 1000.0;               // [1/m] as its driver stores it
  DepthNoise noise{};                         // where subpixel is 0
  // Of a stereo camera: the standard deviation of a disparity [px], and the focal length of the
  // pair over that of the colour camera when their images have the same number of rows.
  double subpixel = 0.0, focal_ratio = 0.0;
  std::optional<StereoPair> pair{};
  bool round_field = false;  // its field of view has no corners
  bool dense = false;        // it fills its holes

  // Of a camera, whose focal length tells that of the pair.
  DepthNoise NoiseFor(const PinholeCamera& camera) const;
  // Range, depth factor and noise of the profile. Throws InvalidArgument if the camera is not
  // valid.
  RgbdSensor SensorFor(const PinholeCamera& camera) const;
};

// "kinect1", "kinect2", "azure", "d415", "d435", "d455", "l515", "iphone", "hololens" and, last,
// "generic".
std::span<const SensorProfile> SensorProfiles();

// Null for any other name.
const SensorProfile* FindSensorProfile(std::string_view name);

// The names, separated by commas.
std::string SensorProfileList();

}  // namespace highwall
