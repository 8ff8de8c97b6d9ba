#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/sliding_window_smoother.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/input/sensor.h>

#include "inertial/inertial_prior.h"
#include "inertial/visual_pose.h"

namespace highwall {

// The last states of body, velocity and bias, one an image, tied by IMU factors and held by what
// the images say about the camera's pose; older ones live on in a marginal prior
// (SlidingWindowSmoother). Gravity's direction and the time offset are estimated along, and so is
// T_BC where the prior has it.
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
    // [s] by which the image's stamp was taken to that of the readings' end; empty: time_offset().
    std::optional<double> time_offset{};
    Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // [rad/s] at the end, bias taken off
    bool stationary = false;                            // the body does not move
  };
  // False where the smoother refused the step: the window is as before.
  bool Add(const Step& step);

  const InertialEstimate& newest() const { return newest_; }
  UnitDirection gravity_W() const;
  double time_offset() const;
  const Pose& T_BC() const { return T_BC_; }
  // Where a window that followed on this one would start.
  InertialPrior Prior() const;

 private:
  struct State {
    Variable<Pose> pose;
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
  };
  struct Extrinsics {
    Variable<Pose> T_BC;
    Variable<double> scale;  // of the depth: as it is
  };
  State AddState(const InertialEstimate& estimate);
  void AddPrior(const InertialPrior& prior);
  void AddVisual(const Step& step, const State& state);
  void ReadNewest(Stamp stamp);

  SlidingWindowSmoother smoother_;
  Variable<UnitDirection> gravity_;
  Variable<double> time_offset_;
  std::optional<Extrinsics> extrinsics_;  // where they are unknowns
  Pose T_BC_;
  State state_;
  InertialEstimate newest_;
  bool free_time_offset_;
  Eigen::MatrixXd calibration_covariance_;  // as of InertialPrior
  Eigen::Matrix<double, 15, Eigen::Dynamic> coupling_;
};

}  // namespace highwall
