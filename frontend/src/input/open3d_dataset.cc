#include "input/open3d_dataset.h"

#include <algorithm>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <highwall/core/error.h>

#include "input/numbered_files.h"
#include "input/numbered_frames.h"
#include "input/open3d_intrinsic.h"
#include "input/trajectory_log.h"

namespace highwall {
namespace {

std::filesystem::path Open3dColour(const std::filesystem::path& folder) {
  std::error_code ignored;
  const bool color = std::filesystem::is_directory(folder / "color", ignored);
  return folder / (color ? "color" : "image");
}

std::optional<std::filesystem::path> Open3dIntrinsic(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const char* name : {"camera_intrinsic.json", "intrinsic.json"}) {
    if (std::filesystem::is_regular_file(folder / name, ignored)) return folder / name;
  }
  return std::nullopt;
}

// The poses of trajectory.log count the colour images.
Trajectory PosesOfLog(const std::filesystem::path& path, const FrameList& list) {
  std::vector<Stamp> stamps = list.without_depth;
  for (const FrameFiles& frame : list.frames) stamps.push_back(frame.stamp);
  std::ranges::sort(stamps);
  Trajectory truth;
  for (const LoggedPose& logged : ReadTrajectoryLog(path)) {
    if (logged.frame < stamps.size()) truth.push_back({stamps[logged.frame], logged.T_WC});
  }
  if (truth.empty()) throw IoError(path, "has no pose of an image");
  std::ranges::stable_sort(truth, {}, &StampedPose::stamp);
  return truth;
}

FrameList ReadOpen3d(const std::filesystem::path& folder, const DatasetOptions& options) {
  FrameList list =
      PairNumberedImages(folder, NumberedFiles(Open3dColour(folder), "", {".png", ".jpg", ".jpeg"}),
                         NumberedFiles(folder / "depth", "", {".png"}), options);
  if (const auto intrinsic = Open3dIntrinsic(folder)) {
    list.calibration_file = *intrinsic;
    list.calibration = ReadOpen3dIntrinsic(*intrinsic);
  }
  list.imu_file = FindImuFile(folder);
  const std::filesystem::path log = folder / "trajectory.log";
  std::error_code ignored;
  if (!std::filesystem::exists(log, ignored)) return list;
  try {
    list.groundtruth = PosesOfLog(log, list);
  } catch (const IoError& broken) {
    list.warnings.push_back(WithoutReference(broken));
  }
  return list;
}

}  // namespace

bool Open3dDataset::IsOne(const std::filesystem::path& folder) {
  std::error_code ignored;
  return (Open3dIntrinsic(folder) || std::filesystem::exists(folder / "trajectory.log", ignored)) &&
         HasNumberedFile(Open3dColour(folder), "", {".png", ".jpg", ".jpeg"}) &&
         std::filesystem::is_directory(folder / "depth", ignored);
}

Open3dDataset::Open3dDataset(const std::filesystem::path& folder,
                             const std::optional<RgbdSensor>& sensor, const DatasetOptions& options)
    : FrameListDataset(folder, ReadOpen3d(folder, options), sensor, options) {}

}  // namespace highwall
