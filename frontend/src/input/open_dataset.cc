#include <highwall/frontend/input/open_dataset.h>

#include <algorithm>
#include <array>
#include <string>

#include <highwall/core/error.h>
#include <highwall/frontend/input/euroc_dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "input/recording_folder.h"

namespace highwall {
namespace {

// A new format is a class derived from Dataset, and its row here.
constexpr std::array<DatasetReader, 2> kReaders{{
    {.format = "EuRoC",
     .marks = "mav0/cam0/sensor.yaml",
     .calibration = "sensor.yaml of the cameras",
     .recognizes = &EurocDataset::IsOne,
     .open = [](const std::filesystem::path& folder, const std::optional<RgbdSensor>&,
                const DatasetOptions&) -> std::unique_ptr<Dataset> {
       return std::make_unique<EurocDataset>(folder);
     }},
    {.format = "TUM RGB-D",
     .marks = "rgb.txt and depth.txt, or associations.txt",
     .calibration = "",
     .recognizes = &TumDataset::IsOne,
     .open = [](const std::filesystem::path& folder, const std::optional<RgbdSensor>& sensor,
                const DatasetOptions& options) -> std::unique_ptr<Dataset> {
       return std::make_unique<TumDataset>(folder, sensor, options);
     }},
}};

}  // namespace

std::span<const DatasetReader> DatasetReaders() {
  return kReaders;
}

const DatasetReader* FindDatasetReader(const std::filesystem::path& folder) {
  const auto found = std::ranges::find_if(
      kReaders, [&](const DatasetReader& reader) { return reader.recognizes(folder); });
  return found == kReaders.end() ? nullptr : &*found;
}

std::unique_ptr<Dataset> OpenDataset(const std::filesystem::path& folder,
                                     const std::optional<RgbdSensor>& sensor,
                                     const DatasetOptions& options) {
  RequireRecordingFolder(folder);
  if (const DatasetReader* const reader = FindDatasetReader(folder)) {
    return reader->open(folder, sensor, options);
  }
  std::string known;
  for (const DatasetReader& reader : kReaders) {
    known += (known.empty() ? "" : "; ") + std::string(reader.format) + " has " +
             std::string(reader.marks);
  }
  throw IoError(folder, "holds no recording in a known format: " + known);
}

}  // namespace highwall
