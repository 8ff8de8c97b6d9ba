#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// Recursion of ImuPreintegration, one step per pair of consecutive samples.
//
// Errors are expressed in the frame of the start of the interval, x = [phi v p] with R <- Exp(phi)
// R. There the transition is the identity plus cross products, and the gyroscope noise, equal on
// all axes, is invariant to rotation: a step costs a fraction of one in the body frame.
class ImuIntegrator {
 public:
  // Bias-corrected readings at one instant and their time derivatives.
  struct Knot {
    Eigen::Vector3d w, a;    // [rad/s], [m/s^2]
    Eigen::Vector3d dw, da;  // [rad/s^2], [m/s^3]
  };

  explicit ImuIntegrator(const ImuNoise& noise);

  // Integrates from `from`, the `to` of the previous call, to `to`, h > 0 seconds later.
  void Step(double h, const Knot& from, const Knot& to);

  // Exports the results in the convention of ImuDelta.
  void Export(ImuDelta* delta, Eigen::Matrix<double, 15, 15>* covariance) const;

 private:
  void PropagateErrors(double h, const Eigen::Vector3d& dv, const Eigen::Vector3d& dp,
                       const Eigen::Matrix3d& A, const Eigen::Matrix3d& B);

  // [P_xx | P_xb | J]: covariance of x, cross-covariance with the biases, derivative of x in a
  // constant bias. They are stored side by side since the transition acts on the columns of all
  // three.
  using Panel = Eigen::Matrix<double, 9, 21, Eigen::RowMajor>;

  double gyroscope_variance_, accelerometer_variance_;            // densities, per second
  double gyroscope_walk_variance_, accelerometer_walk_variance_;  // densities, per second
  double t_ = 0.0;
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d v_ = Eigen::Vector3d::Zero(), p_ = Eigen::Vector3d::Zero();
  Panel panel_ = Panel::Zero();
};

}  // namespace highwall
