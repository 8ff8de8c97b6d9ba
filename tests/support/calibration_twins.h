#pragma once

#include <memory>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>

// Autodiff twins of the factors with a calibration block. Their evaluation is compiled once, in the
// library highwall_factors_twins.
namespace highwall::twins {

struct CameraPose {
  highwall::Pose T_WC_0;
  Eigen::Matrix<double, 6, 6> W;
  highwall::Pose T_BC;
  Eigen::Vector3d omega_B;
  double t_d_state;

  template <typename T>
  bool operator()(const T* T_WB, const T* v_WB, const T* t_d, T* residuals) const;
};

struct ExtrinsicCameraPose {
  highwall::Pose T_WC_0;
  Eigen::Matrix<double, 6, 6> W;
  Eigen::Vector3d omega_B;
  double t_d_state;

  template <typename T>
  bool operator()(const T* T_WB, const T* v_WB, const T* t_d, const T* T_BC, const T* s,
                  T* residuals) const;
};

struct ScaledMotion {
  highwall::Pose Z;
  Eigen::Matrix<double, 6, 6> W;
  highwall::Pose T_BC;

  template <typename T>
  bool operator()(const T* T_WB_i, const T* T_WB_j, const T* s, T* residuals) const;
};

std::unique_ptr<ceres::CostFunction> MakeCameraPose(const CameraPose& twin);
std::unique_ptr<ceres::CostFunction> MakeExtrinsicCameraPose(const ExtrinsicCameraPose& twin);
std::unique_ptr<ceres::CostFunction> MakeScaledMotion(const ScaledMotion& twin);

}  // namespace highwall::twins
