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

// Measurement principle of a depth camera.
enum class DepthPrinciple {
  kUnknown,
  kTriangulation,  // a stereo pair, or a projector and a camera: steps and noise grow as z^2
  kTimeOfFlight,   // steps of constant size
};

// Stereo pair of a triangulating sensor.
struct StereoPair {
  double baseline = 0.05;              // [m] > 0
  double disparity_step = 1.0 / 32.0;  // [px] > 0, of the measured disparities
  double max_disparity = 126.0;        // [px] search range
  // [px] focal lengths of its modes, the most common first; 0: no further mode.
  std::array<double, 4> focals{};
  // Standard deviation of the ratio of `focals` to the real ones.
  double focal_tolerance = 0.02;

  // [1/m] > 0: the step of inverse depth in a mode.
  double InverseDepthStep(double focal) const { return disparity_step / (focal * baseline); }
};

// Depth properties of a camera product from data sheets and papers, independent of the individual
// lens (docs/sensors.md; sources in sensor_profile.cc).
struct SensorProfile {
  std::string_view name;   // in calibration.yaml: sensor: NAME
  std::string_view title;  // for people
  DepthPrinciple principle = DepthPrinciple::kUnknown;
  double min_depth = 0.05, max_depth = 20.0;  // [m] in any mode
  double depth_factor = 1000.0;               // [1/m] as stored by its driver
  DepthNoise noise{};                         // if subpixel is 0
  // Stereo cameras: the standard deviation of a disparity [px], and the ratio of the focal length
  // of the pair to that of the colour camera when their images have the same number of rows.
  double subpixel = 0.0, focal_ratio = 0.0;
  std::optional<StereoPair> pair{};
  bool round_field = false;  // its depth image has no corners
  bool dense = false;        // its depth image has no holes

  // Returns the noise for a camera, whose focal length determines that of the pair.
  DepthNoise NoiseFor(const PinholeCamera& camera) const;
  // Returns a sensor with range, depth factor and noise of the profile. Throws InvalidArgument if
  // the camera is not valid.
  RgbdSensor SensorFor(const PinholeCamera& camera) const;
};

// The profiles "kinect1", "kinect2", "azure", "d415", "d435", "d455", "l515", "iphone", "hololens"
// and, last, "generic".
std::span<const SensorProfile> SensorProfiles();

// Returns the profile of that name; null for any other name.
const SensorProfile* FindSensorProfile(std::string_view name);

// The names, separated by commas.
std::string SensorProfileList();

}  // namespace highwall
