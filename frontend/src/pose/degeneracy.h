#pragma once

#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/pose/options.h>
#include <highwall/frontend/pose/pose_report.h>

namespace highwall {

// Returns the unobservable (degenerate) directions of a pose: eigenvectors of its information, that
// with the least information first. information: 6 x 6, of a PoseSolution, in the tangent of
// PoseManifold at T_WC. depth [m] > 0: of the scene; a rotation by 1 rad counts as a motion by this
// distance. Throws InvalidArgument if depth is not positive or the information not finite.
// Source: eigenvalues as in Zhang, Kaess, Singh, "On degeneracy of optimization-based state
// estimation problems", ICRA 2016, section IV, here of whitened rows: their inverses are variances.
std::vector<UnobservableDirection> FindUnobservableDirections(
    const Eigen::Matrix<double, 6, 6>& information, const Pose& T_WC, double depth,
    const DegeneracyOptions& options = {});

}  // namespace highwall
