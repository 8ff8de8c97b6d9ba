#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/sensor.h>

#include "sensor/imu_hypotheses.h"

namespace highwall {

// Judges the configuration of the IMU by the images of the last seconds, about once a second.
class ImuMonitor {
 public:
  static constexpr double kMonitored = 10.0;  // [s] of images

  explicit ImuMonitor(double max_step) : max_step_(max_step) {}

  // Adds the pose of an image; stamp [ns] of the camera's clock, ascending.
  void Add(Stamp stamp, const Pose& T_WC);
  // Leaves out the poses around these stamps [ns, camera's clock], ascending, between which an
  // image contradicted the readings: a shock to the sensor is no fault of the configuration. Poses
  // are not left out where that lasts for longer than a shock, or if they are more than a fifth (a
  // wrong configuration is contradicted as long as the camera moves), or if without them nothing
  // can be said and a single fault explains them.
  void LeaveOut(Stamp from, Stamp to);
  // Transforms the poses with the map by T_new_old in W.
  void MoveMap(const Pose& T_new_old);
  void Clear();

  // Returns a judgement if one is due at this image. is_confirmed: the configuration is, and is
  // judged less often.
  std::optional<ImuJudgement> Check(Stamp image, const ImuBuffer& readings,
                                    const ImuCalibration& calibration, bool is_confirmed);

 private:
  // Returns the poses that are not left out.
  Trajectory Trusted() const;

  double max_step_;
  Trajectory poses_;
  std::vector<std::pair<Stamp, Stamp>> contradicted_;
  std::optional<Stamp> last_check_;
};

}  // namespace highwall
