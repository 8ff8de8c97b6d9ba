#include "run/config.h"

#include <fstream>
#include <functional>
#include <optional>
#include <regex>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/internal/did_you_mean.h>

#include "run/foreign_config.h"

namespace highwall::apps {
namespace {

std::string PresetList() {
  std::string list;
  for (const std::string_view name : SensorPresetNames()) {
    list += (list.empty() ? "" : ", ") + std::string(name);
  }
  return list;
}

// Returns the preset name for the digit of "freiburg1" or of a leading "fr1".
std::string PresetOf(const std::string& text) {
  static const std::regex pattern("freiburg([123])|(?:^|[^a-z])fr([123])(?:$|[^0-9a-z])");
  std::smatch match;
  if (!std::regex_search(text, match, pattern)) return "";
  return "tum" + (match[1].matched ? match[1].str() : match[2].str());
}

// Returns the name of the folder, also for ".", "..", and a trailing slash.
std::string FolderName(const std::filesystem::path& directory) {
  std::error_code error;
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(directory, error);
  return (canonical.has_filename() ? canonical : canonical.parent_path()).filename().string();
}

// Reads the calibration of a file.
using CalibrationReader = std::function<RunConfig(const std::string& file)>;

// Takes the size that a file does not state from the images of a dataset.
CalibrationReader ForDataset(const std::filesystem::path& dataset, const DatasetOptions& options) {
  return [dataset, options](const std::string& file) { return ReadSensor(file, dataset, options); };
}

ResolvedConfig Stated(const std::string& file, const CalibrationReader& read) {
  ResolvedConfig stated{read(file), file};
  stated.note = NoteOfDefaults(stated);
  if (!stated.note.empty()) {
    stated.note +=
        "; to state them, edit what 'highwall convert " + file + " calibration.yaml' writes";
  }
  return stated;
}

// Returns the configuration of a --config that is not empty.
ResolvedConfig GivenConfig(const std::string& choice, const CalibrationReader& read) {
  if (const std::optional<RgbdSensor> sensor = SensorPreset(choice)) {
    return {{*sensor}, "preset " + choice};
  }
  if (std::filesystem::exists(choice)) return Stated(choice, read);
  const std::vector<std::string_view> presets = SensorPresetNames();
  const std::string meant = DidYouMean(choice, {presets.begin(), presets.end()});
  throw IoError(choice, "is neither a file nor a preset (" + PresetList() + ")" +
                            (meant.empty() ? DidYouMeanPath(choice) : meant));
}

// Returns the preset that the name of a dataset implies.
std::optional<ResolvedConfig> NamedConfig(const std::filesystem::path& dataset) {
  const std::string preset = PresetFromName(dataset);
  const std::optional<RgbdSensor> sensor = SensorPreset(preset);
  if (!sensor) return std::nullopt;
  return ResolvedConfig{{*sensor}, "preset " + preset + ", by the dataset's name"};
}

// Completes a file of another system, if there is something to complete it with.
ResolvedConfig Completed(const ResolvedConfig& stated, const std::optional<ResolvedConfig>& own) {
  if (stated.config.format.empty() || !own) return stated;
  return CompletedBy(own->config, own->origin, stated);
}

}  // namespace

std::string ConfigOfRun(const std::string& calibration) {
  constexpr std::string_view kPreset = "preset ";
  if (calibration.starts_with(kPreset)) {
    const std::string name = calibration.substr(kPreset.size());
    return SensorPreset(name) ? name : "";  // otherwise implied by the dataset's name
  }
  std::error_code is_no_path;
  return std::filesystem::is_regular_file(calibration, is_no_path) ? calibration : "";
}

std::filesystem::path CalibrationFile(const std::filesystem::path& dataset) {
  return dataset / "calibration.yaml";
}

std::string PresetFromName(const std::filesystem::path& dataset) {
  if (const std::string preset = PresetOf(FolderName(dataset)); !preset.empty()) return preset;
  std::ifstream list(dataset / "rgb.txt");
  for (std::string line; std::getline(list, line) && line.starts_with('#');) {
    if (const std::string preset = PresetOf(line); !preset.empty()) return preset;
  }
  return "";
}

std::optional<ResolvedConfig> OwnConfig(const std::filesystem::path& dataset,
                                        const DatasetOptions& options) {
  const std::optional<ResolvedConfig> named = NamedConfig(dataset);
  const std::filesystem::path calibration = CalibrationFile(dataset);
  if (!std::filesystem::exists(calibration)) return named;
  return Completed(Stated(calibration.string(), ForDataset(dataset, options)), named);
}

ResolvedConfig ResolveConfig(const std::string& choice, const std::filesystem::path& dataset,
                             const DatasetOptions& options) {
  if (!choice.empty()) {
    const ResolvedConfig given = GivenConfig(choice, ForDataset(dataset, options));
    if (given.config.format.empty()) return given;
    std::error_code is_none;
    const bool is_own = std::filesystem::equivalent(choice, CalibrationFile(dataset), is_none);
    return Completed(given, is_own ? NamedConfig(dataset) : OwnConfig(dataset, options));
  }
  if (std::optional<ResolvedConfig> own = OwnConfig(dataset, options)) return *std::move(own);
  // A folder that is not a dataset gets a clearer error from its reader.
  OpenDataset(dataset, std::nullopt, {.max_stamp_difference = 1.0});
  throw IoError(dataset,
                std::string("the camera is unknown: ") +
                    (std::filesystem::is_directory(dataset)
                         ? "put calibration.yaml there, or give --config "
                         : "the bag has no camera_info of its colour images; give --config ") +
                    "with a file or one of " + PresetList());
}

ResolvedConfig ResolveCameraConfig(const std::string& choice, const cv::Size& image_size) {
  return GivenConfig(choice, [&](const std::string& file) { return ReadSensor(file, image_size); });
}

}  // namespace highwall::apps
