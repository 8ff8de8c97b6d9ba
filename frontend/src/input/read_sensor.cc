#include <highwall/frontend/input/sensor.h>

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor_profile.h>
#include <highwall/frontend/input/yaml_reader.h>

#include "input/foreign_calibration.h"

namespace highwall {
namespace {

void ReadCameraSection(YamlReader& section, const std::filesystem::path& path,
                       PinholeCamera* camera) {
  section.Require("width", &camera->width);
  section.Require("height", &camera->height);
  section.Require("fx", &camera->fx);
  section.Require("fy", &camera->fy);
  section.Require("cx", &camera->cx);
  section.Require("cy", &camera->cy);
  section.Read("k1", &camera->k1);
  section.Read("k2", &camera->k2);
  section.Read("p1", &camera->p1);
  section.Read("p2", &camera->p2);
  section.Read("k3", &camera->k3);
  section.Read("k4", &camera->k4);
  section.Read("k5", &camera->k5);
  section.Read("k6", &camera->k6);
  std::string lens = "radial_tangential";
  section.Read("lens", &lens);
  if (lens == "equidistant") {
    camera->lens = LensModel::kEquidistant;
  } else if (lens != "radial_tangential") {
    throw IoError(path, section.LineOf("", "lens").value(),
                  "camera: lens must be radial_tangential (k1, k2, p1, p2, k3, and k4 to k6 of a "
                  "rational model) or equidistant (k1 to k4 of a fisheye), not " +
                      lens);
  }
  for (const char* key : {"s1", "s2", "s3", "s4"}) {
    double value = 0.0;
    section.Read(key, &value);
    if (value == 0.0) continue;  // zero coefficients: the same model
    throw IoError(path, section.LineOf("", key).value(),
                  std::string("camera: ") + key +
                      " is of a lens with a thin prism, which is not known: calibrate with k1 to "
                      "k6, p1 and p2, or undistort the images");
  }
}

// Reads a transform of 16 numbers, row by row. section_name: for messages.
Pose ReadTransform(YamlReader& section, const std::filesystem::path& path, const std::string& key,
                   const std::string& section_name, const Pose& value) {
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T = value.Matrix();
  section.Read(key, std::span<double>(T.data(), 16));
  if (T.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) {
    throw IoError(path, "'" + key + "' of section '" + section_name +
                            "' must end with 0, 0, 0, 1: write it row by row");
  }
  return Pose::FromMatrix(T);
}

// Reads the constants of the noise curve, or those of the stereo pair that produces the depth.
void ReadDepthNoiseSection(YamlReader& section, DepthNoise* noise) {
  if (section.Has("baseline") || section.Has("focal") || section.Has("subpixel")) {
    double baseline = 0.0, focal = 0.0, subpixel = 0.08;  // [px] of a RealSense
    section.Require("baseline", &baseline);
    section.Require("focal", &focal);
    section.Read("subpixel", &subpixel);
    section.Finish();
    *noise = DepthNoise::Stereo(subpixel, focal, baseline);
    return;
  }
  section.Read("offset", &noise->offset);
  section.Read("quadratic", &noise->quadratic);
  section.Read("reference", &noise->reference);
}

// Applies the sensor profile before the other keys of the file.
void ReadSensorName(YamlReader& file, const std::filesystem::path& path, RgbdSensor* sensor) {
  std::string name;
  file.Read("sensor", &name);
  if (!file.Has("sensor")) return;
  const SensorProfile* profile = FindSensorProfile(name);
  if (profile == nullptr) {
    throw IoError(path, "the sensor '" + name + "' is unknown; known are " + SensorProfileList());
  }
  *sensor = profile->SensorFor(sensor->camera);
}

void ReadDepthRangeSection(YamlReader& section, RgbdSensor* sensor) {
  section.Read("min", &sensor->min_depth);
  section.Read("max", &sensor->max_depth);
}

// Reads errors of a camera that are not in its data sheet.
void ReadErrorSections(YamlReader& file, RgbdSensor* sensor) {
  YamlReader& colour = file.Section("colour");
  colour.Read("readout", &sensor->timing.colour_readout);
  colour.Read("direction", "down, up, right or left: where the read-out goes",
              [sensor](const std::string& name) {
                const auto direction = ReadoutDirectionOf(name);
                if (direction) sensor->timing.direction = *direction;
                return direction.has_value();
              });
  YamlReader& depth = file.Section("depth");
  depth.Read("readout", &sensor->timing.depth_readout);
  depth.Read("delay", &sensor->timing.depth_delay);
  depth.Read("inverse_offset", &sensor->inverse_depth_offset);
  DepthPattern::Vector& nodes = sensor->depth_pattern.nodes;
  depth.Read("pattern", std::span<double>(nodes.data(), static_cast<std::size_t>(nodes.size())));
}

void ReadImuSection(YamlReader& section, const std::filesystem::path& path, ImuCalibration* imu) {
  imu->T_BC = ReadTransform(section, path, "T_BC", "imu", imu->T_BC);
  section.Read("gyroscope_noise", &imu->noise.gyroscope);
  section.Read("accelerometer_noise", &imu->noise.accelerometer);
  section.Read("gyroscope_walk", &imu->noise.gyroscope_walk);
  section.Read("accelerometer_walk", &imu->noise.accelerometer_walk);
  section.Read("rate", &imu->rate);
  section.Read("time_offset", &imu->time_offset);
  section.Read("gyroscope_range", &imu->gyroscope_range);
  section.Read("accelerometer_range", &imu->accelerometer_range);
}

void ReadGpsSection(YamlReader& section, const std::filesystem::path& path,
                    Eigen::Vector3d* antenna_B) {
  section.Read("antenna", std::span<double>(antenna_B->data(), 3));
  if (!antenna_B->allFinite()) {
    throw IoError(path, "'antenna' of section 'gps' must be three numbers [m]");
  }
}

struct ConfigKey {
  std::string section, key;
};

// Returns the key of a struct's field. Fields of a camera and of an IMU have the names of their
// keys.
ConfigKey ConfigKeyOf(const std::string& field) {
  static const std::map<std::string, ConfigKey, std::less<>> kOthers = {
      {"RgbdSensor::depth_factor", {"", "depth_factor"}},
      {"RgbdSensor::inverse_depth_offset", {"depth", "inverse_offset"}},
      {"RgbdSensor::min_depth", {"depth_range", "min"}},
      {"RgbdSensor::max_depth", {"depth_range", "max"}},
      {"DepthPattern::nodes", {"depth", "pattern"}},
      {"FrameTiming::colour_readout", {"colour", "readout"}},
      {"FrameTiming::depth_readout", {"depth", "readout"}},
      {"FrameTiming::depth_delay", {"depth", "delay"}}};
  if (const auto other = kOthers.find(field); other != kOthers.end()) return other->second;
  constexpr std::pair<std::string_view, std::string_view> kSections[] = {
      {"PinholeCamera::", "camera"},
      {"ImuCalibration::", "imu"},
      {"ImuNoise::", "imu"},
      {"DepthNoise::", "depth_noise"}};
  for (const auto& [prefix, section] : kSections) {
    if (field.starts_with(prefix)) return {std::string(section), field.substr(prefix.size())};
  }
  return {};
}

// Translates an error about a struct's field into one about the key of its section, with its line.
IoError InWordsOfTheFile(const std::filesystem::path& path, const YamlReader& file,
                         const std::string& message) {
  const std::string field = message.substr(0, message.find(' '));
  const ConfigKey key = ConfigKeyOf(field);
  if (key.key.empty()) return {path, message};
  const std::string words =
      (key.section.empty() ? "" : key.section + ": ") + key.key + message.substr(field.size());
  const auto line = file.LineOf(key.section, key.key);
  return line ? IoError(path, *line, words) : IoError(path, words);
}

}  // namespace

SensorCalibration ReadSensor(const std::filesystem::path& path) {
  if (std::optional<SensorCalibration> foreign = ReadForeignCalibration(path)) {
    return *std::move(foreign);
  }
  SensorCalibration config;
  YamlReader file = YamlReader::Load(path);
  ReadCameraSection(file.Section("camera"), path, &config.sensor.camera);
  try {
    ReadSensorName(file, path, &config.sensor);
    if (file.Has("sensor")) {
      file.Read("depth_factor", &config.sensor.depth_factor);
    } else {
      file.Require("depth_factor", &config.sensor.depth_factor);
    }
    ReadDepthRangeSection(file.Section("depth_range"), &config.sensor);
    ReadDepthNoiseSection(file.Section("depth_noise"), &config.sensor.depth_noise);
    ReadErrorSections(file, &config.sensor);
    YamlReader& depth_camera = file.Section("depth_camera");
    if (file.Has("depth_camera")) {
      DepthCameraCalibration& camera = config.sensor.depth_camera.emplace();
      ReadCameraSection(depth_camera, path, &camera.camera);
      camera.T_CD = ReadTransform(depth_camera, path, "T_CD", "depth_camera", camera.T_CD);
    }
    YamlReader& imu = file.Section("imu");
    if (file.Has("imu")) ReadImuSection(imu, path, &config.imu.emplace());
    ReadGpsSection(file.Section("gps"), path, &config.antenna_B);
    file.Finish();
    config.sensor.Validate();
    if (config.imu) config.imu->Validate();
  } catch (const InvalidArgument& error) {
    throw InWordsOfTheFile(path, file, error.what());
  }
  return config;
}

}  // namespace highwall
