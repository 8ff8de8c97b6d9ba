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


namespace highwall {
namespace {

namespace fs = std::filesystem;

constexpr double kNearest = 0.4;          // [m]
constexpr double kDisparitySigma = 0.25;  // [px] of semi-global matching in steps of 1/16

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;  // as OpenCV stores a matrix

fs::path Root(const fs::path& directory) {
  return fs::exists(directory / "mav0") ? directory / "mav0" : directory;
}

// Parameters of one camera from its sensor.yaml.
struct StereoCamera {
  cv::Size size;
  cv::Mat K = cv::Mat::eye(3, 3, CV_64F), distortion = cv::Mat::zeros(1, 4, CV_64F);
  Pose T_BS;
};

cv::FileStorage Open(const fs::path& path) {
  if (!std::ifstream(path)) throw IoError(path, "is missing or cannot be read");
  try {
    cv::FileStorage file(path.string(), cv::FileStorage::READ);
    if (file.isOpened()) return file;
  } catch (const cv::Exception&) {  // its message names OpenCV's own sources
  }
  throw IoError(path, "is no YAML of EuRoC's form");
}

bool IsNumber(const cv::FileNode& node) {
  return (node.isInt() || node.isReal()) && std::isfinite(node.real());
}

// Checks the type, since OpenCV throws, or invents a value, for a node of another type.
std::vector<double> Numbers(const fs::path& path, const cv::FileNode& node, const char* key,
                            std::size_t count) {
  std::vector<double> numbers;
  if (node.isSeq()) {
    for (const cv::FileNode& entry : node) {
      if (IsNumber(entry)) numbers.push_back(entry.real());
    }
  }
  if (!node.isSeq() || node.size() != count || numbers.size() != count) {
    throw IoError(path, std::string(key) + " must be " + std::to_string(count) + " numbers");
  }
  return numbers;
}

std::string Text(const cv::FileNode& node) {
  return node.isString() ? node.string() : "unknown";
}

Pose ReadPose(const fs::path& path, const cv::FileStorage& file) {
  const cv::FileNode T_BS = file["T_BS"];
  if (!T_BS.isMap()) throw IoError(path, "has no T_BS with rows, cols and data");
  const std::vector<double> T = Numbers(path, T_BS["data"], "T_BS: data", 16);
  try {
    return Pose::FromMatrix(
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(T.data()));
  } catch (const InvalidArgument&) {  // the file's fault, which IoError reports
    throw IoError(path, "T_BS is no rotation and translation");
  }
}

StereoCamera ReadCamera(const fs::path& path) {
  const cv::FileStorage file = Open(path);
  const std::string model = Text(file["camera_model"]);
  const std::string distortion = Text(file["distortion_model"]);
  if (model != "pinhole" || distortion != "radial-tangential") {
    throw IoError(path, "its camera is " + model + " with " + distortion +
                            " distortion; only pinhole with radial-tangential is known");
  }
  StereoCamera camera;
  const auto size = Numbers(path, file["resolution"], "resolution", 2);
  camera.size = {static_cast<int>(size[0]), static_cast<int>(size[1])};
  const auto f = Numbers(path, file["intrinsics"], "intrinsics", 4);
  camera.K.at<double>(0, 0) = f[0];
  camera.K.at<double>(1, 1) = f[1];
  camera.K.at<double>(0, 2) = f[2];
  camera.K.at<double>(1, 2) = f[3];
  const auto d = Numbers(path, file["distortion_coefficients"], "distortion_coefficients", 4);
  for (int i = 0; i < 4; ++i) camera.distortion.at<double>(i) = d[static_cast<std::size_t>(i)];
  camera.T_BS = ReadPose(path, file);
  return camera;
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
  const cv::FileStorage file = Open(path);
  ImuCalibration imu;
  const auto read = [&](const char* key, double* value) {
    const cv::FileNode node = file[key];
    if (node.empty()) return;
    if (!IsNumber(node)) throw IoError(path, std::string(key) + " must be a number");
    *value = node.real();
  };
  read("gyroscope_noise_density", &imu.noise.gyroscope);
  read("accelerometer_noise_density", &imu.noise.accelerometer);
  read("gyroscope_random_walk", &imu.noise.gyroscope_walk);
  read("accelerometer_random_walk", &imu.noise.accelerometer_walk);
  read("rate_hz", &imu.rate);
  imu.T_BC = ReadPose(path, file).Inverse() * T_BC_;
  try {
    imu.Validate();
  } catch (const InvalidArgument& error) {  // the file's fault, which IoError reports
    throw IoError(path, error.what());
  }
  calibration_.imu = imu;
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
