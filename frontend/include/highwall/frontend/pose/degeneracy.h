#pragma once

#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/pose/options.h>

namespace highwall {

// A small motion of the camera that its image hardly tells: translation and rotation in C, the
// rotation as the way it moves a point at the depth of the scene, so that the two compare.
struct OpenDirection {
  Eigen::Vector3d translation_C = Eigen::Vector3d::Zero();  // together with the rotation of
  Eigen::Vector3d rotation_C = Eigen::Vector3d::Zero();     // length 1
  double sigma = 0.0;  // [m] along it; infinite where nothing at all is known
};

// The eigen-directions of a pose's information that are open, the most open one first. information:
// 6 x 6, of a PoseSolution, in the tangent of PoseManifold at T_WC. depth [m] > 0: of the scene, at
// which a rotation by 1 rad counts as a motion by so much. Throws InvalidArgument where depth is
// not positive or the information not finite.
// Source: eigenvalues as in Zhang, Kaess, Singh, "On degeneracy of optimization-based state
// estimation problems", ICRA 2016, section IV, here of whitened rows: their inverses are variances.
std::vector<OpenDirection> FindOpenDirections(const Eigen::Matrix<double, 6, 6>& information,
                                              const Pose& T_WC, double depth,
                                              const DegeneracyOptions& options = {});

}  // namespace highwall
