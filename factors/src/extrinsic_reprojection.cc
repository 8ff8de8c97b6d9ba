#include <highwall/factors/extrinsic_reprojection.h>

#include <highwall/core/manifolds.h>

namespace highwall {
namespace {

// Returns dr/d(dp, dtheta) of a pose T_AB from dr/dp_B: p_B = R_BA (p_A - p_AB).          Eq. 2
template <int kRows>
Eigen::Matrix<double, kRows, 6> PoseJacobian(const Eigen::Matrix<double, kRows, 3>& dr_dp_A,
                                             const Eigen::Matrix<double, kRows, 3>& dr_dp_B,
                                             const Eigen::Vector3d& p_B) {
  Eigen::Matrix<double, kRows, 6> J;
  J.template leftCols<3>() = -dr_dp_A;
  for (int i = 0; i < kRows; ++i) {
    J.template block<1, 3>(i, 3) = dr_dp_B.row(i).cross(p_B.transpose());
  }
  return J;
}

}  // namespace

template <int kRows>
bool ExtrinsicReprojection<kRows>::Evaluate(double const* const* parameters, double* residuals,
                                            double** jacobians) const {
  const RgbdProjection::View body = RgbdProjection::At(parameters[kPose]);
  const RgbdProjection::View camera = RgbdProjection::At(parameters[kExtrinsics]);
  const Eigen::Map<const Eigen::Vector3d> p_W(parameters[kPoint]);
  const Eigen::Vector3d p_B = body.R_BW * (p_W - body.p_WB);
  const Eigen::Vector3d p_C = camera.R_BW * (p_B - camera.p_WB);

  Vector r;
  Eigen::Matrix<double, kRows, 3> dr_dp_C;
  if (!projection_.template EvaluateInCamera<kRows>(p_C, rows_, &r,
                                                    jacobians ? &dr_dp_C : nullptr)) {
    r.setZero();
    dr_dp_C.setZero();
  }
  Eigen::Map<Vector> out(residuals);
  out = r;  // Eq. 1
  if (jacobians == nullptr) return true;

  const Eigen::Matrix<double, kRows, 3> dr_dp_B = dr_dp_C * camera.R_BW;
  const Eigen::Matrix<double, kRows, 3> dr_dp_W = dr_dp_B * body.R_BW;
  if (jacobians[kPose]) {
    PoseManifold::Lift<kRows>(parameters[kPose], PoseJacobian<kRows>(dr_dp_W, dr_dp_B, p_B),
                              jacobians[kPose]);
  }
  if (jacobians[kPoint]) {
    Eigen::Map<Eigen::Matrix<double, kRows, 3, Eigen::RowMajor>> J(jacobians[kPoint]);
    J = dr_dp_W;  // Eq. 3
  }
  if (jacobians[kExtrinsics]) {
    PoseManifold::Lift<kRows>(parameters[kExtrinsics], PoseJacobian<kRows>(dr_dp_B, dr_dp_C, p_C),
                              jacobians[kExtrinsics]);
  }
  return true;
}

template class ExtrinsicReprojection<2>;
template class ExtrinsicReprojection<3>;

}  // namespace highwall
