#include "imu_integrator.h"

#include <highwall/core/so3.h>

namespace highwall {
namespace {

constexpr int kPhi = 0, kVelocity = 3, kPosition = 6;       // rows of x
constexpr int kCovariance = 0, kCross = 9, kJacobian = 15;  // columns of the panel

double Square(double x) {
  return x * x;
}

// Columns [c0, c0 + kCols) of m <- F m (Eq. 5), x = [phi v p]:
//   p <- p + h v - dp x phi,   v <- v - dv x phi.
template <int kCols, typename Matrix>
void ApplyTransition(double h, const Eigen::Vector3d& dv, const Eigen::Vector3d& dp, Matrix* m) {
  const auto phi_x = m->template block<1, kCols>(kPhi, 0);
  const auto phi_y = m->template block<1, kCols>(kPhi + 1, 0);
  const auto phi_z = m->template block<1, kCols>(kPhi + 2, 0);
  for (int i = 0; i < 3; ++i) {
    m->template block<1, kCols>(kPosition + i, 0) +=
        h * m->template block<1, kCols>(kVelocity + i, 0);
  }
  const auto subtract_cross = [&](int row, const Eigen::Vector3d& d) {
    m->template block<1, kCols>(row, 0) -= d.y() * phi_z - d.z() * phi_y;
    m->template block<1, kCols>(row + 1, 0) -= d.z() * phi_x - d.x() * phi_z;
    m->template block<1, kCols>(row + 2, 0) -= d.x() * phi_y - d.y() * phi_x;
  };
  subtract_cross(kPosition, dp);
  subtract_cross(kVelocity, dv);
}

// Returns [d]x m.
Eigen::Matrix3d CrossColumns(const Eigen::Vector3d& d, const Eigen::Matrix3d& m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) result.col(i) = d.cross(m.col(i));
  return result;
}

// Returns R [w]x.
Eigen::Matrix3d RateOf(const Eigen::Matrix3d& R, const Eigen::Vector3d& w) {
  Eigen::Matrix3d result;
  result.col(0) = w.z() * R.col(1) - w.y() * R.col(2);
  result.col(1) = w.x() * R.col(2) - w.z() * R.col(0);
  result.col(2) = w.y() * R.col(0) - w.x() * R.col(1);
  return result;
}

}  // namespace

ImuIntegrator::ImuIntegrator(const ImuNoise& noise)
    : gyroscope_variance_(Square(noise.gyroscope)),
      accelerometer_variance_(Square(noise.accelerometer)),
      gyroscope_walk_variance_(Square(noise.gyroscope_walk)),
      accelerometer_walk_variance_(Square(noise.accelerometer_walk)) {}

void ImuIntegrator::Step(double h, const Knot& from, const Knot& to) {
  const double h2 = h * h;
  // Eq. 2: Magnus expansion to fourth order.
  const Eigen::Vector3d theta =
      0.5 * h * (from.w + to.w) + h2 / 12.0 * (from.dw - to.dw + from.w.cross(to.w));
  const Eigen::Matrix3d R_from = R_;
  q_ = q_ * so3::Exp(theta);
  R_ = q_.toRotationMatrix();

  // Eq. 3, 4: single and double integral of the cubic through g = R a and its slope at both ends.
  const Eigen::Vector3d g_from = R_from * from.a, g_to = R_ * to.a;
  const Eigen::Vector3d dg_from = R_from * (from.w.cross(from.a) + from.da);
  const Eigen::Vector3d dg_to = R_ * (to.w.cross(to.a) + to.da);
  const Eigen::Vector3d dv = 0.5 * h * (g_from + g_to) + h2 / 12.0 * (dg_from - dg_to);
  const Eigen::Vector3d dp =
      h2 * (0.35 * g_from + 0.15 * g_to) + h2 * h * (dg_from / 20.0 - dg_to / 30.0);
  p_ += h * v_ + dp;
  v_ += dv;
  t_ += h;

  const Eigen::Matrix3d A =
      0.5 * h * (R_from + R_) + h2 / 12.0 * (RateOf(R_from, from.w) - RateOf(R_, to.w));
  PropagateErrors(h, dv, dp, A, h2 * (R_from / 3.0 + R_ / 6.0));
}

void ImuIntegrator::PropagateErrors(double h, const Eigen::Vector3d& dv, const Eigen::Vector3d& dp,
                                    const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  // Half of the step's noise is added before the transition and half after it: second order in h.
  const double gyroscope = 0.5 * h * gyroscope_variance_;
  const double accelerometer = 0.5 * h * accelerometer_variance_;
  const auto add_noise = [&] {
    for (int i = 0; i < 3; ++i) {
      panel_(kPhi + i, kPhi + i) += gyroscope;
      panel_(kVelocity + i, kVelocity + i) += accelerometer;
    }
  };
  add_noise();
  ApplyTransition<21>(h, dv, dp, &panel_);
  Eigen::Matrix<double, 9, 9, Eigen::RowMajor> P = panel_.leftCols<9>().transpose();
  ApplyTransition<9>(h, dv, dp, &P);

  // Eq. 6: F_b, and the variance of the biases at the middle of the step.
  Eigen::Matrix<double, 9, 6> F_b;
  F_b << -A, Eigen::Matrix3d::Zero(),    //
      CrossColumns(dv - dp / h, A), -A,  //
      CrossColumns(h / 6.0 * dv, A), -B;
  const double t = t_ - 0.5 * h;
  Eigen::Matrix<double, 9, 6> F_b_P;
  F_b_P.leftCols<3>() = (t * gyroscope_walk_variance_) * F_b.leftCols<3>();
  F_b_P.rightCols<3>() = (t * accelerometer_walk_variance_) * F_b.rightCols<3>();

  auto cross = panel_.middleCols<6>(kCross);
  const Eigen::Matrix<double, 9, 6> G = cross + 0.5 * F_b_P;
  const Eigen::Matrix<double, 9, 9> M = G.lazyProduct(F_b.transpose());
  panel_.leftCols<9>() = P + M + M.transpose();
  cross += F_b_P;
  panel_.middleCols<6>(kJacobian) += F_b;
  add_noise();
}

void ImuIntegrator::Export(ImuDelta* delta, Eigen::Matrix<double, 15, 15>* covariance) const {
  delta->duration = t_;
  delta->q = q_.normalized();
  delta->v = v_;
  delta->p = p_;
  // Converts phi on the left of R to theta on its right: theta = R^T phi.
  Eigen::Matrix<double, 9, 9> to_body = Eigen::Matrix<double, 9, 9>::Identity();
  to_body.topLeftCorner<3, 3>() = R_.transpose();
  delta->bias_jacobian = to_body * panel_.middleCols<6>(kJacobian);

  const Eigen::Matrix<double, 9, 9> P = panel_.leftCols<9>();
  const Eigen::Matrix<double, 9, 6> cross = to_body * panel_.middleCols<6>(kCross);
  covariance->topLeftCorner<9, 9>() = to_body * (0.5 * (P + P.transpose())) * to_body.transpose();
  covariance->topRightCorner<9, 6>() = cross;
  covariance->bottomLeftCorner<6, 9>() = cross.transpose();
  covariance->bottomRightCorner<6, 6>().setZero();
  covariance->diagonal().segment<3>(9).setConstant(t_ * gyroscope_walk_variance_);
  covariance->diagonal().tail<3>().setConstant(t_ * accelerometer_walk_variance_);
}

}  // namespace highwall
