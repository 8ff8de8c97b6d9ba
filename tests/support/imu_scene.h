#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/core/so3.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>

// Shared by the tests of the inertial factors: analytic motions and their IMU readings.
namespace highwall {

inline const Eigen::Vector3d kGravity(0.0, 0.0, -9.81);

// A body with sinusoidal motion: position A sin(k t + phase) along each axis of W, rotation
// Exp(yaw(t) z) Exp(pitch(t) y) Exp(roll(t) x) with sinusoidal angles. Everything is analytic.
class SinusoidalMotion {
 public:
  explicit SinusoidalMotion(double rate = 1.0) : rate_(rate) {}

  ImuState StateAt(double t) const { return {Pose(Rotation(t), Position(t, 0)), Position(t, 1)}; }
  // Returns the reading without noise and bias.
  ImuSample SampleAt(Stamp stamp) const {
    const double t = ToSeconds(stamp);
    return {stamp, AngularRate(t), Rotation(t).conjugate() * (Position(t, 2) - kGravity)};
  }
  // Returns the readings from t = 0 to `duration` [s].
  std::vector<ImuSample> Samples(double hertz, double duration) const {
    std::vector<ImuSample> samples;
    const int n = static_cast<int>(std::lround(duration * hertz));
    for (int i = 0; i <= n; ++i) samples.push_back(SampleAt(FromSeconds(i / hertz)));
    return samples;
  }

 private:
  // Returns the derivative of order `order` of a sin(k t + c).
  double Wave(double a, double k, double c, double t, int order) const {
    const double w = k * rate_;
    return a * std::pow(w, order) * std::sin(w * t + c + 0.5 * M_PI * order);
  }
  Eigen::Vector3d Position(double t, int order) const {
    return {Wave(1.2, 1.1, 0.3, t, order), Wave(0.8, 1.7, 1.0, t, order),
            Wave(0.3, 2.3, -0.4, t, order)};
  }
  // Yaw, pitch, roll.
  Eigen::Vector3d Angles(double t, int order) const {
    return {Wave(1.0, 0.9, 0.1, t, order), Wave(0.3, 1.9, 0.7, t, order),
            Wave(0.4, 1.5, -0.9, t, order)};
  }
  Eigen::Quaterniond Rotation(double t) const {
    const Eigen::Vector3d a = Angles(t, 0);
    return so3::Exp({0, 0, a(0)}) * so3::Exp({0, a(1), 0}) * so3::Exp({a(2), 0, 0});
  }
  // Returns the angular rate in B, from the rates of the Euler angles.
  Eigen::Vector3d AngularRate(double t) const {
    const Eigen::Vector3d a = Angles(t, 0), da = Angles(t, 1);
    const Eigen::Quaterniond roll = so3::Exp({a(2), 0, 0}), pitch = so3::Exp({0, a(1), 0});
    return Eigen::Vector3d(da(2), 0, 0) + roll.conjugate() * Eigen::Vector3d(0, da(1), 0) +
           roll.conjugate() * (pitch.conjugate() * Eigen::Vector3d(0, 0, da(0)));
  }

  double rate_;
};

// Returns [theta v p], the difference of `to` from `from`, with theta on the right of the rotation.
inline Eigen::Matrix<double, 9, 1> StateDifference(const ImuState& from, const ImuState& to) {
  Eigen::Matrix<double, 9, 1> d;
  d << so3::Log(from.T_WB.q().conjugate() * to.T_WB.q()), to.v_WB - from.v_WB,
      to.T_WB.p() - from.T_WB.p();
  return d;
}

// Adds a constant bias to every reading.
inline std::vector<ImuSample> WithBias(std::vector<ImuSample> samples, const ImuBias& bias) {
  for (ImuSample& sample : samples) {
    sample.gyroscope += bias.head<3>();
    sample.accelerometer += bias.tail<3>();
  }
  return samples;
}

}  // namespace highwall
