#pragma once

#include <vector>

#include <highwall/core/pose.h>

namespace highwall::simulate {

// A closed trajectory, twice continuously differentiable: a uniform cubic B-spline of positions
// and a cumulative one of rotations.
// Source: Lovegrove, Patron-Perez, Sibley, "Spline Fusion", BMVC 2013, equations 3 to 5.
class SplineTrajectory {
 public:
  // control: T_WC, one every period / control.size() seconds, at least 4; the curve passes near,
  // not through them. Neighbours (the first follows the last) lie less than pi apart in rotation.
  // period [s] > 0. Throws InvalidArgument.
  SplineTrajectory(std::vector<Pose> control, double period);

  double period() const { return period_; }
  // t [s]: any; the curve repeats every period.
  Pose T_WC(double t) const;

 private:
  std::vector<Pose> control_;
  double period_;
};

}  // namespace highwall::simulate
