#include "ros/camera_stream.h"

#include <string>
#include <utility>

#include <opencv2/core/mat.hpp>

#include <highwall/core/error.h>

namespace highwall::apps {

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
  readings_.Add({&sample, 1});
}

void CameraStream::Stop() {
  queue_.Close();
  readings_.Close();
}

std::optional<RgbdImage> CameraStream::Next() {
  std::optional<RgbdImage> image = queue_.Pop();
  if (image && options_.imu_lead) {
    readings_.WaitFor(image->stamp + FromSeconds(imu_time_offset_ + *options_.imu_lead));
  }
  return image;
}

}  // namespace highwall::apps
