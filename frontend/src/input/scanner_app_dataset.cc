#include "input/scanner_app_dataset.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/error.h>

#include "input/numbered_files.h"
#include "input/phone_recording.h"
#include "input/scanner_app_frame.h"

namespace highwall {

namespace {

FrameList ReadScannerApp(const std::filesystem::path& folder) {
  FrameList list;
  list.shared_axis = true;
  const auto files = NumberedFiles(folder, "frame_", {".json"});
  const auto depths = NumberedFiles(folder, "depth_", {".png"});
  const auto confidences = NumberedFiles(folder, "conf_", {".png"});
  std::vector<PinholeCamera> cameras;
  Trajectory truth;
  std::size_t broken = 0;
  std::string first;
  for (const auto& [number, image] : NumberedFiles(folder, "frame_", {".jpg", ".jpeg", ".png"})) {
    const auto file = files.find(number);
    ScannerAppFrame stated;
    try {
      if (file == files.end()) throw IoError(image, "has no .json of the same number");
      stated = ReadScannerAppFrame(file->second);
    } catch (const IoError& error) {
      if (broken++ == 0) first = error.what();
      continue;
    }
    if (list.calibration_file.empty()) list.calibration_file = file->second;
    truth.push_back({stated.stamp, stated.T_WC});
    cameras.push_back(stated.camera);
    const auto depth = depths.find(number);
    if (depth == depths.end()) {
      list.without_depth.push_back(stated.stamp);
      continue;
    }
    FrameFiles frame{
        .stamp = stated.stamp, .colour = image, .depth = depth->second, .camera = stated.camera};
    const auto confidence = confidences.find(number);
    if (confidence != confidences.end()) frame.confidence = confidence->second;
    list.frames.push_back(std::move(frame));
  }
  if (cameras.empty() && broken > 0) throw IoError(folder, "no image can be used: " + first);
  if (broken > 0) {
    list.warnings.push_back(first + "; " + std::to_string(broken) + " images are not used");
  }
  if (!cameras.empty()) list.calibration = PhoneCalibration(MedianCamera(std::move(cameras)));
  std::ranges::stable_sort(truth, {}, &StampedPose::stamp);
  if (!truth.empty()) list.groundtruth = std::move(truth);
  list.imu_file = FindImuFile(folder);
  return list;
}

}  // namespace

bool ScannerAppDataset::IsOne(const std::filesystem::path& folder) {
  return HasNumberedFile(folder, "frame_", {".json"}) &&
         HasNumberedFile(folder, "depth_", {".png"});
}

ScannerAppDataset::ScannerAppDataset(const std::filesystem::path& folder,
                                     const std::optional<RgbdSensor>& sensor,
                                     const DatasetOptions& options)
    : FrameListDataset(folder, ReadScannerApp(folder), sensor, options) {}

}  // namespace highwall
