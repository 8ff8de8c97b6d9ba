#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>

namespace [[gnu::visibility("default")]] highwall {

class LineManifold;

// A straight line in Pluecker coordinates: moment n = p x d for every point p on the line, and
// direction d (not zero; its length scales n). Source: Hartley, Zisserman, "Multiple View
// Geometry", 2nd ed., section 3.2.2.
struct PluckerLine {
  Eigen::Vector3d n = Eigen::Vector3d::UnitX();  // [m] when d is a unit vector
  Eigen::Vector3d d = Eigen::Vector3d::UnitZ();

  // The line through two points, d = (q - p) / |q - p|. Throws InvalidArgument if they coincide
  // (closer than 1e-9 m) or are not finite.
  static PluckerLine FromPoints(const Eigen::Vector3d& p, const Eigen::Vector3d& q);

  // Returns the point of the line that is closest to the origin.
  Eigen::Vector3d ClosestToOrigin() const;
  // Returns the foot of the perpendicular from x.
  Eigen::Vector3d Project(const Eigen::Vector3d& x) const;
  // Distance from x to the line [m].
  double Distance(const Eigen::Vector3d& x) const;
};

// The same line expressed in frame A: n_A = R n_B + p x (R d_B), d_A = R d_B.
PluckerLine operator*(const Pose& T_AB, const PluckerLine& line_B);

// A line in the orthonormal form, 4 degrees of freedom in 6 doubles [q_x q_y q_z q_w | w_1 w_2]:
// U = R(q) = [ n/|n|  d/|d|  (n x d)/|n x d| ],  (w_1, w_2) = (|n|, |d|) / |(|n|, |d|)|.
// Usable as a Ceres parameter block with LineManifold. Source: Bartoli, Sturm 2005, Eq. 2-5.
class OrthonormalLine {
 public:
  static constexpr int kSize = 6;
  using Manifold = LineManifold;

  // The z axis shifted by 1 m along x.
  OrthonormalLine();
  // Lines through the origin are allowed: U's first column is then any normal of d.
  // Throws InvalidArgument if the line is not finite or d is zero.
  explicit OrthonormalLine(const PluckerLine& line);

  // With a unit direction; the moment is in metres.
  PluckerLine Plucker() const { return PluckerFromBlock(data()); }
  // block: 6 doubles as above. w_2 must not be zero (a line at infinity).
  static PluckerLine PluckerFromBlock(const double* block);

  double* data() { return data_.data(); }
  const double* data() const { return data_.data(); }

 private:
  std::array<double, kSize> data_;
};

// A line segment: two end points [m], six contiguous doubles [p | q], a Ceres parameter block.
class Segment3 {
 public:
  static constexpr int kSize = 6;

  Segment3() : data_{} {}
  Segment3(const Eigen::Vector3d& p, const Eigen::Vector3d& q)
      : data_{p.x(), p.y(), p.z(), q.x(), q.y(), q.z()} {}

  Eigen::Vector3d p() const { return Eigen::Map<const Eigen::Vector3d>(data()); }
  Eigen::Vector3d q() const { return Eigen::Map<const Eigen::Vector3d>(data() + 3); }
  double Length() const;

  double* data() { return data_.data(); }
  const double* data() const { return data_.data(); }

 private:
  std::array<double, kSize> data_;
};

// The segment expressed in frame A.
Segment3 operator*(const Pose& T_AB, const Segment3& segment_B);

// Returns the segment of `line` between the feet of the perpendiculars from the end points of
// `segment`: restores the end points after an optimizer has moved the line.
Segment3 TrimTo(const PluckerLine& line, const Segment3& segment);

}  // namespace highwall
