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
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/measurement_model.h>

#include "inertial/visual_pose.h"
#include "map/seen_landmarks.h"
#include "pose/known_pose.h"

namespace highwall {

// Fuses what images see of the map with an IMU: initialization, a sliding window of states, the
// weight of the IMU, the time offset, dead reckoning where images show nothing.
//
//   for each image:
//     AddSample() every reading until some 50 ms after it
//     Predict()   where the camera should be
//     Update()    with what the image says, if anything
//     T_WC()      the pose by both
//
// States live in a frame O that stands still, with its z axis as far up as the initialization knew;
// the map's frame W moves with respect to it when the map is corrected (MoveMap), by a turn about
// the vertical and a shift, and when it is levelled again.
class InertialOdometry {
 public:
  // model: of the camera; without one, images are poses whatever the options say. Throws
  // InvalidArgument on bad options.
  explicit InertialOdometry(const ImuCalibration& calibration, const InertialOptions& options = {},
                            const std::optional<MeasurementModel>& model = std::nullopt);

  ~InertialOdometry();
  InertialOdometry(InertialOdometry&&) noexcept;
  InertialOdometry& operator=(InertialOdometry&&) noexcept;

  ImuSampleStatus AddSample(const ImuSample& sample);

  // The unit vector in C that points up, by the mean reading of the accelerometer over the second
  // before an image: good for a camera at rest or in calm motion. Empty without readings.
  std::optional<Eigen::Vector3d> UpInCamera(Stamp image) const;

  // The pose of the camera that the IMU predicts; empty before the initialization, without
  // readings, and after dead reckoning for too long.
  std::optional<KnownPose> Predict(Stamp image) const;

  // What an image told, besides its stamp [ns, camera's clock].
  struct Observation {
    Stamp image = 0;
    std::optional<VisualPose> visual;  // in W
    // With it, what the pose was found by: for the window of landmarks, which asks now and then.
    std::function<SeenLandmarks()> see;
    double sharpness = 1.0;  // MotionMeasures
    double tracked_share = 1.0;
    bool keeps_level = false;  // the map must not be levelled now: InertialReport::T_level
  };
  InertialReport Update(const Observation& observation);

  // The map was moved, T_new_old in W, where the camera is now.
  void MoveMap(const Pose& T_new_old);

  // The map goes on in another world W: gravity and velocity are to be found anew. Readings, time
  // offset and what was given up are kept.
  void Restart();

  // The latest image's state in W; empty unless running or dead reckoning.
  std::optional<InertialEstimate> estimate() const;
  std::optional<Pose> T_WC() const;
  // [m/s^2] in W, as estimated; empty before the initialization.
  std::optional<Eigen::Vector3d> gravity_W() const;
  double gravity_sigma() const;  // [rad]
  double time_offset() const;    // [s] t_d
  double time_offset_sigma() const;
  InertialStatus status() const;
  double weight() const;  // of the latest IMU factor
  const ImuCalibration& calibration() const;
  // As it is known by now; the calibration's where it is not estimated.
  const Pose& T_BC() const;

  // The readings between two instants of the IMU's clock, preintegrated with the present bias;
  // empty where some are missing.
  std::optional<ImuPreintegration> Between(Stamp from, Stamp to) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
