#pragma once

#include <vector>

#include <Eigen/Core>

namespace highwall::simulate {

// Line driven by a vehicle: a closed uniform cubic B-spline, parameterized by arc length.
class Course {
 public:
  // Axes of the road at a point: forward and left are horizontal unit vectors.
  struct Frame {
    Eigen::Vector3d p_W;  // [m]
    Eigen::Vector3d forward, left;

    // Returns the point `left_offset` metres to the left of the line and `up` metres above it.
    Eigen::Vector3d Point(double left_offset, double up) const {
      return p_W + left_offset * left + up * Eigen::Vector3d::UnitZ();
    }
  };

  // control: at least 4 points [m]; the line passes near, not through them. Throws InvalidArgument.
  explicit Course(std::vector<Eigen::Vector3d> control);

  // Horizontal length of the line, [m].
  double length() const { return lengths_.back(); }
  // s [m]: any; the line repeats every length().
  Frame At(double s) const;

 private:
  // Returns point and derivative at u of [0, control_.size()).
  void Evaluate(double u, Eigen::Vector3d* point, Eigen::Vector3d* derivative) const;

  std::vector<Eigen::Vector3d> control_;
  std::vector<double> lengths_;  // up to each of the equal steps of u
};

}  // namespace highwall::simulate
