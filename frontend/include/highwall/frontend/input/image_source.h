#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>

namespace [[gnu::visibility("default")]] highwall {

// A camera, with an IMU if there is one: an interface for users to implement. Images have the form
// of RgbdImage, depth registered to colour, and ascending stamps. Called on one thread.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;

  // Waits for the next image; empty after the last one. With an IMU, it returns an image only when
  // the readings until some 50 ms after it have arrived, or will not arrive.
  virtual std::optional<RgbdImage> Next() = 0;
  // Returns the readings that have arrived and were not returned before. Called after Next().
  virtual std::vector<ImuSample> TakeImu() { return {}; }
  // Number of images that wait (SlamSystem::SetBacklog).
  virtual std::size_t waiting() const { return 0; }
  // Number of images that were lost because the caller was too slow.
  virtual std::size_t dropped() const { return 0; }

 protected:
  ImageSource() = default;
};

}  // namespace highwall
