#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// The reader of one format of recordings.
struct DatasetReader {
  std::string_view format;       // such as "TUM RGB-D"
  std::string_view marks;        // human-readable: the files that a folder is recognized by
  std::string_view calibration;  // human-readable: where Dataset::calibration() is from; else empty
  // Whether that calibration cannot be replaced by another, because the frames are computed with
  // it.
  bool fixed_camera = false;
  bool (*recognizes)(const std::filesystem::path& folder);
  // Parameters and exceptions are those of OpenDataset().
  std::unique_ptr<Dataset> (*open)(const std::filesystem::path& folder,
                                   const std::optional<RgbdSensor>& sensor,
                                   const DatasetOptions& options);
};

// All readers, in the order in which they are asked: EuRoC, TUM RGB-D, and the formats of
// docs/recordings.md. A folder is a file where the format is one: a bag of ROS.
std::span<const DatasetReader> DatasetReaders();

// Returns the first reader that recognizes the folder; null if none does.
const DatasetReader* FindDatasetReader(const std::filesystem::path& folder);

// Opens a recording in any format that DatasetReaders() lists. sensor: the camera of a recording
// that does not state its own (Dataset::calibration()) or, unless DatasetReader::fixed_camera, the
// one to use in its place; empty if it is unknown: the images are then of any size, and their depth
// is converted as the recording states, or by the depth factor of the benchmark. Throws
// InvalidArgument for a bad sensor or bad options; IoError if there is no such folder, if no reader
// recognizes it, naming the files that were looked for, and as the reader does.
std::unique_ptr<Dataset> OpenDataset(const std::filesystem::path& folder,
                                     const std::optional<RgbdSensor>& sensor = std::nullopt,
                                     const DatasetOptions& options = {});

// Reads the calibration of a recording as ReadSensor(path). Where the file does not state the size
// of the images, as a settings file of ORB-SLAM2, it is that of the images of the recording, which
// is opened for it. Throws as ReadSensor() and, if that is necessary, as OpenDataset().
SensorCalibration ReadSensor(const std::filesystem::path& path,
                             const std::filesystem::path& recording,
                             const DatasetOptions& options = {});
// As above, of a camera that delivers images of this size [px].
SensorCalibration ReadSensor(const std::filesystem::path& path, const cv::Size& image_size);

}  // namespace highwall
