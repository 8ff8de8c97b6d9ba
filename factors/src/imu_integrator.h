#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// The recursion behind ImuPreintegration, one step a pair of neighbouring samples.
//
// Errors are kept in the frame of the start of the interval, x = [phi v p] with R <- Exp(phi) R.
// There the transition is the identity plus cross products, and the noise of the gyroscope, equal
// on all axes, does not turn: a step costs a fraction of the one in the frame of the body.
class ImuIntegrator {
 public:
  // Bias-free readings at one instant and their slopes [1/s].
  struct Knot {
    Eigen::Vector3d w, a;    // [rad/s], [m/s^2]
    Eigen::Vector3d dw, da;  // [rad/s^2], [m/s^3]
  };

  explicit ImuIntegrator(const ImuNoise& noise);

  // From `from`, the `to` of the previous call, to `to`, h > 0 seconds later.
  void Step(double h, const Knot& from, const Knot& to);

  // Results in the convention of ImuDelta.
  void Export(ImuDelta* delta, Eigen::Matrix<double, 15, 15>* covariance) const;

 private:
  struct Motion;  // what a step contributes
  void PropagateErrors(double h, const Eigen::Vector3d& dv, const Eigen::Vector3d& dp,
                       const Eigen::Matrix3d& A, const Eigen::Matrix3d& B);

  // [P_xx | P_xb | J]: covariance of x, cross-covariance with the biases, derivative of x in a
  // constant bias. Side by side, for the transition acts on the columns of all three alike.
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
