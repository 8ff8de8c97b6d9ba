#include "run/opened_dataset.h"

#include <utility>

#include <fmt/core.h>

#include <highwall/core/error.h>
#include <highwall/internal/did_you_mean.h>

#include "run/foreign_config.h"

namespace highwall::apps {

void PrintSources(const std::string& command, const OpenedDataset& opened) {
  const std::string topics = ToText(opened.images->topics());
  if (!topics.empty()) fmt::print(stderr, "highwall {}: topics {}\n", command, topics);
  if (!opened.note.empty()) fmt::print(stderr, "highwall {}: {}\n", command, opened.note);
}

OpenedDataset OpenWithConfig(const std::string& choice, const std::filesystem::path& directory,
                             const DatasetOptions& options) {
  if (!std::filesystem::exists(directory)) {
    throw IoError(directory, "does not exist" + DidYouMeanPath(directory));
  }
  const DatasetReader* const reader = FindDatasetReader(directory);
  const bool states_camera = reader != nullptr && !reader->calibration.empty();
  const bool is_fixed = states_camera && reader->fixed_camera;
  if (is_fixed && !choice.empty()) {
    throw IoError(directory, "is of " + std::string(reader->format) +
                                 "'s layout, whose calibration is in " +
                                 std::string(reader->calibration) + ": leave --config out");
  }
  const bool is_given = !choice.empty() || std::filesystem::exists(CalibrationFile(directory));
  if (states_camera && (is_fixed || !is_given)) {
    std::unique_ptr<const Dataset> images = reader->open(directory, std::nullopt, options);
    if (const SensorCalibration* const stated = images->calibration()) {
      RunConfig config = *stated;
      return {std::move(images), std::move(config), std::string(reader->calibration)};
    }
  }
  ResolvedConfig resolved = ResolveConfig(choice, directory, options);
  if (states_camera && !resolved.config.defaults.empty()) {
    const std::unique_ptr<const Dataset> itself = reader->open(directory, std::nullopt, options);
    if (const SensorCalibration* const stated = itself->calibration()) {
      resolved = CompletedBy(*stated, std::string(reader->calibration), resolved);
    }
  }
  std::unique_ptr<const Dataset> images = OpenDataset(directory, resolved.config.sensor, options);
  if (!resolved.config.imu && images->calibration() != nullptr) {
    resolved.config.imu = images->calibration()->imu;
  }
  return {std::move(images), std::move(resolved.config), std::move(resolved.origin),
          std::move(resolved.note)};
}

}  // namespace highwall::apps
