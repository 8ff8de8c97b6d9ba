#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/factors/imu_buffer.h>

namespace [[gnu::visibility("default")]] highwall {

// Continuous noise densities of an IMU. Defaults: ADIS16448, the IMU of the EuRoC sequences.
struct ImuNoise {
  double gyroscope = 1.6968e-4;        // [rad/s/sqrt(Hz)] > 0
  double accelerometer = 2.0e-3;       // [m/s^2/sqrt(Hz)] > 0
  double gyroscope_walk = 1.9393e-5;   // [rad/s^2/sqrt(Hz)] > 0
  double accelerometer_walk = 3.0e-3;  // [m/s^3/sqrt(Hz)] > 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of ImuPreintegration.
struct ImuPreintegrationOptions {
  ImuNoise noise = {};
  // A bias that differs by more than this from the bias of the integration is outside the range of
  // the first-order correction: see NeedsReintegration().
  double max_gyroscope_change = 0.01;     // [rad/s] > 0
  double max_accelerometer_change = 0.1;  // [m/s^2] > 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Relative motion over an interval of samples, independent of the state at its start. Rows and
// columns of 15 are [theta v p b_g b_a], of 9 [theta v p]; theta is a right perturbation of R.
struct ImuDelta {
  double duration = 0.0;                                  // [s]
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  // Delta R
  Eigen::Vector3d v = Eigen::Vector3d::Zero();            // Delta v [m/s]
  Eigen::Vector3d p = Eigen::Vector3d::Zero();            // Delta p [m]
  ImuBias bias = ImuBias::Zero();                         // bias of the integration
  Eigen::Matrix<double, 9, 6> bias_jacobian = Eigen::Matrix<double, 9, 6>::Zero();

  // Returns the motion corrected to another bias, to first order.                        Eq. 7
  struct Motion {
    Eigen::Quaterniond q;
    Eigen::Vector3d v, p;
  };
  Motion At(const ImuBias& other) const;
};

// Position, orientation and velocity of the body in the world.
struct ImuState {
  Pose T_WB;
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();  // [m/s]
};

// Preintegrates the readings of an IMU between two instants.
//
//   Delta R = R_i^T R_j,   Delta v = R_i^T (v_j - v_i - g T),
//   Delta p = R_i^T (p_j - p_i - v_i T - g T^2 / 2)     docs/factors/imu_preintegration.md, Eq. 1
//
// Value type; computed once, by the constructor, with one heap allocation for the copy of the
// samples.
// Source: Forster, Carlone, Dellaert, Scaramuzza, "On-manifold preintegration for real-time
// visual-inertial odometry", IEEE T-RO 33(1), 2017.
class ImuPreintegration {
 public:
  // samples: at least 2, with strictly increasing stamps (ImuBuffer::Between); the interval spans
  // from the first stamp to the last. bias: estimate at its start. Throws InvalidArgument if a
  // sample or the bias is not finite, if stamps do not increase, and on bad options.
  ImuPreintegration(std::span<const ImuSample> samples, const ImuBias& bias,
                    const ImuPreintegrationOptions& options = {});

  const ImuDelta& delta() const { return delta_; }
  // Covariance, 15 x 15, of the error (true minus measured motion) and of the bias random walk
  // until the end.
  const Eigen::Matrix<double, 15, 15>& covariance() const { return covariance_; }
  // Returns true if the covariance is positive definite, as ImuFactor requires. Rounding destroys
  // this for readings far beyond the range of any sensor.
  bool HasInformation() const;
  Stamp start() const { return samples_.front().stamp; }
  Stamp end() const { return samples_.back().stamp; }
  std::span<const ImuSample> samples() const { return samples_; }
  const ImuPreintegrationOptions& options() const { return options_; }

  // Predicts the state at the end from the state at the start. gravity_W [m/s^2].        Eq. 8
  ImuState Predict(const ImuState& start, const ImuBias& bias,
                   const Eigen::Vector3d& gravity_W) const;

  // Returns whether the bias is outside the range of the first-order correction; then use
  // Reintegrated(bias) instead.
  bool NeedsReintegration(const ImuBias& bias) const;
  ImuPreintegration Reintegrated(const ImuBias& bias) const;
  // Returns this interval merged with the one that follows it, with the bias and the bounds of this
  // one and the time-weighted mean of both noise variances. Throws InvalidArgument unless
  // next.start() == end().
  ImuPreintegration Joined(const ImuPreintegration& next) const;

 private:
  void Integrate();

  std::vector<ImuSample> samples_;
  ImuPreintegrationOptions options_;
  ImuDelta delta_;
  Eigen::Matrix<double, 15, 15> covariance_;
};

}  // namespace highwall
