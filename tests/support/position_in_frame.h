#pragma once

#include <memory>

#include <ceres/autodiff_cost_function.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace highwall::testing {

// The position of a body in another frame, by autodiff: an example of a user-defined factor.
// Blocks: 0: T_WB (7)  1: T_FW (7)
struct PositionInFrameFunctor {
  Eigen::Vector3d p_F;
  double sigma = 1.0;  // [m]

  template <typename T>
  bool operator()(const T* T_WB, const T* T_FW, T* r) const {
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> p_WB(T_WB), p_FW(T_FW);
    const Eigen::Map<const Eigen::Quaternion<T>> q_FW(T_FW + 3);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> residual(r);
    residual = (q_FW * p_WB + p_FW - p_F.cast<T>()) / T(sigma);
    return true;
  }
};

inline std::shared_ptr<ceres::CostFunction> PositionInFrame(const Eigen::Vector3d& p_F,
                                                            double sigma) {
  return std::make_shared<ceres::AutoDiffCostFunction<PositionInFrameFunctor, 3, 7, 7>>(
      new PositionInFrameFunctor{p_F, sigma});
}

}  // namespace highwall::testing
