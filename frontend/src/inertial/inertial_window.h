#pragma once

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/sliding_window_smoother.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/input/sensor.h>

#include "inertial/visual_pose.h"

namespace highwall {

// The same after the motion that an IMU measured, its noise added (Forster et al. 2017); that is
// larger where the IMU's residual weighs less than 1 (weight > 0).
InertialEstimate Propagate(const InertialEstimate& from, const ImuPreintegration& imu,
                           const Eigen::Vector3d& gravity_W, double weight = 1.0);

// Pose of the camera and its 6 x 6 covariance in the tangent of PoseManifold.
struct CameraPoseEstimate {
  Pose T_WC;
  Eigen::Matrix<double, 6, 6> covariance;
};
CameraPoseEstimate CameraOf(const InertialEstimate& body, const Pose& T_BC);

// Where a window starts: the first state and the calibration, with their joint uncertainty. At rest
// gravity's direction and the bias of the accelerometer are known together far better than either:
// what couples them must not be lost.
struct InertialPrior {
  InertialEstimate estimate;
  UnitDirection gravity_W;
  double time_offset = 0.0;  // [s] t_d
  // Of [n t_d], n in the tangent of UnitDirectionManifold at gravity_W [rad, s].
  Eigen::Matrix3d calibration_covariance = 1e-4 * Eigen::Matrix3d::Identity();
  // 15 x 3, of the state with these.
  Eigen::Matrix<double, 15, 3> coupling = Eigen::Matrix<double, 15, 3>::Zero();

  // 18 x 18, all of it.
  Eigen::Matrix<double, 18, 18> Joint() const;
  void SetJoint(const Eigen::Matrix<double, 18, 18>& covariance);
  // Standard deviations: of gravity's direction [rad] (the larger of two), of t_d [s].
  double gravity_sigma() const;
  double time_offset_sigma() const;
  // The same in a world that was turned: p_new = q p_old.
  InertialPrior Turned(const Eigen::Quaterniond& q) const;
};

// The last states of body, velocity and bias, one an image, tied by IMU factors and held by what
// the images say about the camera's pose; older ones live on in a marginal prior
// (SlidingWindowSmoother). Gravity's direction and the time offset are estimated along.
class InertialWindow {
 public:
  // free_time_offset: else it keeps the value of the prior.
  InertialWindow(const ImuCalibration& calibration, const SlidingWindowOptions& options,
                 const InertialPrior& prior, bool free_time_offset);

  // What joins the window with a state.
  struct Step {
    const ImuPreintegration* imu = nullptr;  // from the newest state; its end is the new stamp
    double weight = 1.0;                     // of the IMU factor
    const VisualPose* visual = nullptr;      // may be null: the IMU alone
    Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // [rad/s] at the end, bias taken off
    bool stationary = false;                            // the body does not move
  };
  // False where the smoother refused the step: the window is as before.
  bool Add(const Step& step);

  const InertialEstimate& newest() const { return newest_; }
  UnitDirection gravity_W() const;
  double time_offset() const;
  // Where a window that followed on this one would start.
  InertialPrior Prior() const;

 private:
  struct State {
    Variable<Pose> pose;
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
  };
  State AddState(const InertialEstimate& estimate);
  void AddPrior(const InertialPrior& prior);
  void ReadNewest(Stamp stamp);

  ImuCalibration calibration_;
  SlidingWindowSmoother smoother_;
  Variable<UnitDirection> gravity_;
  Variable<double> time_offset_;
  State state_;
  InertialEstimate newest_;
  bool free_time_offset_;
  Eigen::Matrix3d calibration_covariance_;  // as of InertialPrior
  Eigen::Matrix<double, 15, 3> coupling_;
};

}  // namespace highwall
