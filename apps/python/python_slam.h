#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <highwall/frontend/system/slam_system.h>

#include "exclusive.h"
#include "followed_map.h"

namespace highwall::python {

using Mapper = Exclusive<FollowedMap>;

// SlamSystem as used from Python: it also serves the dense mappers that follow it, in addition to
// the user's callbacks.
class PythonSlam : public SlamSystem {
 public:
  PythonSlam(const RgbdSensor& sensor, const SlamOptions& options,
             const std::optional<ImuCalibration>& imu, std::shared_ptr<PointExtractor> points)
      : SlamSystem(sensor, options, {.imu = imu, .points = std::move(points)}),
        sensor_(sensor),
        has_imu_(imu.has_value()) {}
  PythonSlam(const PythonSlam&) = delete;  // its callbacks refer to it
  PythonSlam& operator=(const PythonSlam&) = delete;

  const RgbdSensor& sensor() const { return sensor_; }
  bool has_imu() const { return has_imu_; }

  // Calls SlamSystem::Track(). Followers receive the original image with each keyframe.
  FrameResult TrackImage(const RgbdImage& image);
  // Sets the user's callbacks.
  void Listen(SlamCallbacks callbacks);
  // Adds a mapper that follows from the first keyframe on, as long as it lives. Throws
  // InvalidArgument if there are keyframes already.
  void AddMapper(const std::shared_ptr<Mapper>& mapper);

 private:
  void Connect();
  // Calls use(map) for each mapper.
  template <class Use>
  void ForEachMapper(const Use& use) const {
    std::exception_ptr failure;  // the first one; the other mappers continue to follow
    for (const std::weak_ptr<Mapper>& follower : mappers_) {
      try {
        if (const auto mapper = follower.lock()) mapper->Enter(use);
      } catch (...) {
        if (!failure) failure = std::current_exception();
      }
    }
    if (failure) std::rethrow_exception(failure);
  }

  const RgbdSensor sensor_;
  const bool has_imu_;
  SlamCallbacks listener_;
  RgbdImage image_;  // the tracked image
  std::vector<std::weak_ptr<Mapper>> mappers_;
};

using Slam = Exclusive<PythonSlam>;

}  // namespace highwall::python
