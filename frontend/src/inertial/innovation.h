#pragma once

#include <optional>

#include <highwall/core/pose.h>

#include "inertial/inertial_prior.h"
#include "inertial/visual_pose.h"

namespace highwall {

// Degrees of freedom of an innovation: those of a pose.
inline constexpr int kInnovationDof = 6;

// The squared innovation e^T S^-1 e of an image's pose against the one that the readings predict,
// both in one world, S being the sum of their covariances: chi-squared of kInnovationDof where
// both are what they state. None where the image leaves a direction open.
std::optional<double> SquaredInnovation(const CameraPoseEstimate& predicted,
                                        const VisualPose& visual);

// Whether readings tell of something that did not move the camera, such as a blow to the sensor:
// the image is `squared_innovation` away from what they predict, beyond any noise, and they depart
// further than it does from the pose `steady` that the camera would have had at the velocity of the
// images before. known_bad: the interval before was contradicted, and this one is likely to be of
// the same event: 99 % of chi-squared are enough.
bool AreReadingsContradicted(double squared_innovation, const CameraPoseEstimate& predicted,
                             const Pose& T_WC, const Pose& steady, bool known_bad);

}  // namespace highwall
