#include "run/opened_dataset.h"

#include <utility>

#include <highwall/core/error.h>
#include <highwall/internal/did_you_mean.h>

namespace highwall::apps {

OpenedDataset OpenWithConfig(const std::string& choice, const std::filesystem::path& directory,
                             double max_pair_difference) {
  if (!std::filesystem::exists(directory)) {
    throw IoError(directory, "does not exist" + DidYouMeanPath(directory));
  }
  const DatasetOptions options{.max_stamp_difference = max_pair_difference};
  const DatasetReader* const reader = FindDatasetReader(directory);
  if (reader != nullptr && !reader->calibration.empty()) {
    if (!choice.empty()) {
      throw IoError(directory, "is of " + std::string(reader->format) +
                                   "'s layout, whose calibration is in " +
                                   std::string(reader->calibration) + ": leave --config out");
    }
    std::unique_ptr<const Dataset> images = reader->open(directory, std::nullopt, options);
    RunConfig config = *images->calibration();
    return {std::move(images), std::move(config), std::string(reader->calibration)};
  }
  ResolvedConfig resolved = ResolveConfig(choice, directory);
  std::unique_ptr<const Dataset> images = OpenDataset(directory, resolved.config.sensor, options);
  return {std::move(images), std::move(resolved.config), std::move(resolved.origin)};
}

}  // namespace highwall::apps
