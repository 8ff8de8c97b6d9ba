#include "input/stray_scanner_dataset.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

#include "input/matrix_text.h"
#include "input/numbered_files.h"
#include "input/phone_recording.h"
#include "input/stray_odometry.h"

namespace highwall {
namespace {

// [px] of the images that camera_matrix.csv is for.
constexpr int kStrayWidth = 1920, kStrayHeight = 1440;

PinholeCamera StrayCamera(double fx, double fy, double cx, double cy) {
  return {.width = kStrayWidth, .height = kStrayHeight, .fx = fx, .fy = fy, .cx = cx, .cy = cy};
}

// The axes of the IMU, x_B = -y_C, y_B = -x_C and z_B = -z_C, are those of the phone held upright,
// whose camera lies on its side; the distance between the two, a few centimetres, is not stated.
ImuCalibration StrayImu() {
  Eigen::Matrix4d T_BC = Eigen::Matrix4d::Zero();
  T_BC(0, 1) = T_BC(1, 0) = T_BC(2, 2) = -1.0;
  T_BC(3, 3) = 1.0;
  return {.T_BC = Pose::FromMatrix(T_BC), .rate = 100.0};
}

// Adds the images, as files or as a video.
std::map<std::int64_t, std::filesystem::path> StrayImages(const std::filesystem::path& folder,
                                                          FrameList* list) {
  auto images = NumberedFiles(folder / "rgb", "", {".png", ".jpg", ".jpeg"});
  if (!images.empty()) return images;
  const std::filesystem::path video = folder / "rgb.mp4";
  std::error_code ignored;
  if (!std::filesystem::exists(video, ignored)) {
    throw IoError(video, "is missing, and there is no folder rgb with images: copy one of them");
  }
  list->video = std::make_shared<VideoFrames>(video);
  return images;
}

FrameList ReadStrayScanner(const std::filesystem::path& folder) {
  FrameList list;
  list.shared_axis = true;
  list.assumed_size = true;
  list.calibration_file = folder / "camera_matrix.csv";
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> K =
      ReadMatrixText(list.calibration_file, 3, 3);
  const PinholeCamera stated =
      CameraOfMatrix(list.calibration_file, {K.data(), static_cast<std::size_t>(K.size())});
  PinholeCamera camera = StrayCamera(stated.fx, stated.fy, stated.cx, stated.cy);
  const std::vector<StrayPose> poses = ReadStrayOdometry(folder / "odometry.csv");
  const auto depths = NumberedFiles(folder / "depth", "", {".png"});
  const auto confidences = NumberedFiles(folder / "confidence", "", {".png"});
  const auto images = StrayImages(folder, &list);
  std::vector<PinholeCamera> cameras;
  Trajectory truth;
  for (const StrayPose& pose : poses) {
    truth.push_back({pose.stamp, pose.T_WC});
    const auto image = images.find(pose.frame);
    if (!list.video && image == images.end()) continue;
    const auto depth = depths.find(pose.frame);
    if (depth == depths.end()) {
      list.without_depth.push_back(pose.stamp);
      continue;
    }
    FrameFiles frame{.stamp = pose.stamp,
                     .number = static_cast<std::size_t>(pose.frame),
                     .depth = depth->second};
    if (!list.video) frame.colour = image->second;
    const auto confidence = confidences.find(pose.frame);
    if (confidence != confidences.end()) frame.confidence = confidence->second;
    if (pose.intrinsics) {
      const auto& [fx, fy, cx, cy] = *pose.intrinsics;
      frame.camera = StrayCamera(fx, fy, cx, cy);
      cameras.push_back(*frame.camera);
    }
    list.frames.push_back(std::move(frame));
  }
  if (!cameras.empty()) camera = MedianCamera(std::move(cameras));
  std::ranges::stable_sort(truth, {}, &StampedPose::stamp);
  list.groundtruth = std::move(truth);
  list.calibration = PhoneCalibration(camera);
  list.imu_file = FindImuFile(folder);
  if (list.imu_file) list.calibration->imu = StrayImu();
  return list;
}

}  // namespace

bool StrayScannerDataset::IsOne(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder / "odometry.csv", ignored) &&
         std::filesystem::is_directory(folder / "depth", ignored);
}

StrayScannerDataset::StrayScannerDataset(const std::filesystem::path& folder,
                                         const std::optional<RgbdSensor>& sensor,
                                         const DatasetOptions& options)
    : FrameListDataset(folder, ReadStrayScanner(folder), sensor, options) {}

}  // namespace highwall
