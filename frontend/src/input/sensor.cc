#include <highwall/frontend/input/sensor.h>

#include <array>
#include <cmath>
#include <string>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor_profile.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

struct Preset {
  std::string_view name;
  double depth_factor;
  PinholeCamera camera;
};

const std::array<Preset, 3>& Presets() {
  static const std::array<Preset, 3> presets{{
      {"tum1",
       5000.0,
       {.fx = 517.3,
        .fy = 516.5,
        .cx = 318.6,
        .cy = 255.3,
        .k1 = 0.2624,
        .k2 = -0.9531,
        .p1 = -0.0054,
        .p2 = 0.0026,
        .k3 = 1.1633}},
      {"tum2",
       5208.0,
       {.fx = 520.9,
        .fy = 521.0,
        .cx = 325.1,
        .cy = 249.7,
        .k1 = 0.2312,
        .k2 = -0.7849,
        .p1 = -0.0033,
        .p2 = -0.0001,
        .k3 = 0.9172}},
      {"tum3", 5000.0, {.fx = 535.4, .fy = 539.2, .cx = 320.1, .cy = 247.6}},
  }};
  return presets;
}

// A pinhole image whose half is ten times as wide as its focal length would span 157 degrees.
void RequireFocalLength(double focal, int size, const char* field, const char* side) {
  constexpr double kLeast = 0.1;
  HIGHWALL_REQUIRE(focal >= kLeast * size, std::string(field) + " is " + NumberText(focal) +
                                               " px, less than a tenth of the image's " + side +
                                               " (" + std::to_string(size) +
                                               "): is it normalized? multiply it by the " + side);
}

void RequireInImage(double centre, int size, const char* field, const char* side) {
  HIGHWALL_REQUIRE(centre >= 0.0 && centre <= size,
                   std::string(field) + " is " + NumberText(centre) +
                       " px, outside of the image, whose " + side + " is " + std::to_string(size) +
                       ": does it belong to another image size?");
}

// Requires what no camera with registered depth violates. Pixels are square before an image is
// scaled, and no usual format changes the ratio of its sides by as much.
void RequirePossibleLens(const PinholeCamera& camera) {
  constexpr double kMostStretched = 1.9;
  RequireFocalLength(camera.fx, camera.width, "PinholeCamera::fx", "width");
  RequireFocalLength(camera.fy, camera.height, "PinholeCamera::fy", "height");
  RequireInImage(camera.cx, camera.width, "PinholeCamera::cx", "width");
  RequireInImage(camera.cy, camera.height, "PinholeCamera::cy", "height");
  const double ratio = camera.fx / camera.fy;
  HIGHWALL_REQUIRE(ratio < kMostStretched && ratio > 1.0 / kMostStretched,
                   "PinholeCamera::fx is " + NumberText(camera.fx) + " px and fy " +
                       NumberText(camera.fy) +
                       " px: pixels are about square, so that one of them is wrong or belongs to "
                       "another image size");
}

}  // namespace

const char* ToString(ReadoutDirection direction) {
  switch (direction) {
    case ReadoutDirection::kDown:
      return "down";
    case ReadoutDirection::kUp:
      return "up";
    case ReadoutDirection::kRight:
      return "right";
    case ReadoutDirection::kLeft:
      return "left";
  }
  return "";
}

std::optional<ReadoutDirection> ReadoutDirectionOf(std::string_view name) {
  for (const auto direction : {ReadoutDirection::kDown, ReadoutDirection::kUp,
                               ReadoutDirection::kRight, ReadoutDirection::kLeft}) {
    if (name == ToString(direction)) return direction;
  }
  return std::nullopt;
}

void FrameTiming::Validate() const {
  RequireNotNegativeFinite(colour_readout, "FrameTiming::colour_readout");
  RequireNotNegativeFinite(depth_readout, "FrameTiming::depth_readout");
  HIGHWALL_REQUIRE(std::isfinite(depth_delay), "FrameTiming::depth_delay must be finite");
}

void DepthCameraCalibration::Validate() const {
  try {
    camera.Validate();
    RequirePossibleLens(camera);
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(std::string("DepthCameraCalibration: ") + error.what());
  }
  constexpr double kFarthest = 0.5;  // [m] from the colour camera, in one housing
  HIGHWALL_REQUIRE(T_CD.p().norm() <= kFarthest,
                   "DepthCameraCalibration::T_CD is " + FixedText(T_CD.p().norm()) +
                       " m from the colour camera: is its translation in m?");
}

void RgbdSensor::Validate() const {
  if (depth_camera) depth_camera->Validate();
  camera.Validate();
  RequirePossibleLens(camera);
  depth_noise.Validate();
  depth_pattern.Validate();
  timing.Validate();
  HIGHWALL_REQUIRE(std::isfinite(depth_factor) && depth_factor > 0.0,
                   "RgbdSensor::depth_factor must be positive, got " + FixedText(depth_factor));
  HIGHWALL_REQUIRE(std::abs(inverse_depth_offset) < 1.0,
                   "RgbdSensor::inverse_depth_offset must be within 1 / m, got " +
                       FixedText(inverse_depth_offset));
  RequirePositiveFinite(min_depth, "RgbdSensor::min_depth");
  HIGHWALL_REQUIRE(std::isfinite(max_depth) && max_depth > min_depth,
                   "RgbdSensor::max_depth must exceed min_depth, got " + FixedText(max_depth));
}

std::optional<RgbdSensor> SensorPreset(std::string_view name) {
  for (const Preset& preset : Presets()) {
    if (preset.name != name) continue;
    RgbdSensor sensor = FindSensorProfile("kinect1")->SensorFor(preset.camera);
    sensor.depth_factor = preset.depth_factor;
    return sensor;
  }
  return std::nullopt;
}

std::vector<std::string_view> SensorPresetNames() {
  std::vector<std::string_view> names;
  for (const Preset& preset : Presets()) names.push_back(preset.name);
  return names;
}

}  // namespace highwall
