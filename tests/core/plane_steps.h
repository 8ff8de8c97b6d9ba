#pragma once

#include <memory>

#include <ceres/autodiff_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/prior.h>
#include <highwall/core/solver.h>

// Linear factors on points in the plane.
namespace highwall {

using Vector2 = Eigen::Vector2d;

// x_j - x_i = z: odometry between plane points, or a landmark observed from one of them. Linear.
struct Step {
  Vector2 z;
  double weight;
  template <class S>
  bool operator()(const S* x_i, const S* x_j, S* r) const {
    for (int k = 0; k < 2; ++k) r[k] = (x_j[k] - x_i[k] - z[k]) * weight;
    return true;
  }
};
inline std::unique_ptr<ceres::CostFunction> MakeStep(const Vector2& z, double weight = 1.0) {
  return std::make_unique<ceres::AutoDiffCostFunction<Step, 2, 2, 2>>(new Step{z, weight});
}
inline std::unique_ptr<VectorPrior<2>> MakePrior(const Vector2& x, double weight = 1.0) {
  return std::make_unique<VectorPrior<2>>(x, weight * Eigen::Matrix2d::Identity());
}

inline SolveOptions Exact() {
  return {.max_iterations = 20,
          .function_tolerance = 0.0,
          .parameter_tolerance = 1e-14,
          .initial_trust_region_radius = 1e16};  // no damping: linear problems solve in one step
}

}  // namespace highwall
