#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <opencv2/core/types.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "input/bag_calibration.h"
#include "input/bag_file.h"
#include "input/bag_topics.h"
#include "input/depth_registration.h"

namespace highwall {

// A bag of ROS 1 or ROS 2, or one that the SDK of RealSense recorded. Images are read from the file
// when they are loaded. The stamp of a frame is that of its colour image.
class BagDataset final : public Dataset {
 public:
  // sensor: as in OpenDataset(). Its depth camera, if it states none, is that of the bag; a depth
  // in metres is not divided by its factor. Throws InvalidArgument for a bad sensor or bad options,
  // and IoError if the bag or a topic cannot be read, if no colour image has a depth image in time,
  // or if no frame at all can be used.
  BagDataset(const std::filesystem::path& path, const std::optional<RgbdSensor>& sensor,
             const DatasetOptions& options);

  std::size_t size() const override { return frames_.size(); }
  Stamp stamp(std::size_t index) const override {
    return colour_.stamps[frames_.at(index).first].stamp;
  }
  Stamp depth_stamp(std::size_t index) const override {
    return depth_.stamps[frames_.at(index).second].stamp;
  }
  const Trajectory* groundtruth() const override { return nullptr; }
  std::vector<Stamp> stamps_without_depth() const override;
  std::optional<std::filesystem::path> imu_file() const override;
  ImuRecording ReadImu(const VideoSpan& video) const override;
  BagTopics topics() const override;
  bool is_registered() const override { return registration_ || calibration_.is_registered; }
  const SensorCalibration* calibration() const override {
    return calibration_.calibration ? &*calibration_.calibration : nullptr;
  }

 private:
  // The images of one topic, by ascending stamps.
  struct Stream {
    std::vector<TumImageFile> stamps;   // without paths
    std::vector<std::size_t> messages;  // of the bag, one per stamp
    std::size_t without_stamp = 0;      // images that are left out
  };

  RgbdImage DoLoad(std::size_t index) const override;
  Stream ListImages(std::uint32_t topic);
  void Pair();
  std::pair<cv::Size, cv::Size> FindSizes() const;
  void Calibrate(bool is_needed);
  void UseSensor(const std::optional<RgbdSensor>& sensor);
  void CheckDepthFactor();
  cv::Mat ReadColour(std::size_t frame) const;
  cv::Mat ReadDepth(std::size_t frame) const;
  cv::Mat Metric(const cv::Mat& stored) const;
  void RequireOneView(std::size_t frame, const cv::Mat& colour, const cv::Mat& depth) const;

  std::unique_ptr<BagFile> bag_;
  DatasetOptions options_;
  BagImageTopics images_;
  std::optional<BagImuTopics> imu_;
  bool use_recorded_ = false;  // the headers have no stamps
  Stream colour_, depth_;
  std::vector<std::pair<std::size_t, std::size_t>> frames_;  // in colour_ and depth_
  BagCalibration calibration_;
  RgbdSensor sensor_;
  std::unique_ptr<const DepthRegistration> registration_;  // null: depth has the pixels of colour
};

}  // namespace highwall
