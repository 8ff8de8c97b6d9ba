#include "inertial/known_point.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace highwall {
namespace {

// Share of the largest eigenvalue of the information below which a direction is unobservable.
constexpr double kOpen = 1e-9;

}  // namespace

std::unique_ptr<PointInFrame> KnownPoint(const SeenLandmark<MapPoint>& seen, const Pose& T_WM,
                                         const MeasurementModel& model, double huber) {
  const Eigen::Vector3d p_W = T_WM * seen.geometry_W;
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const auto& [T_MC, feature] : seen.views) {
    const Pose T_WC = T_WM * T_MC;
    Eigen::Vector3d r;
    Eigen::Matrix3d J;
    if (!model.projection().Evaluate<3>(RgbdProjection::At(T_WC.data()), model.Rows(*feature), p_W,
                                        &r, nullptr, &J)) {
      continue;
    }
    const double norm = r.norm();
    const double weight = norm > huber ? huber / norm : 1.0;
    H += weight * J.transpose() * J;
    g += weight * J.transpose() * r;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(H);
  const Eigen::Vector3d lambda = eigen.eigenvalues();
  const Eigen::Matrix3d& V = eigen.eigenvectors();
  Eigen::Vector3d root = Eigen::Vector3d::Zero(), step = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (!(lambda[i] > kOpen * lambda[2])) continue;
    root[i] = std::sqrt(lambda[i]);
    step -= V.col(i) * (V.col(i).dot(g) / lambda[i]);
  }
  return std::make_unique<PointInFrame>(p_W + step, root.asDiagonal() * V.transpose());
}

}  // namespace highwall
