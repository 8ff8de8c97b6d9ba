#include <highwall/core/camera.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

// theta' = theta (1 + k1 theta^2 + ...), and its derivative by theta.
struct BentAngle {
  double value, slope;
};

BentAngle Bend(const PinholeCamera& c, double theta) {
  const double t2 = theta * theta;
  return {theta * (1.0 + t2 * (c.k1 + t2 * (c.k2 + t2 * (c.k3 + t2 * c.k4)))),
          1.0 + t2 * (3.0 * c.k1 + t2 * (5.0 * c.k2 + t2 * (7.0 * c.k3 + t2 * 9.0 * c.k4)))};
}

Eigen::Vector2d DistortEquidistant(const PinholeCamera& c, const Eigen::Vector2d& m,
                                   Eigen::Matrix2d* dm) {
  constexpr double kCentre = 1e-8;  // where the error of the first order is below 1e-16
  const double r = m.norm();
  if (r < kCentre) {
    if (dm != nullptr) dm->setIdentity();
    return m;
  }
  const BentAngle bent = Bend(c, std::atan(r));
  const double scale = bent.value / r;
  if (dm != nullptr) {
    const double slope = (bent.slope / (1.0 + r * r) - scale) / r;  // d(scale)/dr
    *dm = scale * Eigen::Matrix2d::Identity() + slope / r * m * m.transpose();
  }
  return scale * m;
}

Eigen::Vector2d UndistortEquidistant(const PinholeCamera& c, const Eigen::Vector2d& m_distorted) {
  constexpr double kLargest = 80.0 * std::numbers::pi / 180.0;  // [rad]
  constexpr int kMaxIterations = 20;
  const double bent = m_distorted.norm();
  if (bent == 0.0) return m_distorted;
  double theta = std::min(bent, kLargest);
  for (int i = 0; i < kMaxIterations; ++i) {
    const BentAngle at = Bend(c, theta);
    const double step = (at.value - bent) / at.slope;
    if (!(at.slope > 0.0) || !(std::abs(step) > 1e-16)) break;
    theta = std::clamp(theta - step, 0.0, kLargest);
  }
  return std::tan(theta) / bent * m_distorted;
}

}  // namespace

void PinholeCamera::Validate() const {
  RequirePositive(width, "PinholeCamera::width");
  RequirePositive(height, "PinholeCamera::height");
  RequirePositiveFinite(fx, "PinholeCamera::fx");
  RequirePositiveFinite(fy, "PinholeCamera::fy");
  HIGHWALL_REQUIRE(std::isfinite(cx) && std::isfinite(cy),
                   "PinholeCamera::cx and cy must be finite");
  for (const double coefficient : {k1, k2, p1, p2, k3, k4, k5, k6}) {
    HIGHWALL_REQUIRE(std::isfinite(coefficient),
                     "PinholeCamera: distortion coefficients must be finite");
  }
  HIGHWALL_REQUIRE(
      lens != LensModel::kEquidistant || (p1 == 0.0 && p2 == 0.0 && k5 == 0.0 && k6 == 0.0),
      "PinholeCamera: an equidistant lens has only k1, k2, k3 and k4");
}

bool PinholeCamera::HasDistortion() const {
  return lens == LensModel::kEquidistant || k1 != 0.0 || k2 != 0.0 || p1 != 0.0 || p2 != 0.0 ||
         k3 != 0.0 || k4 != 0.0 || k5 != 0.0 || k6 != 0.0;
}

PinholeCamera PinholeCamera::WithoutDistortion() const {
  return {.width = width, .height = height, .fx = fx, .fy = fy, .cx = cx, .cy = cy};
}

Eigen::Vector2d PinholeCamera::Distort(const Eigen::Vector2d& m, Eigen::Matrix2d* dm) const {
  if (lens == LensModel::kEquidistant) return DistortEquidistant(*this, m, dm);
  const double x = m.x(), y = m.y();
  const double r2 = x * x + y * y;
  const double above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double radial = above / below;
  if (dm != nullptr) {
    // d(radial)/dx = dr x
    const double dr = 2.0 *
                      (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3) -
                       radial * (k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6))) /
                      below;
    const double off = dr * x * y + 2.0 * (p1 * x + p2 * y);
    *dm << radial + dr * x * x + 2.0 * p1 * y + 6.0 * p2 * x, off,  //
        off, radial + dr * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

Eigen::Vector2d PinholeCamera::Undistort(const Eigen::Vector2d& m_distorted) const {
  if (!HasDistortion()) return m_distorted;
  if (lens == LensModel::kEquidistant) return UndistortEquidistant(*this, m_distorted);
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
