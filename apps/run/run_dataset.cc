#include "run/run_dataset.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <system_error>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/input/open_dataset.h>

#include "files/json_text.h"
#include "run/config.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

constexpr Stamp kWrittenTo = 1'000;  // [ns] resolution of stamps in reports

// Returns an empty string if the value is not a string.
std::string TextAt(const nlohmann::json& report, const char* key) {
  const bool is_there = report.is_object() && report.contains(key) && report.at(key).is_string();
  return is_there ? StringIn(report.at(key)) : "";
}

std::vector<Stamp> StampsOf(const nlohmann::json& report) {
  const nlohmann::json::json_pointer frames("/per_frame/stamp");
  std::vector<Stamp> stamps;
  if (!report.contains(frames) || !report.at(frames).is_array()) return stamps;
  for (const nlohmann::json& text : report.at(frames)) {
    if (!text.is_string()) continue;
    if (const std::optional<Stamp> stamp = ParseStamp(text.get<std::string>())) {
      stamps.push_back(*stamp);
    }
  }
  return stamps;
}

bool HoldsFrames(const fs::path& dataset, const std::vector<Stamp>& frames,
                 const DatasetOptions& options) {
  try {
    // The camera does not matter, since only the stamps are used.
    const std::unique_ptr<const Dataset> images = OpenDataset(dataset, std::nullopt, options);
    std::vector<Stamp> stamps;
    for (std::size_t i = 0; i < images->size(); ++i) stamps.push_back(images->stamp(i));
    std::ranges::sort(stamps);
    return std::ranges::all_of(frames, [&](Stamp frame) {
      const auto at = std::ranges::lower_bound(stamps, frame - kWrittenTo);
      return at != stamps.end() && *at <= frame + kWrittenTo;
    });
  } catch (const std::exception&) {
    return false;  // an unreadable dataset cannot be the one of the run
  }
}

}  // namespace

std::vector<fs::path> PlacesOf(const fs::path& name, const fs::path& run) {
  std::vector<fs::path> places;
  std::error_code error;
  const auto add = [&](const fs::path& place) {
    const auto is_same = [&](const fs::path& other) { return fs::equivalent(place, other, error); };
    if (fs::exists(place, error) && std::ranges::none_of(places, is_same)) places.push_back(place);
  };
  if (name.empty()) return places;
  add(fs::absolute(name, error));
  if (name.is_absolute()) return places;
  fs::path above = fs::weakly_canonical(fs::absolute(run, error), error);
  while (above.has_relative_path()) {
    above = above.parent_path();
    add(above / name);
  }
  return places;
}

DatasetOptions InputOptionsOfRun(const nlohmann::json& report) {
  DatasetOptions options;
  const auto read = [&report](const char* key, double most, double* value) {
    if (!report.is_object() || !report.contains(key) || !report[key].is_number()) return;
    const double stated = report[key].get<double>();
    if (stated > 0.0 && stated <= most) *value = stated;
  };
  read("max_pair_difference_s", 1.0, &options.max_stamp_difference);
  read("frame_rate_hz", 1e4, &options.frame_rate);
  try {
    options.topics = ReadBagTopics(TextAt(report, "topics"));
  } catch (const InvalidArgument&) {  // changed by hand: they are guessed again
  }
  return options;
}

std::vector<fs::path> DatasetsOfRun(const fs::path& run, const nlohmann::json& report) {
  const fs::path name = TextAt(report, "dataset");
  std::vector<fs::path> places = PlacesOf(name, run);
  std::error_code error;
  std::erase_if(places, [&](const fs::path& place) { return !fs::exists(place, error); });
  if (name.is_absolute()) return places;
  const std::vector<Stamp> frames = StampsOf(report);
  const DatasetOptions options = InputOptionsOfRun(report);
  std::erase_if(places,
                [&](const fs::path& place) { return !HoldsFrames(place, frames, options); });
  return places;
}

std::string CalibrationOfRun(const fs::path& run, const nlohmann::json& report) {
  const fs::path name = TextAt(report, "calibration");
  if (name.empty() || name.is_absolute()) return ConfigOfRun(name);
  // A calibration in the dataset's folder is found there.
  if (name == CalibrationFile(TextAt(report, "dataset"))) return "";
  const std::vector<fs::path> places = PlacesOf(name, run);
  return ConfigOfRun(places.size() == 1 ? places.front().string() : name.string());
}

}  // namespace highwall::apps
