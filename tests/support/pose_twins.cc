#include "support/pose_twins.h"

#include <cmath>

#include <ceres/autodiff_cost_function.h>
#include <Eigen/Geometry>

namespace highwall::twins {
namespace {

// Returns the rotation vector of a quaternion that is not the identity.
template <typename T>
Eigen::Matrix<T, 3, 1> AngleTimesAxis(const Eigen::Quaternion<T>& q) {
  using std::atan2;
  const T sine = q.vec().norm();
  return q.vec() * (T(2.0) * atan2(sine, q.w()) / sine);
}

}  // namespace

template <typename T>
bool PosePrior::operator()(const T* pose, T* residuals) const {
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> p(pose);
  const Eigen::Map<const Eigen::Quaternion<T>> q(pose + 3);
  Eigen::Matrix<T, 6, 1> e;
  e << p - T_0.p().cast<T>(),
      AngleTimesAxis<T>(Eigen::Quaternion<T>(T_0.q().conjugate().cast<T>() * q));
  Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
  r = W.cast<T>() * e;
  return true;
}

template <typename T>
bool RelativePose::operator()(const T* T_i, const T* T_j, T* residuals) const {
  using std::cos;
  using std::sin;
  using Vector = Eigen::Matrix<T, 3, 1>;
  const Eigen::Map<const Vector> p_i(T_i), p_j(T_j);
  const Eigen::Map<const Eigen::Quaternion<T>> q_i(T_i + 3), q_j(T_j + 3);
  const Eigen::Quaternion<T> Z_inverse = Z.q().conjugate().cast<T>();
  const Vector p_ij = q_i.conjugate() * (p_j - p_i);
  const Vector p = Z_inverse * (p_ij - Z.p().cast<T>());
  const Vector theta = AngleTimesAxis<T>(Eigen::Quaternion<T>(Z_inverse * (q_i.conjugate() * q_j)));
  // J_l^-1(theta) p of SO(3) (Sola et al. 2018, Eq. 146).
  const T angle = theta.norm();
  const T c = T(1.0) / (angle * angle) - (T(1.0) + cos(angle)) / (T(2.0) * angle * sin(angle));
  const Vector theta_p = theta.cross(p);
  Eigen::Matrix<T, 6, 1> e;
  e << p - T(0.5) * theta_p + c * theta.cross(theta_p), theta;
  Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
  r = W.cast<T>() * e;
  return true;
}

template <typename T>
bool Vector6Prior::operator()(const T* block, T* residuals) const {
  const Eigen::Map<const Eigen::Matrix<T, 6, 1>> x(block);
  Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
  r = W.cast<T>() * (x - x_0.cast<T>());
  return true;
}

std::unique_ptr<ceres::CostFunction> Make(const PosePrior& twin) {
  return std::make_unique<ceres::AutoDiffCostFunction<PosePrior, 6, 7>>(new PosePrior(twin));
}

std::unique_ptr<ceres::CostFunction> Make(const RelativePose& twin) {
  return std::make_unique<ceres::AutoDiffCostFunction<RelativePose, 6, 7, 7>>(
      new RelativePose(twin));
}

std::unique_ptr<ceres::CostFunction> Make(const Vector6Prior& twin) {
  return std::make_unique<ceres::AutoDiffCostFunction<Vector6Prior, 6, 6>>(new Vector6Prior(twin));
}

}  // namespace highwall::twins
