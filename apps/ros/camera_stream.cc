#include "ros/camera_stream.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <opencv2/core/mat.hpp>

#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

constexpr std::chrono::milliseconds kImuTimeout(300);  // for readings that should have arrived
constexpr std::size_t kMostReadings = 20'000;          // that wait for an image

}  // namespace

CameraStream::CameraStream(const RgbdSensor& sensor, const CameraStreamOptions& options,
                           double imu_time_offset)
    : sensor_(sensor),
      options_(options),
      imu_time_offset_(imu_time_offset),
      pairer_(options.max_stamp_difference),
      queue_(options.queue) {}

void CameraStream::RequireSize(const cv::Mat& image) const {
  const PinholeCamera& camera = sensor_.camera;
  if (image.cols == camera.width && image.rows == camera.height) return;
  throw InvalidArgument("an image has " + std::to_string(image.cols) + " x " +
                        std::to_string(image.rows) + " pixels, the camera " +
                        std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                        ": depth must be registered to colour");
}

void CameraStream::Push(std::vector<RgbdImage> images) {
  for (RgbdImage& image : images) queue_.Push(std::move(image));
  unpaired_ = pairer_.unpaired();
  out_of_order_ = pairer_.out_of_order();
}

void CameraStream::AddColour(Stamp stamp, const cv::Mat& bgr) {
  RequireSize(bgr);
  Push(pairer_.AddColour(stamp, bgr));
}

void CameraStream::AddDepth(Stamp stamp, const cv::Mat& stored) {
  RequireSize(stored);
  const double factor = stored.depth() == CV_32F ? 1.0 : options_.depth_factor;
  Push(pairer_.AddDepth(
      stamp, MetricDepth(stored, factor, sensor_.inverse_depth_offset, sensor_.depth_pattern)));
}

void CameraStream::AddImu(const ImuSample& sample) {
  const std::lock_guard lock(mutex_);
  readings_.push_back(sample);
  if (readings_.size() > kMostReadings) readings_.pop_front();
  newest_ = std::max(sample.stamp, newest_.value_or(sample.stamp));
  imu_silent_ = false;
  changed_.notify_all();
}

void CameraStream::Close() {
  queue_.Close();
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

std::optional<RgbdImage> CameraStream::Next() {
  std::optional<RgbdImage> image = queue_.Pop();
  if (image && options_.imu_lead) WaitForImu(image->stamp);
  return image;
}

void CameraStream::WaitForImu(Stamp image) {
  const Stamp until = image + FromSeconds(imu_time_offset_ + *options_.imu_lead);
  std::unique_lock lock(mutex_);
  const auto is_there = [&] { return closed_ || imu_silent_ || (newest_ && *newest_ >= until); };
  if (!changed_.wait_for(lock, kImuTimeout, is_there)) imu_silent_ = true;
}

std::vector<ImuSample> CameraStream::TakeImu() {
  const std::lock_guard lock(mutex_);
  std::vector<ImuSample> readings(readings_.begin(), readings_.end());
  readings_.clear();
  return readings;
}

}  // namespace highwall::apps
