#pragma once

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// A recording in the EuRoC layout: mav0/cam0, cam1 and imu0 with data.csv and sensor.yaml, and
// state_groundtruth_estimate0 where it exists. A frame is the rectified left image, with depth by
// semi-global matching against the right one; its stamp is that of both. Pinhole cameras with
// radial-tangential distortion.
// Source: Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 35(10), 2016; matching:
// Hirschmueller, PAMI 30(2), 2008, by OpenCV.
class EurocDataset final : public Dataset {
 public:
  // Returns whether the folder, or mav0 below it, contains cam0/sensor.yaml.
  static bool IsOne(const std::filesystem::path& directory);

  // Throws IoError naming the file if one is missing or malformed, if the camera model is another
  // one, and if no images of the two cameras share a stamp.
  explicit EurocDataset(const std::filesystem::path& directory);

  std::size_t size() const override { return frames_.size(); }
  Stamp stamp(std::size_t index) const override { return frames_.at(index).stamp; }
  const Trajectory* groundtruth() const override { return groundtruth_ ? &*groundtruth_ : nullptr; }
  std::vector<Stamp> stamps_without_depth() const override { return without_depth_; }
  std::optional<std::filesystem::path> imu_file() const override { return imu_file_; }

  const SensorCalibration* calibration() const override { return &calibration_; }

  // The rectified left camera, and the depth noise of a disparity error of a quarter of a pixel.
  const RgbdSensor& sensor() const { return calibration_.sensor; }
  // T_BC of the rectified camera; densities of imu0/sensor.yaml. Empty without an IMU.
  const std::optional<ImuCalibration>& imu() const { return calibration_.imu; }

 private:
  struct StereoFrame {
    Stamp stamp = 0;
    std::filesystem::path left, right;
  };

  RgbdImage DoLoad(std::size_t index) const override;
  void Rectify();
  void ReadImuSensor();
  void ReadGroundTruth();
  cv::Mat Rectified(const std::filesystem::path& file, int camera) const;

  std::filesystem::path root_;  // mav0
  std::vector<StereoFrame> frames_;
  std::vector<Stamp> without_depth_;  // left images without a right one
  std::optional<std::filesystem::path> imu_file_;
  std::optional<Trajectory> groundtruth_;
  SensorCalibration calibration_;
  Pose T_BC_;                            // of the rectified left camera
  double focal_baseline_ = 0.0;          // [px m]
  int disparities_ = 0;                  // [px] search range
  std::pair<cv::Mat, cv::Mat> maps_[2];  // undistortion and rectification, left and right
};

}  // namespace highwall
