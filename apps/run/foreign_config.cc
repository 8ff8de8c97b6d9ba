#include "run/foreign_config.h"

#include <algorithm>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace highwall::apps {
namespace {

bool States(const RunConfig& config, const char* key) {
  return std::ranges::find(config.defaults, key) == config.defaults.end();
}

// own: of the same IMU, if the recording states one.
ImuCalibration CompletedImu(const RunConfig& foreign, const std::optional<ImuCalibration>& own) {
  ImuCalibration imu = own.value_or(*foreign.imu);
  imu.T_BC = foreign.imu->T_BC;
  if (States(foreign, "imu: noise")) imu.noise = foreign.imu->noise;
  if (States(foreign, "imu: rate")) imu.rate = foreign.imu->rate;
  if (States(foreign, "imu: time_offset")) imu.time_offset = foreign.imu->time_offset;
  return imu;
}

// Returns "FILE is FORMAT, which does not state KEYS: SOURCE (depth_factor 1000)".
std::string Note(const ResolvedConfig& foreign, const std::string& source, double depth_factor) {
  std::string note =
      fmt::format("{} is {}, which does not state {}: {}", foreign.origin, foreign.config.format,
                  fmt::join(foreign.config.defaults, ", "), source);
  if (!States(foreign.config, "depth_factor")) {
    note += fmt::format(" (depth_factor {:g})", depth_factor);
  }
  return note;
}

}  // namespace

ResolvedConfig CompletedBy(const RunConfig& own, const std::string& own_origin,
                           const ResolvedConfig& foreign) {
  const RunConfig& given = foreign.config;
  ResolvedConfig result{own, foreign.origin};
  RunConfig& config = result.config;
  config.sensor.camera = given.sensor.camera;
  if (States(given, "depth_factor")) config.sensor.depth_factor = given.sensor.depth_factor;
  if (given.imu) {
    config.imu = CompletedImu(given, own.imu);
    // It was stated in the frame of the camera.
    if (!own.imu && !own.antenna_B.isZero()) config.antenna_B = given.imu->T_BC * own.antenna_B;
  }
  config.format = given.format;
  config.defaults = own.defaults;
  result.note = Note(foreign, "they are those of " + own_origin, config.sensor.depth_factor);
  return result;
}

std::string NoteOfDefaults(const ResolvedConfig& config) {
  if (config.config.format.empty()) return "";
  return Note(config, "defaults are assumed", config.config.sensor.depth_factor);
}

}  // namespace highwall::apps
