#pragma once

#include <cmath>
#include <memory>

#include <ceres/cost_function.h>
#include <ceres/rotation.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/sqrt_information.h>
#include <highwall/factors/imu_factor.h>

// Autodiff twins of the inertial factors, for tests and benchmarks: the same residuals with Ceres'
// own conversions of rotations. Their evaluation is compiled once, in highwall_factors_twins.
namespace highwall::twins {

template <typename T>
Eigen::Matrix<T, 3, 1> RotationVector(const Eigen::Quaternion<T>& q) {
  const T wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  Eigen::Matrix<T, 3, 1> theta;
  ceres::QuaternionToAngleAxis(wxyz, theta.data());
  return theta;
}

template <typename T>
Eigen::Quaternion<T> Rotation(const Eigen::Matrix<T, 3, 1>& theta) {
  T wxyz[4];
  ceres::AngleAxisToQuaternion(theta.data(), wxyz);
  return Eigen::Quaternion<T>(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

struct Imu {
  explicit Imu(const ImuPreintegration& imu, double weight = 1.0)
      : delta(imu.delta()), W(std::sqrt(weight) * SqrtInformation(imu.covariance())) {}

  ImuDelta delta;
  Eigen::Matrix<double, 15, 15> W;
  double gravity = kStandardGravity;

  template <typename T>
  bool operator()(const T* pose_i, const T* velocity_i, const T* bias_i, const T* pose_j,
                  const T* velocity_j, const T* bias_j, const T* direction, T* residuals) const;
  // Gravity along -z of W.
  template <typename T>
  bool operator()(const T* pose_i, const T* velocity_i, const T* bias_i, const T* pose_j,
                  const T* velocity_j, const T* bias_j, T* residuals) const;
};

std::unique_ptr<ceres::CostFunction> MakeImu(const Imu& twin);
std::unique_ptr<ceres::CostFunction> MakeImuGravity(const Imu& twin);
std::unique_ptr<ceres::CostFunction> MakeZeroVelocity(double sigma);

}  // namespace highwall::twins
