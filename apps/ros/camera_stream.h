#pragma once

#include <atomic>
#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/frontend/input/frame_queue.h>
#include <highwall/frontend/input/image_pairer.h>
#include <highwall/frontend/input/image_source.h>
#include <highwall/frontend/input/imu_inbox.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

struct CameraStreamOptions {
  double max_stamp_difference = DatasetOptions().max_stamp_difference;  // [s] > 0
  std::size_t queue = 2;         // >= 1 images that may wait for tracking
  double depth_factor = 1000.0;  // [1/m] > 0, of depth that is stored as whole numbers
  // [s] >= 0: an image waits for the readings until this time after it, in the clock of the images;
  // empty: there is no IMU.
  std::optional<double> imu_lead{};
};

// The camera of a run whose images and readings arrive on another thread: Add...() are called there
// and only hand on, the others on the thread of the run.
class CameraStream final : public ImageSource {
 public:
  CameraStream(const RgbdSensor& sensor, const CameraStreamOptions& options,
               double imu_time_offset = 0.0);

  // bgr: CV_8UC3. stored: CV_16UC1 or CV_32FC1 [m]. Throws InvalidArgument for an image of another
  // size than the camera.
  void AddColour(Stamp stamp, const cv::Mat& bgr);
  void AddDepth(Stamp stamp, const cv::Mat& stored);
  void AddImu(const ImuSample& sample);

  std::optional<RgbdImage> Next() override;
  std::vector<ImuSample> TakeImu() override { return readings_.Take(); }
  // Ends the run after the images that wait.
  void Stop() override;
  std::size_t waiting() const override { return queue_.size(); }
  std::size_t dropped() const override { return queue_.dropped(); }
  // Number of colour images without a depth image in time.
  std::size_t unpaired() const { return unpaired_; }
  std::size_t out_of_order() const { return out_of_order_; }

 private:
  void RequireSize(const cv::Mat& image) const;
  void Push(std::vector<RgbdImage> images);

  const RgbdSensor sensor_;
  const CameraStreamOptions options_;
  const double imu_time_offset_;  // [s]
  ImagePairer pairer_;            // of the thread that adds
  FrameQueue queue_;
  std::atomic<std::size_t> unpaired_ = 0, out_of_order_ = 0;
  ImuInbox readings_;
};

}  // namespace highwall::apps
