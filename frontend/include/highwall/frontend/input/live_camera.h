#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <highwall/frontend/input/image_source.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of a LiveCamera.
struct LiveCameraOptions {
  std::size_t queue = 2;  // >= 1 images that may wait for the consumer
  // [s] >= 0: an image waits for the readings until this time after it, in the clock of the images,
  // but not for an IMU that has fallen silent; empty: there is no IMU.
  std::optional<double> imu_lead{};
  double imu_time_offset = 0.0;  // [s] ImuCalibration::time_offset
  // Called on the thread of the camera for each image before it is queued, also for those that are
  // dropped later, with the readings since the last one. It must not change the image, should
  // return soon, and must not throw; empty: never.
  std::function<void(const RgbdImage& image, std::span<const ImuSample> readings)> on_image{};

  void Validate() const;  // throws InvalidArgument naming the field and its value
};

// Reads a camera on a thread of its own into a short queue, so that a consumer that is slower than
// the camera sees recent images: one that arrives at a full queue replaces the oldest, because
// tracking needs the present more than the past. The images that are left out are counted.
class LiveCamera final : public ImageSource {
 public:
  // camera: must outlive this object; nobody else may read it. Throws InvalidArgument for bad
  // options.
  explicit LiveCamera(ImageSource& camera, LiveCameraOptions options = {});
  // Stops the camera and waits for its thread.
  ~LiveCamera() override;

  // As ImageSource. Next() rethrows what ended the camera, after the images before it.
  std::optional<RgbdImage> Next() override;
  std::vector<ImuSample> TakeImu() override;
  void Stop() override;
  const SensorCalibration* calibration() const override;
  std::size_t waiting() const override;
  std::size_t dropped() const override;
  std::optional<double> MillisecondsSinceArrival() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
