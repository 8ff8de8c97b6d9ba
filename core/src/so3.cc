#include <highwall/core/so3.h>

#include <cmath>

namespace highwall::so3 {
namespace {

// Below this squared angle the closed forms lose digits to cancellation, and the series, truncated
// after its theta^4 term, is exact to rounding (theta^6 / 1e4 < 1e-16).
constexpr double kSmallAngleSquared = 1e-4;

}  // namespace

Eigen::Matrix3d Hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Quaterniond Exp(const Eigen::Vector3d& theta) {
  const double t2 = theta.squaredNorm();
  double w, k;  // q = [k theta, w],  k = sin(|theta| / 2) / |theta|
  if (t2 < kSmallAngleSquared) {
    k = 0.5 - t2 / 48.0 + t2 * t2 / 3840.0;
    w = 1.0 - t2 / 8.0 + t2 * t2 / 384.0;
  } else {
    const double t = std::sqrt(t2);
    k = std::sin(0.5 * t) / t;
    w = std::cos(0.5 * t);
  }
  return Eigen::Quaterniond(w, k * theta.x(), k * theta.y(), k * theta.z());
}

Eigen::Vector3d Log(const Eigen::Quaterniond& q) {
  // The sign makes q and -q equivalent and keeps the angle in [0, pi].
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d v = sign * q.vec();
  const double w = sign * q.w();
  const double n2 = v.squaredNorm();
  if (n2 < 0.25 * kSmallAngleSquared) {
    // atan2(n, w) / n for small n / w.
    const double x2 = n2 / (w * w);
    return v * (2.0 / w) * (1.0 - x2 / 3.0 + x2 * x2 / 5.0);
  }
  const double n = std::sqrt(n2);
  return v * (2.0 * std::atan2(n, w) / n);
}

Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& theta) {
  const double t2 = theta.squaredNorm();
  double a, b;  // Jr = I - a Hat + b Hat^2
  if (t2 < kSmallAngleSquared) {
    a = 0.5 - t2 / 24.0 + t2 * t2 / 720.0;
    b = 1.0 / 6.0 - t2 / 120.0 + t2 * t2 / 5040.0;
  } else {
    const double t = std::sqrt(t2);
    a = (1.0 - std::cos(t)) / t2;
    b = (t - std::sin(t)) / (t2 * t);
  }
  const Eigen::Matrix3d hat = Hat(theta);
  return Eigen::Matrix3d::Identity() - a * hat + b * hat * hat;
}

Eigen::Matrix3d RightJacobianInverse(const Eigen::Vector3d& theta) {
  const double t2 = theta.squaredNorm();
  double b;  // Jr^-1 = I + Hat / 2 + b Hat^2
  if (t2 < kSmallAngleSquared) {
    b = 1.0 / 12.0 + t2 / 720.0 + t2 * t2 / 30240.0;
  } else {
    const double half = 0.5 * std::sqrt(t2);
    b = (1.0 - half * std::cos(half) / std::sin(half)) / t2;
  }
  const Eigen::Matrix3d hat = Hat(theta);
  return Eigen::Matrix3d::Identity() + 0.5 * hat + b * hat * hat;
}

}  // namespace highwall::so3
