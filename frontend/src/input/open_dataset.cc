#include <highwall/frontend/input/open_dataset.h>

#include <algorithm>
#include <array>
#include <string>

#include <highwall/core/error.h>
#include <highwall/frontend/input/bag_imu.h>
#include <highwall/frontend/input/euroc_dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "input/bag_dataset.h"
#include "input/foreign_calibration.h"
#include "input/numbered_pairs_dataset.h"
#include "input/open3d_dataset.h"
#include "input/record3d_dataset.h"
#include "input/recording_folder.h"
#include "input/scanner_app_dataset.h"
#include "input/seven_scenes_dataset.h"
#include "input/stray_scanner_dataset.h"

namespace highwall {
namespace {

// Opens a format that takes a sensor and options.
template <class Format>
std::unique_ptr<Dataset> OpenAs(const std::filesystem::path& folder,
                                const std::optional<RgbdSensor>& sensor,
                                const DatasetOptions& options) {
  return std::make_unique<Format>(folder, sensor, options);
}

// A new format is a class derived from Dataset, and its row here.
constexpr std::array<DatasetReader, 9> kReaders{{
    {.format = "EuRoC",
     .marks = "mav0/cam0/sensor.yaml",
     .calibration = "sensor.yaml of the cameras",
     .fixed_camera = true,
     .recognizes = &EurocDataset::IsOne,
     .open = [](const std::filesystem::path& folder, const std::optional<RgbdSensor>&,
                const DatasetOptions&) -> std::unique_ptr<Dataset> {
       return std::make_unique<EurocDataset>(folder);
     }},
    {.format = "TUM RGB-D",
     .marks = "rgb.txt and depth.txt, or associations.txt",
     .calibration = "",
     .recognizes = &TumDataset::IsOne,
     .open = &OpenAs<TumDataset>},
    {.format = "Stray Scanner",
     .marks = "odometry.csv and depth/",
     .calibration = "camera_matrix.csv",
     .recognizes = &StrayScannerDataset::IsOne,
     .open = &OpenAs<StrayScannerDataset>},
    {.format = "3D Scanner App",
     .marks = "frame_NNNNN.json and depth_NNNNN.png",
     .calibration = "frame_NNNNN.json",
     .recognizes = &ScannerAppDataset::IsOne,
     .open = &OpenAs<ScannerAppDataset>},
    {.format = "Record3D",
     .marks = "metadata.json, rgb/ and depth/",
     .calibration = "metadata.json",
     .recognizes = &Record3dDataset::IsOne,
     .open = &OpenAs<Record3dDataset>},
    {.format = "Open3D",
     .marks = "camera_intrinsic.json or trajectory.log, color/ and depth/",
     .calibration = "camera_intrinsic.json",
     .recognizes = &Open3dDataset::IsOne,
     .open = &OpenAs<Open3dDataset>},
    {.format = "7-Scenes",
     .marks = "frame-NNNNNN.color.png and frame-NNNNNN.depth.png",
     .calibration = "camera-intrinsics.txt",
     .recognizes = &SevenScenesDataset::IsOne,
     .open = &OpenAs<SevenScenesDataset>},
    {.format = "numbered images",
     .marks = "rgb/N.png and depth/N.png",
     .calibration = "",
     .recognizes = &NumberedPairsDataset::IsOne,
     .open = &OpenAs<NumberedPairsDataset>},
    {.format = "ROS bag",
     .marks = ".db3 or .mcap, or is itself a .bag",
     .calibration = "camera_info",
     .recognizes = &IsBag,
     .open = &OpenAs<BagDataset>},
}};

SensorCalibration ReadSized(const std::filesystem::path& path, const ImageSizeSource& image_size) {
  if (auto foreign = ReadForeignCalibration(path, image_size)) return *std::move(foreign);
  return ReadSensor(path);
}

cv::Size ImageSizeOf(const std::filesystem::path& recording, const DatasetOptions& options) {
  const std::unique_ptr<const Dataset> images = OpenDataset(recording, std::nullopt, options);
  for (std::size_t i = 0; i < images->size(); ++i) {
    if (const std::optional<RgbdImage> image = images->Load(i)) return image->bgr.size();
  }
  throw IoError(recording, "none of its " + std::to_string(images->size()) +
                               " frames can be used; the first: " + images->problems().at(0).what);
}

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
  if (!IsBag(folder)) RequireRecordingFolder(folder);
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

SensorCalibration ReadSensor(const std::filesystem::path& path,
                             const std::filesystem::path& recording,
                             const DatasetOptions& options) {
  return ReadSized(path, [&] { return ImageSizeOf(recording, options); });
}

SensorCalibration ReadSensor(const std::filesystem::path& path, const cv::Size& image_size) {
  return ReadSized(path, [&] { return image_size; });
}

}  // namespace highwall
