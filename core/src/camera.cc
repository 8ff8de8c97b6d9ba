#include <highwall/core/camera.h>

#include <cmath>

#include <Eigen/LU>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void PinholeCamera::Validate() const {
  RequirePositive(width, "PinholeCamera::width");
  RequirePositive(height, "PinholeCamera::height");
  RequirePositiveFinite(fx, "PinholeCamera::fx");
  RequirePositiveFinite(fy, "PinholeCamera::fy");
  HIGHWALL_REQUIRE(std::isfinite(cx) && std::isfinite(cy),
                   "PinholeCamera::cx and cy must be finite");
  HIGHWALL_REQUIRE(std::isfinite(k1) && std::isfinite(k2) && std::isfinite(p1) &&
                       std::isfinite(p2) && std::isfinite(k3),
                   "PinholeCamera: distortion coefficients must be finite");
}

bool PinholeCamera::HasDistortion() const {
  return k1 != 0.0 || k2 != 0.0 || p1 != 0.0 || p2 != 0.0 || k3 != 0.0;
}

PinholeCamera PinholeCamera::WithoutDistortion() const {
  PinholeCamera c = *this;
  c.k1 = c.k2 = c.p1 = c.p2 = c.k3 = 0.0;
  return c;
}

Eigen::Vector2d PinholeCamera::Distort(const Eigen::Vector2d& m, Eigen::Matrix2d* dm) const {
  const double x = m.x(), y = m.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (dm != nullptr) {
    const double dr = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));  // d(radial)/dx = dr x
    const double off = dr * x * y + 2.0 * (p1 * x + p2 * y);
    *dm << radial + dr * x * x + 2.0 * p1 * y + 6.0 * p2 * x, off,  //
        off, radial + dr * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

Eigen::Vector2d PinholeCamera::Undistort(const Eigen::Vector2d& m_distorted) const {
  if (!HasDistortion()) return m_distorted;
  Eigen::Vector2d m = m_distorted;
  Eigen::Vector2d best = m;
  double best_error = (Distort(m) - m_distorted).squaredNorm();
  constexpr int kMaxIterations = 20;
  for (int i = 0; i < kMaxIterations && best_error > 1e-28; ++i) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d error = Distort(m, &J) - m_distorted;
    const double det = J.determinant();
    if (!(std::abs(det) > 1e-6)) break;
    m -= J.inverse() * error;
    const double e = (Distort(m) - m_distorted).squaredNorm();
    if (!(e < best_error)) break;
    best_error = e;
    best = m;
  }
  return best;
}

Eigen::Vector2d PinholeCamera::Project(const Eigen::Vector3d& p_C,
                                       Eigen::Matrix<double, 2, 3>* duv_dp_C) const {
  const double iz = 1.0 / p_C.z();
  const Eigen::Vector2d m = p_C.head<2>() * iz;
  if (duv_dp_C == nullptr && !HasDistortion()) return {fx * m.x() + cx, fy * m.y() + cy};
  Eigen::Matrix2d dm;
  const Eigen::Vector2d md = Distort(m, duv_dp_C ? &dm : nullptr);
  if (duv_dp_C != nullptr) {
    Eigen::Matrix<double, 2, 3> dm_dp;
    dm_dp << iz, 0.0, -m.x() * iz, 0.0, iz, -m.y() * iz;
    *duv_dp_C = Eigen::Vector2d(fx, fy).asDiagonal() * dm * dm_dp;
  }
  return {fx * md.x() + cx, fy * md.y() + cy};
}

Eigen::Vector3d PinholeCamera::Unproject(const Eigen::Vector2d& uv, double z) const {
  const Eigen::Vector2d m = Undistort({(uv.x() - cx) / fx, (uv.y() - cy) / fy});
  return {m.x() * z, m.y() * z, z};
}

Eigen::Vector2d PinholeCamera::UndistortPixel(const Eigen::Vector2d& uv) const {
  if (!HasDistortion()) return uv;
  const Eigen::Vector2d m = Undistort({(uv.x() - cx) / fx, (uv.y() - cy) / fy});
  return {fx * m.x() + cx, fy * m.y() + cy};
}

bool PinholeCamera::Contains(const Eigen::Vector2d& uv, double margin) const {
  return uv.x() >= margin && uv.y() >= margin && uv.x() <= width - 1 - margin &&
         uv.y() <= height - 1 - margin;
}

}  // namespace highwall
