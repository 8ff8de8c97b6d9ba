#include "input/record3d_dataset.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <system_error>
#include <utility>

#include <highwall/core/error.h>

#include "input/numbered_files.h"
#include "input/phone_recording.h"
#include "input/record3d_metadata.h"

namespace highwall {
namespace {

// Throws IoError if there are no depth images in the one format that is read.
std::map<std::int64_t, std::filesystem::path> Record3dDepths(const std::filesystem::path& folder) {
  auto depths = NumberedFiles(folder / "depth", "", {".exr", ".png"});
  if (depths.empty()) {
    throw IoError(folder / "depth", "holds no N.exr: export the recording as EXR and RGB");
  }
  return depths;
}

FrameList ReadRecord3d(const std::filesystem::path& folder) {
  FrameList list;
  list.shared_axis = true;
  list.calibration_file = folder / "metadata.json";
  const Record3dMetadata metadata = ReadRecord3dMetadata(list.calibration_file);
  const auto depths = Record3dDepths(folder);
  Trajectory truth;
  std::size_t beyond = 0;
  for (const auto& [number, image] : NumberedFiles(folder / "rgb", "", {".png", ".jpg", ".jpeg"})) {
    const std::size_t index = static_cast<std::size_t>(number);
    if (!metadata.stamps.empty() && index >= metadata.stamps.size()) {
      ++beyond;
      continue;
    }
    const Stamp stamp = metadata.stamps.empty()
                            ? FromSeconds(static_cast<double>(number) / metadata.rate)
                            : metadata.stamps[index];
    if (index < metadata.poses.size() && metadata.poses[index]) {
      truth.push_back({stamp, *metadata.poses[index]});
    }
    const auto depth = depths.find(number);
    if (depth == depths.end()) {
      list.without_depth.push_back(stamp);
      continue;
    }
    FrameFiles frame{.stamp = stamp, .colour = image, .depth = depth->second};
    if (index < metadata.cameras.size()) frame.camera = metadata.cameras[index];
    list.frames.push_back(std::move(frame));
  }
  if (beyond > 0) {
    list.warnings.push_back(list.calibration_file.string() + ": has no stamp for " +
                            std::to_string(beyond) + " images, which are not used");
  }
  std::ranges::stable_sort(truth, {}, &StampedPose::stamp);
  if (!truth.empty()) list.groundtruth = std::move(truth);
  list.calibration =
      PhoneCalibration(metadata.cameras.empty() ? metadata.camera : MedianCamera(metadata.cameras));
  // The images of a phone held upright are those of its sensor, turned clockwise.
  RgbdSensor& sensor = list.calibration->sensor;
  if (sensor.camera.height > sensor.camera.width) {
    sensor.timing.direction = ReadoutDirection::kLeft;
  }
  list.imu_file = FindImuFile(folder);
  return list;
}

}  // namespace

bool Record3dDataset::IsOne(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(folder / "metadata.json", ignored) &&
         std::filesystem::is_directory(folder / "rgb", ignored) &&
         std::filesystem::is_directory(folder / "depth", ignored);
}

Record3dDataset::Record3dDataset(const std::filesystem::path& folder,
                                 const std::optional<RgbdSensor>& sensor,
                                 const DatasetOptions& options)
    : FrameListDataset(folder, ReadRecord3d(folder), sensor, options) {}

}  // namespace highwall
