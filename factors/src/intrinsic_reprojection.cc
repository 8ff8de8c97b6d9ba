#include <highwall/factors/intrinsic_reprojection.h>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>

namespace highwall {

IntrinsicReprojection::IntrinsicReprojection(const ProjectionRows<3>& rows,
                                             const RgbdProjection& projection,
                                             const DepthPattern::Vector& shares)
    : rows_(rows),
      shares_(shares),
      c_(projection.fx() * projection.baseline()),
      min_depth_(projection.min_depth()) {
  HIGHWALL_REQUIRE(rows.A.allFinite() && rows.b.allFinite() && shares.allFinite(),
                   "IntrinsicReprojection: rows and shares must be finite");
}

bool IntrinsicReprojection::Evaluate(double const* const* parameters, double* residuals,
                                     double** jacobians) const {
  const RgbdProjection::View view = RgbdProjection::At(parameters[kPose]);
  const Eigen::Map<const Eigen::Vector3d> p_W(parameters[kPoint]);
  const Eigen::Map<const Eigen::Vector4d> k(parameters[kIntrinsics]);
  const Eigen::Map<const DepthPattern::Vector> g(parameters[kPattern]);
  const double o = parameters[kInverseDepthOffset][0] + shares_.dot(g);
  const Eigen::Vector3d p_C = view.R_BW * (p_W - view.p_WB);
  Eigen::Map<Eigen::Vector3d> r(residuals);
  Eigen::Matrix<double, 3, 6> dr_dpose = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Matrix<double, 3, 3> dr_dp_W = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 4> dr_dk = Eigen::Matrix<double, 3, 4>::Zero();
  Eigen::Vector3d dr_do = Eigen::Vector3d::Zero();
  r.setZero();
  if (p_C.z() >= min_depth_) {
    const double x = p_C.x() / p_C.z(), y = p_C.y() / p_C.z(), iz = 1.0 / p_C.z();
    const Eigen::Vector3d projected(k[0] * x + k[2], k[1] * y + k[3], c_ * (iz + o));
    r = rows_.A * projected + rows_.b;  // Eq. 1
    Eigen::Matrix3d dy_dp_C;            // Eq. 2
    dy_dp_C << k[0] * iz, 0.0, -k[0] * x * iz, 0.0, k[1] * iz, -k[1] * y * iz, 0.0, 0.0,
        -c_ * iz * iz;
    const Eigen::Matrix3d dr_dp_C = rows_.A * dy_dp_C;
    dr_dp_W = dr_dp_C * view.R_BW;
    dr_dpose.leftCols<3>() = -dr_dp_W;
    for (int i = 0; i < 3; ++i) {
      dr_dpose.block<1, 3>(i, 3) = dr_dp_C.row(i).cross(p_C.transpose());
    }
    dr_dk << x * rows_.A.col(0), y * rows_.A.col(1), rows_.A.col(0), rows_.A.col(1);  // Eq. 3
    dr_do = c_ * rows_.A.col(2);                                                      // Eq. 4
  }
  if (jacobians == nullptr) return true;
  if (jacobians[kPose] != nullptr) {
    PoseManifold::Lift<3>(parameters[kPose], dr_dpose, jacobians[kPose]);
  }
  if (jacobians[kPoint] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> out(jacobians[kPoint]);
    out = dr_dp_W;
  }
  if (jacobians[kIntrinsics] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> out(jacobians[kIntrinsics]);
    out = dr_dk;
  }
  if (jacobians[kInverseDepthOffset] != nullptr) {
    Eigen::Map<Eigen::Vector3d> out(jacobians[kInverseDepthOffset]);
    out = dr_do;
  }
  if (jacobians[kPattern] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 3, DepthPattern::kNodes, Eigen::RowMajor>> out(
        jacobians[kPattern]);
    out = dr_do * shares_.transpose();  // Eq. 5
  }
  return true;
}

}  // namespace highwall
