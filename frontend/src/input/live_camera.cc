#include <highwall/frontend/input/live_camera.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/frontend/input/frame_queue.h>
#include <highwall/frontend/input/imu_inbox.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/run_profile.h>

#include "input/arrival_times.h"

namespace highwall {

void LiveCameraOptions::Validate() const {
  HIGHWALL_REQUIRE(queue >= 1, "LiveCameraOptions.queue must be at least 1");
  if (imu_lead && !(*imu_lead >= 0.0 && *imu_lead <= 1.0)) {
    throw InvalidArgument("LiveCameraOptions.imu_lead is " + NumberText(*imu_lead) +
                          ", must be from 0 to 1 s");
  }
  if (!(std::abs(imu_time_offset) <= 1.0)) {
    throw InvalidArgument("LiveCameraOptions.imu_time_offset is " + NumberText(imu_time_offset) +
                          ", must be from -1 to 1 s");
  }
}

class LiveCamera::Impl {
 public:
  Impl(ImageSource& camera, LiveCameraOptions options)
      : camera_(camera), options_(Checked(std::move(options))), queue_(options_.queue) {}

  // Apart from the constructor, since the thread uses all members.
  void Start() {
    thread_ = std::thread([this] {
      SetUpThread({"live camera"});
      Read();
    });
  }

  ~Impl() {
    camera_.Stop();
    if (thread_.joinable()) thread_.join();
  }

  ImageSource& camera() { return camera_; }
  const FrameQueue& queue() const { return queue_; }

  std::optional<RgbdImage> Next() {
    std::optional<RgbdImage> image = queue_.Pop();
    if (!image) {
      if (error_) std::rethrow_exception(error_);  // written before the queue was closed
      return image;
    }
    arrived_ = TakeArrival(image->stamp);
    if (options_.imu_lead) {
      readings_.WaitFor(image->stamp + FromSeconds(options_.imu_time_offset + *options_.imu_lead));
    }
    return image;
  }

  std::vector<ImuSample> TakeImu() { return readings_.Take(); }

  std::optional<double> MillisecondsSinceArrival() const {
    if (!arrived_) return std::nullopt;
    return std::chrono::duration<double, std::milli>(Clock::now() - *arrived_).count();
  }

 private:
  using Clock = ArrivalTimes::Clock;

  static LiveCameraOptions Checked(LiveCameraOptions options) {
    options.Validate();
    return options;
  }

  void Read() {
    try {
      while (std::optional<RgbdImage> image = camera_.Next()) {
        const std::vector<ImuSample> readings = camera_.TakeImu();
        if (options_.on_image) options_.on_image(*image, readings);
        readings_.Add(readings);
        {
          const std::lock_guard lock(mutex_);
          arrivals_.Add(image->stamp, Clock::now());
        }
        queue_.Push(*std::move(image));
      }
      readings_.Add(camera_.TakeImu());
    } catch (...) {
      error_ = std::current_exception();
    }
    queue_.Close();
    readings_.Close();
  }

  std::optional<Clock::time_point> TakeArrival(Stamp stamp) {
    const std::lock_guard lock(mutex_);
    return arrivals_.Take(stamp);
  }

  ImageSource& camera_;
  const LiveCameraOptions options_;
  FrameQueue queue_;
  ImuInbox readings_;
  std::exception_ptr error_;
  std::optional<Clock::time_point> arrived_;  // the last image of Next()
  std::mutex mutex_;                          // of the following
  // Of the images in the queue, the one before it, and the one that Next() has just taken.
  ArrivalTimes arrivals_{options_.queue + 2};
  std::thread thread_;
};

LiveCamera::LiveCamera(ImageSource& camera, LiveCameraOptions options)
    : impl_(std::make_unique<Impl>(camera, std::move(options))) {
  impl_->Start();
}

LiveCamera::~LiveCamera() = default;

std::optional<RgbdImage> LiveCamera::Next() {
  return impl_->Next();
}

std::vector<ImuSample> LiveCamera::TakeImu() {
  return impl_->TakeImu();
}

void LiveCamera::Stop() {
  impl_->camera().Stop();
}

const SensorCalibration* LiveCamera::calibration() const {
  return impl_->camera().calibration();
}

std::size_t LiveCamera::waiting() const {
  return impl_->queue().size();
}

std::size_t LiveCamera::dropped() const {
  return impl_->queue().dropped();
}

std::optional<double> LiveCamera::MillisecondsSinceArrival() const {
  return impl_->MillisecondsSinceArrival();
}

}  // namespace highwall
