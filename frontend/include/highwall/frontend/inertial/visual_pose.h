#pragma once

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/inertial/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Camera pose from an image, as a Gaussian in the tangent of PoseManifold at T_WC.
struct VisualPose {
  Pose T_WC;  // the most likely pose
  // W, 6 x 6: W^T W is the information [1/m^2, 1/rad^2]. Of less than full rank if the image leaves
  // a direction unobservable, with a row of zeros for each.
  Eigen::Matrix<double, 6, 6> sqrt_information = Eigen::Matrix<double, 6, 6>::Zero();
};

// Condenses J^T J = information and J^T r = gradient at T_WC (PoseSolution) to a pose. error: |r|^2
// per degree of freedom, which scales the covariance by the actual fit of the landmarks. Directions
// without information are left unchanged, with a row of zeros.
VisualPose MakeVisualPose(const Pose& T_WC, const Eigen::Matrix<double, 6, 6>& information,
                          const Eigen::Matrix<double, 6, 1>& gradient, double error = 1.0,
                          const VisualNoise& noise = {});

// Returns the same pose in a world that was transformed by T_new_old.
VisualPose Moved(const VisualPose& visual, const Pose& T_new_old);

}  // namespace highwall
