#include "run/calibration_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <highwall/core/atomic_file.h>
#include <highwall/internal/number_text.h>

namespace highwall::apps {
namespace {

using Entries = std::vector<std::pair<const char*, double>>;

// yaml-cpp writes numbers with the locale of the process.
std::string YamlNumber(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  return RoundedText(value, std::numeric_limits<double>::max_digits10);
}

std::vector<std::string> YamlNumbers(std::span<const double> values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(YamlNumber(value));
  return texts;
}

void Write(const Entries& entries, YAML::Emitter* out) {
  *out << YAML::BeginMap;
  for (const auto& [key, value] : entries) {
    *out << YAML::Key << key << YAML::Value << YamlNumber(value);
  }
  *out << YAML::EndMap;
}

void WriteSection(const char* name, const Entries& entries, YAML::Emitter* out) {
  *out << YAML::Key << name << YAML::Value;
  Write(entries, out);
}

// Writes the keys of a camera into the map that is open.
void WriteCamera(const PinholeCamera& camera, YAML::Emitter* out) {
  *out << YAML::Key << "width" << YAML::Value << std::to_string(camera.width);
  *out << YAML::Key << "height" << YAML::Value << std::to_string(camera.height);
  for (const auto& [key, value] : Entries{{"fx", camera.fx},
                                          {"fy", camera.fy},
                                          {"cx", camera.cx},
                                          {"cy", camera.cy},
                                          {"k1", camera.k1},
                                          {"k2", camera.k2},
                                          {"p1", camera.p1},
                                          {"p2", camera.p2},
                                          {"k3", camera.k3}}) {
    *out << YAML::Key << key << YAML::Value << YamlNumber(value);
  }
  for (const auto& [key, value] :
       Entries{{"k4", camera.k4}, {"k5", camera.k5}, {"k6", camera.k6}}) {
    if (value != 0.0) *out << YAML::Key << key << YAML::Value << YamlNumber(value);
  }
  if (camera.lens == LensModel::kEquidistant) {
    *out << YAML::Key << "lens" << YAML::Value << "equidistant";
  }
}

void WriteCameras(const RgbdSensor& sensor, YAML::Emitter* out) {
  *out << YAML::Key << "camera" << YAML::Value << YAML::BeginMap;
  WriteCamera(sensor.camera, out);
  *out << YAML::EndMap;
  if (!sensor.depth_camera) return;
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T_CD = sensor.depth_camera->T_CD.Matrix();
  *out << YAML::Key << "depth_camera" << YAML::Value << YAML::BeginMap;
  WriteCamera(sensor.depth_camera->camera, out);
  *out << YAML::Key << "T_CD" << YAML::Value << YAML::Flow << YamlNumbers({T_CD.data(), 16});
  *out << YAML::EndMap;
}

void WriteImu(const ImuCalibration& imu, YAML::Emitter* out) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T_BC = imu.T_BC.Matrix();
  *out << YAML::Key << "imu" << YAML::Value << YAML::BeginMap;
  *out << YAML::Key << "T_BC" << YAML::Value << YAML::Flow << YamlNumbers({T_BC.data(), 16});
  for (const auto& [key, value] : Entries{{"gyroscope_noise", imu.noise.gyroscope},
                                          {"accelerometer_noise", imu.noise.accelerometer},
                                          {"gyroscope_walk", imu.noise.gyroscope_walk},
                                          {"accelerometer_walk", imu.noise.accelerometer_walk},
                                          {"rate", imu.rate},
                                          {"time_offset", imu.time_offset}}) {
    *out << YAML::Key << key << YAML::Value << YamlNumber(value);
  }
  for (const auto& [key, range] : Entries{{"gyroscope_range", imu.gyroscope_range},
                                          {"accelerometer_range", imu.accelerometer_range}}) {
    if (std::isfinite(range)) *out << YAML::Key << key << YAML::Value << YamlNumber(range);
  }
  *out << YAML::EndMap;
}

struct Measured {
  const char* key;
  double value, sigma;
};

void Write(const Measured& entry, YAML::Emitter* out) {
  *out << YAML::Key << entry.key << YAML::Value << YamlNumber(entry.value);
  if (entry.sigma > 0.0) *out << YAML::Comment(fmt::format("+- {:.2g}", entry.sigma));
}

bool IsMeasured(const Measured& entry) {
  return entry.value != 0.0 || entry.sigma != 0.0;
}

// Sections without values are omitted, so that the file is the same as in older versions.
void WriteErrors(const RgbdSensor& sensor, const CalibrationSigma& sigma, YAML::Emitter* out) {
  const FrameTiming& timing = sensor.timing;
  const Measured readout{"readout", timing.colour_readout, sigma.timing.colour_readout};
  const bool is_turned = timing.direction != ReadoutDirection::kDown;
  if (IsMeasured(readout) || is_turned) {
    *out << YAML::Key << "colour" << YAML::Value << YAML::BeginMap;
    Write(readout, out);
    if (is_turned) *out << YAML::Key << "direction" << YAML::Value << ToString(timing.direction);
    *out << YAML::EndMap;
  }
  const Measured depth[] = {
      {"delay", timing.depth_delay, sigma.timing.depth_delay},
      {"readout", timing.depth_readout, sigma.timing.depth_readout},
      {"inverse_offset", sensor.inverse_depth_offset, sigma.inverse_depth_offset}};
  const DepthPattern& pattern = sensor.depth_pattern;
  if (pattern.IsZero() && std::ranges::none_of(depth, IsMeasured)) return;
  *out << YAML::Key << "depth" << YAML::Value << YAML::BeginMap;
  for (const Measured& entry : depth) Write(entry, out);
  if (!pattern.IsZero()) {
    *out << YAML::Key << "pattern";
    if (sigma.depth_pattern > 0.0) {
      *out << YAML::Comment(fmt::format("+- {:.2g}", sigma.depth_pattern));
    }
    *out << YAML::Value << YAML::Flow
         << YamlNumbers({pattern.nodes.data(), static_cast<std::size_t>(pattern.nodes.size())});
  }
  *out << YAML::EndMap;
}

}  // namespace

void WriteConfig(const std::filesystem::path& path, const RunConfig& config,
                 const CalibrationSigma& sigma, const std::string& depth_factor_comment) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  WriteCameras(config.sensor, &out);
  out << YAML::Key << "depth_factor" << YAML::Value << YamlNumber(config.sensor.depth_factor);
  if (!depth_factor_comment.empty()) out << YAML::Comment(depth_factor_comment);
  WriteSection("depth_range", {{"min", config.sensor.min_depth}, {"max", config.sensor.max_depth}},
               &out);
  const DepthNoise& noise = config.sensor.depth_noise;
  WriteSection(
      "depth_noise",
      {{"offset", noise.offset}, {"quadratic", noise.quadratic}, {"reference", noise.reference}},
      &out);
  WriteErrors(config.sensor, sigma, &out);
  if (config.imu) WriteImu(*config.imu, &out);
  out << YAML::EndMap;
  std::error_code ignored;  // writing the file reports the error
  std::filesystem::create_directories(std::filesystem::absolute(path).parent_path(), ignored);
  AtomicFile file(path);
  file.stream() << out.c_str() << '\n';
  file.Commit();
}

}  // namespace highwall::apps
