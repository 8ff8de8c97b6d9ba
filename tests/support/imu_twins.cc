#include "support/imu_twins.h"

#include <ceres/autodiff_cost_function.h>

namespace highwall::twins {
namespace {

struct ZeroVelocityTwin {
  double sigma;
  template <typename T>
  bool operator()(const T* velocity, T* residuals) const {
    for (int i = 0; i < 3; ++i) residuals[i] = velocity[i] / T(sigma);
    return true;
  }
};

}  // namespace

template <typename T>
bool Imu::operator()(const T* pose_i, const T* velocity_i, const T* bias_i, const T* pose_j,
                     const T* velocity_j, const T* bias_j, const T* direction, T* residuals) const {
  using Vector = Eigen::Matrix<T, 3, 1>;
  using ConstVector = Eigen::Map<const Vector>;
  using Bias = Eigen::Map<const Eigen::Matrix<T, 6, 1>>;
  const ConstVector p_i(pose_i), p_j(pose_j), v_i(velocity_i), v_j(velocity_j), n(direction);
  const Eigen::Map<const Eigen::Quaternion<T>> q_i(pose_i + 3), q_j(pose_j + 3);
  const Bias b_i(bias_i), b_j(bias_j);
  const Eigen::Matrix<T, 9, 1> shift = delta.bias_jacobian.cast<T>() * (b_i - delta.bias.cast<T>());
  const Eigen::Quaternion<T> q = delta.q.cast<T>() * Rotation<T>(Vector(shift.template head<3>()));
  const T t(delta.duration);
  const Vector g = n * T(gravity);
  Eigen::Matrix<T, 15, 1> e;
  e << RotationVector<T>(q.conjugate() * (q_i.conjugate() * q_j)),
      q_i.conjugate() * Vector(v_j - v_i - g * t) - delta.v.cast<T>() -
          shift.template segment<3>(3),
      q_i.conjugate() * Vector(p_j - p_i - v_i * t - g * (t * t * 0.5)) - delta.p.cast<T>() -
          shift.template tail<3>(),
      b_j - b_i;
  Eigen::Map<Eigen::Matrix<T, 15, 1>> r(residuals);
  r = W.cast<T>() * e;
  return true;
}

template <typename T>
bool Imu::operator()(const T* pose_i, const T* velocity_i, const T* bias_i, const T* pose_j,
                     const T* velocity_j, const T* bias_j, T* residuals) const {
  const T down[3] = {T(0), T(0), T(-1)};
  return (*this)(pose_i, velocity_i, bias_i, pose_j, velocity_j, bias_j, down, residuals);
}

std::unique_ptr<ceres::CostFunction> MakeImu(const Imu& twin) {
  return std::make_unique<ceres::AutoDiffCostFunction<Imu, 15, 7, 3, 6, 7, 3, 6>>(new Imu(twin));
}

std::unique_ptr<ceres::CostFunction> MakeImuGravity(const Imu& twin) {
  return std::make_unique<ceres::AutoDiffCostFunction<Imu, 15, 7, 3, 6, 7, 3, 6, 3>>(new Imu(twin));
}

std::unique_ptr<ceres::CostFunction> MakeZeroVelocity(double sigma) {
  return std::make_unique<ceres::AutoDiffCostFunction<ZeroVelocityTwin, 3, 3>>(
      new ZeroVelocityTwin{sigma});
}

}  // namespace highwall::twins
