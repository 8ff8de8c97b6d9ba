#pragma once

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/inertial/options.h>

namespace highwall {

// What an image says about its camera's pose, as a Gaussian in the tangent of PoseManifold at T_WC.
struct VisualPose {
  Pose T_WC;  // the most likely pose
  // W, 6 x 6: W^T W is the information [1/m^2, 1/rad^2]. Of less than full rank where the image
  // leaves a direction open: a row of zeros for each.
  Eigen::Matrix<double, 6, 6> sqrt_information = Eigen::Matrix<double, 6, 6>::Zero();
};

// Sums up J^T J = information and J^T r = gradient at T_WC (PoseSolution). error: |r|^2 per degree
// of freedom, which scales the covariance: the landmarks themselves tell how well they fit.
// Directions without information stay as they are, with a row of zeros.
VisualPose MakeVisualPose(const Pose& T_WC, const Eigen::Matrix<double, 6, 6>& information,
                          const Eigen::Matrix<double, 6, 1>& gradient, double error = 1.0,
                          const VisualNoise& noise = {});

// The same in a world that was moved by T_new_old.
VisualPose Moved(const VisualPose& visual, const Pose& T_new_old);

}  // namespace highwall
