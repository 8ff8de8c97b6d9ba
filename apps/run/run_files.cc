#include "run/run_files.h"

#include <filesystem>

#include <nlohmann/json.hpp>

namespace highwall::apps {

std::string NameOfSubmap(const std::string& name, std::size_t place) {
  if (place == 0) return name;
  const std::filesystem::path path(name);
  return path.stem().string() + "_" + std::to_string(place + 1) + path.extension().string();
}

std::size_t FirstPlace(const nlohmann::json& report) {
  const auto met = report.is_object() ? report.find("loaded_map_met") : report.end();
  return met != report.end() && *met == false ? 1 : 0;
}

std::string TrajectoryOfRun(std::size_t run) {
  return "trajectory_run" + std::to_string(run + 1) + ".txt";
}

}  // namespace highwall::apps
