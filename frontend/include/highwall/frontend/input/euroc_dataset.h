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

// A recording as EuRoC lays it out: mav0/cam0, cam1 and imu0 with data.csv and sensor.yaml, and
// state_groundtruth_estimate0 where it is there. A frame is the left image, rectified, with depth
// by semi-global matching of the right one; its stamp is theirs. Pinhole cameras with
// radial-tangential distortion.
// Source: Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 35(10), 2016; matching:
// Hirschmueller, PAMI 30(2), 2008, by OpenCV.
class EurocDataset final : public Dataset {
 public:
  // Whether there is a cam0/sensor.yaml in the folder, or in mav0 below it.
  static bool IsOne(const std::filesystem::path& directory);

  // Throws IoError naming the file where one is missing or malformed, where the cameras' model is
  // another, and where no images of both cameras share a stamp.
  explicit EurocDataset(const std::filesystem::path& directory);

  std::size_t size() const override { return frames_.size(); }
  Stamp stamp(std::size_t index) const override { return frames_.at(index).stamp; }
  const Trajectory* groundtruth() const override { return groundtruth_ ? &*groundtruth_ : nullptr; }
  std::vector<Stamp> stamps_without_depth() const override { return without_depth_; }
  std::optional<std::filesystem::path> imu_file() const override { return imu_file_; }

  // The rectified left camera, and the noise of a depth whose disparity is off by a quarter of a
  // pixel.
  const RgbdSensor& sensor() const { return sensor_; }
  // T_BC of the rectified camera; densities of imu0/sensor.yaml. Empty without an IMU.
  const std::optional<ImuCalibration>& imu() const { return imu_; }

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
  RgbdSensor sensor_;
  std::optional<ImuCalibration> imu_;
  Pose T_BC_;                            // of the rectified left camera
  double focal_baseline_ = 0.0;          // [px m]
  int disparities_ = 0;                  // [px] that are tried
  std::pair<cv::Mat, cv::Mat> maps_[2];  // of undistorting and rectifying, left and right
};

}  // namespace highwall
