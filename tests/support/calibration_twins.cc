#include "support/calibration_twins.h"

#include <ceres/autodiff_cost_function.h>
#include <Eigen/Geometry>

#include "support/imu_twins.h"
#include "support/reprojection_twins.h"

namespace highwall::twins {

template <typename T>
bool CameraPose::operator()(const T* T_WB, const T* v_WB, const T* t_d, T* residuals) const {
  const Eigen::Map<const Vector3<T>> p(T_WB), v(v_WB);
  const Eigen::Map<const Eigen::Quaternion<T>> q(T_WB + 3);
  const T d = *t_d - T(t_d_state);
  const Eigen::Quaternion<T> q_d = q * Rotation<T>(omega_B.cast<T>() * d);
  const Vector3<T> p_C = p + v * d + q_d * T_BC.p().cast<T>();
  Eigen::Matrix<T, 6, 1> e;
  e << p_C - T_WC_0.p().cast<T>(),
      RotationVector<T>(T_WC_0.q().conjugate().cast<T>() * q_d * T_BC.q().cast<T>());
  Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
  r = W.cast<T>() * e;
  return true;
}

template <typename T>
bool ExtrinsicCameraPose::operator()(const T* T_WB, const T* v_WB, const T* t_d, const T* T_BC,
                                     const T* s, T* residuals) const {
  const Eigen::Map<const Vector3<T>> p(T_WB), v(v_WB), p_BC(T_BC);
  const Eigen::Map<const Eigen::Quaternion<T>> q(T_WB + 3), q_BC(T_BC + 3);
  const T d = *t_d - T(t_d_state);
  const Eigen::Quaternion<T> q_d = q * Rotation<T>(omega_B.cast<T>() * d);
  const Vector3<T> p_C = p + v * d + q_d * p_BC;
  Eigen::Matrix<T, 6, 1> e;
  e << p_C / *s - T_WC_0.p().cast<T>(),
      RotationVector<T>(T_WC_0.q().conjugate().cast<T>() * q_d * q_BC);
  Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
  r = W.cast<T>() * e;
  return true;
}

template <typename T>
bool ScaledMotion::operator()(const T* T_WB_i, const T* T_WB_j, const T* s, T* residuals) const {
  const Eigen::Map<const Vector3<T>> p_i(T_WB_i), p_j(T_WB_j);
  const Eigen::Map<const Eigen::Quaternion<T>> q_i(T_WB_i + 3), q_j(T_WB_j + 3);
  const Vector3<T> p_BC = T_BC.p().cast<T>();
  const Eigen::Quaternion<T> q_WCi = q_i * T_BC.q().cast<T>(), q_WCj = q_j * T_BC.q().cast<T>();
  const Vector3<T> p_CiCj = q_WCi.conjugate() * (p_j + q_j * p_BC - p_i - q_i * p_BC);
  Eigen::Matrix<T, 6, 1> e;
  e << p_CiCj / *s - Z.p().cast<T>(),
      RotationVector<T>(Z.q().conjugate().cast<T>() * q_WCi.conjugate() * q_WCj);
  Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
  r = W.cast<T>() * e;
  return true;
}

std::unique_ptr<ceres::CostFunction> MakeCameraPose(const CameraPose& twin) {
  using Cost = ceres::AutoDiffCostFunction<CameraPose, 6, 7, 3, 1>;
  return std::make_unique<Cost>(new CameraPose(twin));
}

std::unique_ptr<ceres::CostFunction> MakeExtrinsicCameraPose(const ExtrinsicCameraPose& twin) {
  using Cost = ceres::AutoDiffCostFunction<ExtrinsicCameraPose, 6, 7, 3, 1, 7, 1>;
  return std::make_unique<Cost>(new ExtrinsicCameraPose(twin));
}

std::unique_ptr<ceres::CostFunction> MakeScaledMotion(const ScaledMotion& twin) {
  using Cost = ceres::AutoDiffCostFunction<ScaledMotion, 6, 7, 7, 1>;
  return std::make_unique<Cost>(new ScaledMotion(twin));
}

}  // namespace highwall::twins
