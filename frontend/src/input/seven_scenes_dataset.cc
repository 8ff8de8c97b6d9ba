#include "input/seven_scenes_dataset.h"

#include <string>
#include <string_view>
#include <system_error>

#include <Eigen/Core>

#include <highwall/core/error.h>

#include "input/matrix_text.h"
#include "input/numbered_files.h"
#include "input/numbered_frames.h"

namespace highwall {
namespace {

constexpr double kSevenScenesDepthFactor = 1000.0;  // millimetres

// Returns the path of frame-NNNNNN.pose.txt beside the depth image.
std::filesystem::path PoseFileOf(const std::filesystem::path& depth) {
  constexpr std::string_view kSuffix = ".depth.png";
  std::string name = depth.string();
  name.resize(name.size() - kSuffix.size());
  return name + ".pose.txt";
}

Pose ReadSevenScenesPose(const std::filesystem::path& path) {
  try {
    return Pose::FromMatrix(ReadMatrixText(path, 4, 4));
  } catch (const InvalidArgument&) {  // the file's fault, which IoError reports
    throw IoError(path, "is no rotation and translation");
  }
}

// Frames whose pose is missing or none have none: tracking that was lost writes nan or zeros.
void ReadSevenScenesPoses(FrameList* list) {
  Trajectory truth;
  std::size_t broken = 0;
  std::string first;
  std::error_code ignored;
  for (const FrameFiles& frame : list->frames) {
    const std::filesystem::path path = PoseFileOf(frame.depth);
    if (!std::filesystem::exists(path, ignored)) continue;
    try {
      truth.push_back({frame.stamp, ReadSevenScenesPose(path)});
    } catch (const IoError& error) {
      if (broken++ == 0) first = error.what();
    }
  }
  if (broken > 0) {
    list->warnings.push_back(first + "; " + std::to_string(broken) + " of " +
                             std::to_string(list->frames.size()) + " reference poses are not used");
  }
  if (!truth.empty()) list->groundtruth = std::move(truth);
}

FrameList ReadSevenScenes(const std::filesystem::path& folder, const DatasetOptions& options) {
  FrameList list =
      PairNumberedImages(folder, NumberedFiles(folder, "frame-", {".color.png", ".color.jpg"}),
                         NumberedFiles(folder, "frame-", {".depth.png"}), options);
  std::error_code ignored;
  const std::filesystem::path name = "camera-intrinsics.txt";
  const std::filesystem::path above = std::filesystem::absolute(folder, ignored) / ".." / name;
  for (const std::filesystem::path& path : {folder / name, above}) {
    if (!std::filesystem::is_regular_file(path, ignored)) continue;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> K = ReadMatrixText(path, 3, 3);
    list.calibration_file = path;
    list.calibration.emplace().sensor.camera =
        CameraOfMatrix(path, {K.data(), static_cast<std::size_t>(K.size())});
    list.calibration->sensor.depth_factor = kSevenScenesDepthFactor;
    break;
  }
  list.imu_file = FindImuFile(folder);
  ReadSevenScenesPoses(&list);
  return list;
}

}  // namespace

bool SevenScenesDataset::IsOne(const std::filesystem::path& folder) {
  return HasNumberedFile(folder, "frame-", {".color.png", ".color.jpg"}) &&
         HasNumberedFile(folder, "frame-", {".depth.png"});
}

SevenScenesDataset::SevenScenesDataset(const std::filesystem::path& folder,
                                       const std::optional<RgbdSensor>& sensor,
                                       const DatasetOptions& options)
    : FrameListDataset(folder, ReadSevenScenes(folder, options), sensor, options) {}

}  // namespace highwall
