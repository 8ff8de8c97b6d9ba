#include "run/opened_dataset.h"

#include <highwall/core/error.h>
#include <highwall/frontend/input/euroc_dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "cli/did_you_mean.h"

namespace highwall::apps {

OpenedDataset OpenDataset(const std::string& choice, const std::filesystem::path& directory,
                          double max_pair_difference) {
  if (!std::filesystem::exists(directory)) {
    throw IoError(directory, "does not exist" + DidYouMeanPath(directory));
  }
  if (EurocDataset::IsOne(directory)) {
    if (!choice.empty()) {
      throw IoError(directory,
                    "is of EuRoC's layout, whose calibration is in its sensor.yaml: "
                    "leave --config out");
    }
    auto images = std::make_unique<EurocDataset>(directory);
    RunConfig config{.sensor = images->sensor(), .imu = images->imu()};
    return {std::move(images), std::move(config), "sensor.yaml of the cameras"};
  }
  ResolvedConfig resolved = ResolveConfig(choice, directory);
  std::unique_ptr<const Dataset> images =
      OpenImages(directory, resolved.config.sensor, max_pair_difference);
  return {std::move(images), std::move(resolved.config), std::move(resolved.origin)};
}

std::unique_ptr<const Dataset> OpenImages(const std::filesystem::path& directory,
                                          const RgbdSensor& sensor, double max_pair_difference) {
  if (EurocDataset::IsOne(directory)) return std::make_unique<EurocDataset>(directory);
  return std::make_unique<TumDataset>(directory, sensor,
                                      DatasetOptions{.max_stamp_difference = max_pair_difference});
}

}  // namespace highwall::apps
