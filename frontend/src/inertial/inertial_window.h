#pragma once

#include <optional>

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/sliding_window_smoother.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/inertial/visual_pose.h>
#include <highwall/frontend/input/sensor.h>

#include "inertial/inertial_prior.h"

namespace highwall {

// Loosely coupled smoother: the last states of pose, velocity and bias, one per image, connected by
// IMU factors and constrained by the camera poses from images; older states are marginalized
// (SlidingWindowSmoother). Gravity's direction and the time offset are estimated as well, and so is
// T_BC if the prior has it.
class InertialWindow {
 public:
  // free_time_offset: estimate it; otherwise it keeps the value of the prior. Returns empty if the
  // prior is not finite or its covariance is not one. Throws InvalidArgument on bad options.
  static std::optional<InertialWindow> Make(const ImuCalibration& calibration,
                                            const SlidingWindowOptions& options,
                                            const InertialPrior& prior, bool free_time_offset);

  // Input of a new state.
  struct Step {
    const ImuPreintegration* imu = nullptr;  // from the newest state; its end is the new stamp
    double weight = 1.0;                     // of the IMU factor
    const VisualPose* visual = nullptr;      // may be null: the IMU alone
    // [s] offset applied from the image's stamp to the end of the readings; empty: time_offset().
    std::optional<double> time_offset{};
    Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // [rad/s] at the end, bias removed
    bool stationary = false;                            // the body does not move
  };
  // Returns false if the smoother rejected the step: the window is then unchanged.
  bool Add(const Step& step);

  const InertialEstimate& newest() const { return newest_; }
  UnitDirection gravity_W() const;
  double time_offset() const;
  const Pose& T_BC() const { return T_BC_; }
  // Returns the prior of a window that continues from this one.
  InertialPrior Prior() const;

 private:
  struct State {
    Variable<Pose> pose;
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
  };
  struct Extrinsics {
    Variable<Pose> T_BC;
    Variable<double> scale;  // of the depth: fixed
  };
  // prior: finite. The window is to be used only once Begin() has returned true.
  InertialWindow(const ImuCalibration& calibration, const SlidingWindowOptions& options,
                 const InertialPrior& prior, bool free_time_offset);
  bool Begin(const InertialPrior& prior);
  State AddState(const InertialEstimate& estimate);
  bool AddPrior(const InertialPrior& prior);
  void AddVisual(const Step& step, const State& state);
  void ReadNewest(Stamp stamp);

  SlidingWindowSmoother smoother_;
  Variable<UnitDirection> gravity_;
  Variable<double> time_offset_;
  std::optional<Extrinsics> extrinsics_;  // if they are unknowns
  Pose T_BC_;
  State state_;
  InertialEstimate newest_;
  bool free_time_offset_;
  Eigen::MatrixXd calibration_covariance_;  // as that of InertialPrior
  Eigen::Matrix<double, 15, Eigen::Dynamic> coupling_;
};

}  // namespace highwall
