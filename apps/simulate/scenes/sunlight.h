#pragma once

#include <Eigen/Core>

#include "simulate/materials/scene.h"

namespace highwall::simulate {

struct SunlightOptions {
  Eigen::Vector3d to_sun = {-0.45, -0.6, 0.66};  // of any length
  double sun = 1.15;                             // irradiance of a surface that faces the sun
  double sky = 0.75;                             // of one that sees the whole sky
};

// Multiplies the light of every vertex by its irradiance from the sun, unless occluded, and from
// the visible part of the sky, on flat surfaces and reliefs. threads: 0 = one per processor; the
// result does not depend on it.
void BakeSunlight(const SunlightOptions& options, Scene* scene, int threads = 0);

}  // namespace highwall::simulate
