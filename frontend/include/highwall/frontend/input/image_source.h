#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// A camera, with an IMU if there is one: an interface for users to implement. Images have the form
// of RgbdImage, depth registered to colour, and ascending stamps. Stop() may be called from any
// thread at any time; everything else is called on one thread. LiveCamera reads a camera on a
// thread of its own, so that an implementation need not queue.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;

  // Waits for the next image; empty after the last one and, within a second, after Stop(). With an
  // IMU, it returns an image only when the readings until some 50 ms after it have arrived, or will
  // not arrive; a LiveCamera waits for them by itself. Throws IoError, which names the device and
  // what to do, if the camera fails or is silent for seconds: nothing hangs for ever.
  virtual std::optional<RgbdImage> Next() = 0;
  // Returns the readings that have arrived and were not returned before. Called after Next().
  virtual std::vector<ImuSample> TakeImu() { return {}; }
  // Ends the images: Next() returns those that wait here, and then nothing.
  virtual void Stop() = 0;

  // Calibration that the device itself states; null where another source has to.
  virtual const SensorCalibration* calibration() const { return nullptr; }
  // Number of images that wait (SlamSystem::SetBacklog).
  virtual std::size_t waiting() const { return 0; }
  // Number of images that were lost because the caller was too slow.
  virtual std::size_t dropped() const { return 0; }
  // Returns the time [ms] since the arrival of the image that Next() returned last; empty where it
  // is unknown.
  virtual std::optional<double> MillisecondsSinceArrival() const { return std::nullopt; }

 protected:
  ImageSource() = default;
};

}  // namespace highwall
