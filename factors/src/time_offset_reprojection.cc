#include <highwall/factors/time_offset_reprojection.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>

namespace highwall {

template <int kRows>
TimeOffsetReprojection<kRows>::TimeOffsetReprojection(const Vector& z, const Vector& velocity,
                                                      const Matrix& sqrt_information,
                                                      const RgbdProjection& projection,
                                                      double t_d_state)
    : rows_(PointRows(z, sqrt_information)),
      whitened_velocity_(sqrt_information * velocity),
      projection_(projection),
      t_d_state_(t_d_state) {
  HIGHWALL_REQUIRE(velocity.allFinite(), "TimeOffsetReprojection: the velocity must be finite");
  HIGHWALL_REQUIRE(std::isfinite(t_d_state), "TimeOffsetReprojection: t_d_state must be finite");
}

template <int kRows>
bool TimeOffsetReprojection<kRows>::Evaluate(double const* const* parameters, double* residuals,
                                             double** jacobians) const {
  const double* T_WB = parameters[kPose];
  const Eigen::Map<const Eigen::Vector3d> p_W(parameters[kPoint]);
  double* J_pose = jacobians ? jacobians[kPose] : nullptr;
  double* J_point = jacobians ? jacobians[kPoint] : nullptr;
  double* J_offset = jacobians ? jacobians[kTimeOffset] : nullptr;

  Vector r;
  Eigen::Matrix<double, kRows, 6> dr_dpose;
  Eigen::Matrix<double, kRows, 3> dr_dp_W;
  const bool active = projection_.template Evaluate<kRows>(RgbdProjection::At(T_WB), rows_, p_W, &r,
                                                           J_pose ? &dr_dpose : nullptr,
                                                           J_point ? &dr_dp_W : nullptr);
  if (active) {
    r += whitened_velocity_ * (*parameters[kTimeOffset] - t_d_state_);  // Eq. 1
  } else {
    r.setZero();
    dr_dpose.setZero();
    dr_dp_W.setZero();
  }
  Eigen::Map<Vector> out(residuals);
  out = r;
  if (J_pose) PoseManifold::Lift<kRows>(T_WB, dr_dpose, J_pose);
  if (J_point) {
    Eigen::Map<Eigen::Matrix<double, kRows, 3, Eigen::RowMajor>> J(J_point);
    J = dr_dp_W;
  }
  if (J_offset) {
    Eigen::Map<Vector> J(J_offset);
    J = active ? whitened_velocity_ : Vector::Zero();  // Eq. 2
  }
  return true;
}

template class TimeOffsetReprojection<2>;
template class TimeOffsetReprojection<3>;

}  // namespace highwall
