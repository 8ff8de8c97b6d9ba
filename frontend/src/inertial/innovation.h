#pragma once

#include <optional>

#include <highwall/core/pose.h>
#include <highwall/frontend/inertial/visual_pose.h>

#include "inertial/inertial_prior.h"

namespace highwall {

// Degrees of freedom of an innovation: those of a pose.
inline constexpr int kInnovationDof = 6;

// Returns the squared innovation e^T S^-1 e of an image's pose against the one predicted by the
// readings, both in one world, where S is the sum of their covariances: chi-squared with
// kInnovationDof degrees of freedom if both covariances are correct. Empty if the image leaves a
// direction unobservable.
std::optional<double> SquaredInnovation(const CameraPoseEstimate& predicted,
                                        const VisualPose& visual);

// Returns whether readings show an event that did not move the camera, such as an impact on the
// sensor: the image is `squared_innovation` away from their prediction, beyond any noise, and they
// deviate more than it does from the pose `steady`, extrapolated at the velocity of the previous
// images. known_bad: the interval before was contradicted, and this one probably belongs to the
// same event, so that 99 % of chi-squared suffice.
bool AreReadingsContradicted(double squared_innovation, const CameraPoseEstimate& predicted,
                             const Pose& T_WC, const Pose& steady, bool known_bad);

}  // namespace highwall
