#pragma once

#include <memory>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>

// Autodiff twins of the factors on poses, for tests and benchmarks. Their evaluation is compiled
// once, in the library highwall_core_twins.
namespace highwall::twins {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct PosePrior {
  Pose T_0;
  Matrix6 W;

  template <typename T>
  bool operator()(const T* pose, T* residuals) const;
};

struct RelativePose {
  Pose Z;
  Matrix6 W;

  template <typename T>
  bool operator()(const T* T_i, const T* T_j, T* residuals) const;
};

struct Vector6Prior {
  Vector6 x_0;
  Matrix6 W;

  template <typename T>
  bool operator()(const T* block, T* residuals) const;
};

std::unique_ptr<ceres::CostFunction> Make(const PosePrior& twin);
std::unique_ptr<ceres::CostFunction> Make(const RelativePose& twin);
std::unique_ptr<ceres::CostFunction> Make(const Vector6Prior& twin);

}  // namespace highwall::twins
