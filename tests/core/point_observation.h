#pragma once

#include <memory>

#include <ceres/autodiff_cost_function.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace highwall {

// A three-dimensional point observation as a user-defined AutoDiff cost on a Pose and a point:
// r = w (R(q)^T (x - p) - z).
struct PointObservation {
  Eigen::Vector3d z;
  double weight = 1.0;

  template <class S>
  bool operator()(const S* pose, const S* x, S* r) const {
    const Eigen::Map<const Eigen::Matrix<S, 3, 1>> p(pose), point(x);
    const Eigen::Map<const Eigen::Quaternion<S>> q(pose + 3);
    Eigen::Map<Eigen::Matrix<S, 3, 1>> residual(r);
    residual = (q.conjugate() * (point - p) - z.cast<S>()) * S(weight);
    return true;
  }
};

inline std::unique_ptr<ceres::CostFunction> MakeObservation(const Eigen::Vector3d& z,
                                                            double weight = 1.0) {
  return std::make_unique<ceres::AutoDiffCostFunction<PointObservation, 3, 7, 3>>(
      new PointObservation{z, weight});
}

}  // namespace highwall
