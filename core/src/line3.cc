#include <highwall/core/line3.h>

#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

PluckerLine PluckerLine::FromPoints(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  HIGHWALL_REQUIRE(p.allFinite() && q.allFinite(), "PluckerLine: the points must be finite");
  const double length = (q - p).norm();
  HIGHWALL_REQUIRE(length > 1e-9, "PluckerLine: the two points must not coincide");
  const Eigen::Vector3d d = (q - p) / length;
  return {p.cross(d), d};
}

Eigen::Vector3d PluckerLine::ClosestToOrigin() const {
  return d.cross(n) / d.squaredNorm();
}

Eigen::Vector3d PluckerLine::Project(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d foot = ClosestToOrigin();
  return foot + d * (d.dot(x - foot) / d.squaredNorm());
}

double PluckerLine::Distance(const Eigen::Vector3d& x) const {
  return (x - Project(x)).norm();
}

PluckerLine operator*(const Pose& T_AB, const PluckerLine& line_B) {
  const Eigen::Vector3d d_A = T_AB.q() * line_B.d;
  return {T_AB.q() * line_B.n + T_AB.p().cross(d_A), d_A};
}

OrthonormalLine::OrthonormalLine()
    : OrthonormalLine(PluckerLine{-Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}) {}

OrthonormalLine::OrthonormalLine(const PluckerLine& line) {
  HIGHWALL_REQUIRE(line.n.allFinite() && line.d.allFinite(),
                   "OrthonormalLine: the line must be finite");
  const double d_norm = line.d.norm();
  HIGHWALL_REQUIRE(d_norm > 1e-12, "OrthonormalLine: the direction must not be zero");
  const Eigen::Vector3d u2 = line.d / d_norm;
  // Removes the component of n along d, which is due to rounding.
  const Eigen::Vector3d n = line.n - u2 * u2.dot(line.n);
  const double n_norm = n.norm();
  const Eigen::Vector3d u1 =
      n_norm > 1e-12 * d_norm ? Eigen::Vector3d(n / n_norm) : Eigen::Vector3d(u2.unitOrthogonal());
  Eigen::Matrix3d U;
  U << u1, u2, u1.cross(u2);
  Eigen::Map<Eigen::Vector4d> q(data());
  q = Eigen::Quaterniond(U).normalized().coeffs();
  const double norm = std::hypot(n_norm, d_norm);
  data_[4] = n_norm / norm;
  data_[5] = d_norm / norm;
}

PluckerLine OrthonormalLine::PluckerFromBlock(const double* block) {
  const Eigen::Matrix3d U = Eigen::Map<const Eigen::Quaterniond>(block).toRotationMatrix();
  return {U.col(0) * (block[4] / block[5]), U.col(1)};
}

double Segment3::Length() const {
  return (q() - p()).norm();
}

Segment3 operator*(const Pose& T_AB, const Segment3& segment_B) {
  return Segment3(T_AB * segment_B.p(), T_AB * segment_B.q());
}

Segment3 TrimTo(const PluckerLine& line, const Segment3& segment) {
  return Segment3(line.Project(segment.p()), line.Project(segment.q()));
}

}  // namespace highwall
