#pragma once

#include <functional>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/inertial/visual_pose.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/seen_landmarks.h>
#include <highwall/frontend/pose/pose_constraint.h>

namespace [[gnu::visibility("default")]] highwall {

class RunProfile;

// Fuses the map observations of images with an IMU: initialization, a sliding window of states, the
// weight of the IMU, the time offset, dead reckoning while images give no pose.
//
//   for each image:
//     AddSample() all readings until some 50 ms after it
//     Predict()   the pose of the camera
//     Update()    with the observation of the image, if any
//     T_WC()      the fused pose
//
// States are expressed in a fixed frame O whose z axis points up by the gravity estimate of the
// initialization. The map's frame W moves with respect to O when the map is corrected (MoveMap), by
// a rotation about the vertical and a translation, and when gravity is aligned again.
class InertialOdometry {
 public:
  // model: of the camera; without one, images are poses whatever the options. background: the
  // tightly coupled smoother is on a thread of its own; otherwise Update() waits for it, and the
  // same input gives the same result. profile: see SlamInputs. Throws InvalidArgument on bad
  // options.
  explicit InertialOdometry(const ImuCalibration& calibration, const InertialOptions& options = {},
                            const std::optional<MeasurementModel>& model = std::nullopt,
                            bool background = true, RunProfile* profile = nullptr);

  ~InertialOdometry();
  InertialOdometry(InertialOdometry&&) noexcept;
  InertialOdometry& operator=(InertialOdometry&&) noexcept;

  ImuSampleStatus AddSample(const ImuSample& sample);

  // Returns the unit vector in C that points up, from the mean accelerometer reading over the
  // second before an image: valid for a camera at rest or in calm motion. Empty without readings.
  std::optional<Eigen::Vector3d> UpInCamera(Stamp image) const;

  // Returns the pose of the camera predicted by the IMU; empty before the initialization, without
  // readings, and after dead reckoning for too long.
  std::optional<PoseConstraint> Predict(Stamp image) const;

  // Observation of an image at its stamp [ns, camera's clock].
  struct Observation {
    Stamp image = 0;
    std::optional<VisualPose> visual;  // in W
    // Returns the observations behind `visual`, for the tightly coupled smoother, which calls this
    // only for some images.
    std::function<SeenLandmarks()> see;
    double sharpness = 1.0;  // MotionMeasures
    double tracked_share = 1.0;
    bool keeps_level = false;  // no gravity alignment of the map now: InertialReport::T_gravity
  };
  InertialReport Update(const Observation& observation);

  // Follows the map, which was transformed by T_new_old in W at the camera's current place.
  void MoveMap(const Pose& T_new_old);

  // Starts over in another world W, where gravity and velocity have to be estimated again.
  // Readings, time offset and the given-up status are kept.
  void Restart();

  // Returns the latest image's state in W; empty unless running or dead reckoning.
  std::optional<InertialEstimate> estimate() const;
  std::optional<Pose> T_WC() const;
  // Returns the estimated gravity [m/s^2] in W; empty before the initialization.
  std::optional<Eigen::Vector3d> gravity_W() const;
  double gravity_sigma() const;  // [rad]
  double time_offset() const;    // [s] t_d
  double time_offset_sigma() const;
  InertialStatus status() const;
  double weight() const;  // of the latest IMU factor
  const ImuCalibration& calibration() const;
  // Current estimate; that of the calibration if it is not estimated online.
  const Pose& T_BC() const;

  // Returns the readings between two instants of the IMU's clock, preintegrated with the current
  // bias; empty if some are missing, or if images contradict them.
  std::optional<ImuPreintegration> Between(Stamp from, Stamp to) const;
  // Returns them even if images contradict them.
  std::optional<ImuPreintegration> AllBetween(Stamp from, Stamp to) const;
  // Returns whether images contradict some of the readings between these instants.
  bool IsContradicted(Stamp from, Stamp to) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
