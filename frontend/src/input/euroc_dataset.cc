#include <highwall/frontend/input/euroc_dataset.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <string>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/image_io.h>
#include <highwall/internal/text_file.h>

#include "input/euroc_sensor.h"
#include "input/opencv_storage.h"

namespace highwall {
namespace {

namespace fs = std::filesystem;

constexpr double kNearest = 0.4;          // [m]
constexpr double kDisparitySigma = 0.25;  // [px] of semi-global matching in steps of 1/16

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;  // as OpenCV stores a matrix

fs::path Root(const fs::path& directory) {
  return fs::exists(directory / "mav0") ? directory / "mav0" : directory;
}

// One camera of the pair.
struct StereoCamera {
  cv::Size size;
  cv::Mat K, distortion;
  Pose T_BS;
};

ForeignMap Open(const fs::path& path) {
  return ParseOpencvStorage(path, ReadTextFile(path));
}

StereoCamera ReadCamera(const fs::path& path) {
  const ForeignMap file = Open(path);
  const PinholeCamera camera = ReadEurocCamera(file);
  if (camera.lens != LensModel::kRadialTangential) {
    file.Fail("distortion_model",
              "of a stereo pair only pinhole with radial-tangential is known, not equidistant");
  }
  return {{camera.width, camera.height},
          cv::Mat(cv::Matx33d(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1)),
          cv::Mat(cv::Matx14d(camera.k1, camera.k2, camera.p1, camera.p2)),
          ReadEurocPose(file)};
}

// Reads data.csv: a stamp in nanoseconds and the rest of the line.
std::map<Stamp, std::string> ReadList(const fs::path& path) {
  std::ifstream stream(path);
  if (!stream) throw IoError(path, "is missing or cannot be read");
  std::map<Stamp, std::string> lines;
  std::string line;
  for (std::int64_t number = 1; std::getline(stream, line); ++number) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    Stamp stamp = 0;
    const char* const end = line.data() + line.size();
    const auto parsed = std::from_chars(line.data(), end, stamp);
    if (parsed.ec != std::errc() || parsed.ptr == end || *parsed.ptr != ',') {
      throw IoError(path, number, "expected a stamp in nanoseconds, a comma, and more");
    }
    lines[stamp] = std::string(parsed.ptr + 1, end);
  }
  return lines;
}

// Returns T_WC from state_groundtruth_estimate0, which contains T_WB.
Trajectory ReadCameraPoses(const fs::path& path, const Pose& T_BC) {
  Trajectory truth;
  for (const auto& [stamp, line] : ReadList(path)) {
    std::array<double, 7> v{};  // p, then q as w x y z
    const char* at = line.data();
    const char* const end = at + line.size();
    for (double& value : v) {
      const auto parsed = std::from_chars(at, end, value);
      if (parsed.ec != std::errc()) throw IoError(path, "a line has fewer than eight numbers");
      at = parsed.ptr == end ? end : parsed.ptr + 1;
    }
    const Eigen::Quaterniond q_WB(v[3], v[4], v[5], v[6]);
    const bool finite = std::ranges::all_of(v, [](double value) { return std::isfinite(value); });
    if (!finite || !(q_WB.norm() > 1e-6) || !std::isfinite(q_WB.norm())) {
      throw IoError(path, "a pose is not finite, or its quaternion is zero");
    }
    const Pose T_WB(q_WB.normalized(), {v[0], v[1], v[2]});
    truth.push_back({stamp, T_WB * T_BC});
  }
  if (truth.empty()) throw IoError(path, "holds no pose");
  return truth;
}

}  // namespace

bool EurocDataset::IsOne(const std::filesystem::path& directory) {
  std::error_code ignored;
  return fs::is_regular_file(Root(directory) / "cam0" / "sensor.yaml", ignored);
}

EurocDataset::EurocDataset(const std::filesystem::path& directory) : root_(Root(directory)) {
  const auto left = ReadList(root_ / "cam0" / "data.csv");
  const auto right = ReadList(root_ / "cam1" / "data.csv");
  for (const auto& [stamp, file] : left) {
    const auto other = right.find(stamp);
    if (other == right.end()) {
      without_depth_.push_back(stamp);
      continue;
    }
    frames_.push_back(
        {stamp, root_ / "cam0" / "data" / file, root_ / "cam1" / "data" / other->second});
  }
  if (frames_.empty()) {
    throw IoError(root_, "no images of cam0 and cam1 share a stamp");
  }
  if (frames_.size() < left.size()) {
    AddWarning(root_.string() + ": " + std::to_string(left.size() - frames_.size()) + " of " +
               std::to_string(left.size()) + " images of cam0 have no image of cam1");
  }
  Rectify();
  ReadImuSensor();
  ReadGroundTruth();
}

void EurocDataset::Rectify() {
  const fs::path file = root_ / "cam1" / "sensor.yaml";
  const StereoCamera left = ReadCamera(root_ / "cam0" / "sensor.yaml"), right = ReadCamera(file);
  if (left.size != right.size) throw IoError(file, "its resolution is not that of cam0");
  const Pose T_RL = right.T_BS.Inverse() * left.T_BS;
  const Eigen::Vector3d p = T_RL.p();
  cv::Mat R1, R2, P1, P2, Q;
  cv::stereoRectify(left.K, left.distortion, right.K, right.distortion, left.size,
                    cv::Matx33d(RowMajor3(T_RL.R()).data()),
                    cv::Mat(cv::Vec3d(p.x(), p.y(), p.z())), R1, R2, P1, P2, Q,
                    cv::CALIB_ZERO_DISPARITY, 0.0);
  const double focal = P1.at<double>(0, 0);
  focal_baseline_ = -P2.at<double>(0, 3);
  if (!(focal_baseline_ > 0.0)) throw IoError(file, "cam1 does not lie to the right of cam0");
  cv::initUndistortRectifyMap(left.K, left.distortion, R1, P1, left.size, CV_16SC2, maps_[0].first,
                              maps_[0].second);
  cv::initUndistortRectifyMap(right.K, right.distortion, R2, P2, right.size, CV_16SC2,
                              maps_[1].first, maps_[1].second);
  T_BC_ = left.T_BS * Pose(Eigen::Quaterniond(Eigen::Map<const RowMajor3>(R1.ptr<double>())),
                           Eigen::Vector3d::Zero())
                          .Inverse();
  disparities_ =
      std::clamp(16 * static_cast<int>(std::ceil(focal_baseline_ / kNearest / 16.0)), 32, 256);
  RgbdSensor& sensor = calibration_.sensor;
  sensor.camera = {.width = left.size.width,
                   .height = left.size.height,
                   .fx = focal,
                   .fy = P1.at<double>(1, 1),
                   .cx = P1.at<double>(0, 2),
                   .cy = P1.at<double>(1, 2)};
  sensor.depth_noise = DepthNoise::Stereo(kDisparitySigma, focal, focal_baseline_ / focal);
  sensor.min_depth = focal_baseline_ / disparities_;
  sensor.Validate();
}

void EurocDataset::ReadImuSensor() {
  const fs::path path = root_ / "imu0" / "sensor.yaml";
  imu_file_ = FindImuFile(root_);
  if (!imu_file_ || !fs::exists(path)) return;
  calibration_.imu = ReadEurocImu(Open(path), T_BC_);
}

void EurocDataset::ReadGroundTruth() {
  const fs::path path = root_ / "state_groundtruth_estimate0" / "data.csv";
  if (!fs::exists(path)) return;
  try {
    groundtruth_ = ReadCameraPoses(path, T_BC_);
  } catch (const IoError& broken) {
    AddWarning(WithoutGroundTruth(broken));
  }
}

cv::Mat EurocDataset::Rectified(const std::filesystem::path& file, int camera) const {
  const cv::Mat raw = ReadGreyImage(file);
  if (raw.cols != sensor().camera.width || raw.rows != sensor().camera.height) {
    throw IoError(file, "is not of the resolution in sensor.yaml");
  }
  cv::Mat rectified;
  cv::remap(raw, rectified, maps_[camera].first, maps_[camera].second, cv::INTER_LINEAR);
  return rectified;
}

RgbdImage EurocDataset::DoLoad(std::size_t index) const {
  const StereoFrame& frame = frames_.at(index);
  const cv::Mat left = Rectified(frame.left, 0), right = Rectified(frame.right, 1);
  constexpr int kBlock = 5;  // [px]
  // Penalties as in OpenCV's manual; the rest rejects ambiguous and isolated disparities.
  const auto matcher =
      cv::StereoSGBM::create(0, disparities_, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock, 1,
                             31, 10, 100, 2, cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat disparity;
  matcher->compute(left, right, disparity);
  RgbdImage image;
  image.stamp = frame.stamp;
  cv::cvtColor(left, image.bgr, cv::COLOR_GRAY2BGR);
  image.depth = cv::Mat::zeros(left.size(), CV_32FC1);
  constexpr float kSteps = 16.0f;  // per pixel
  for (int v = 0; v < left.rows; ++v) {
    const short* const d = disparity.ptr<short>(v);
    float* const z = image.depth.ptr<float>(v);
    for (int u = 0; u < left.cols; ++u) {
      if (d[u] > 0) z[u] = static_cast<float>(focal_baseline_) * kSteps / static_cast<float>(d[u]);
    }
  }
  return image;
}

}  // namespace highwall
