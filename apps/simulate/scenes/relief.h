#pragma once

#include <cstdint>
#include <functional>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/materials/scene.h"
#include "simulate/random.h"

// Surfaces that are not flat.
namespace highwall::simulate {

struct ReliefPoint {
  Eigen::Vector3d p_W;  // [m]
  VertexLook look;
};

// A grid of rows x columns points, two triangles to a cell. Its lit side is the one from which the
// columns lie to the left of the direction of ascending rows.
void AddSheet(int rows, int columns, int texture,
              const std::function<ReliefPoint(int row, int column)>& point, Scene* scene);

struct BoulderOptions {
  Eigen::Vector3d radii = {0.3, 0.25, 0.2};  // [m]
  int cuts = 12;                             // planes that break faces off
  int level = 2;                             // 0: 20 triangles, 1: 80, 2: 320
  double sunk = 0.3;                         // [radii] below the origin of T_WB
  float dust = 0.0f;
  float light = 1.0f;
};

// A broken rock: an ellipsoid with faces cut off at random, standing in the origin of B.
void AddBoulder(const Pose& T_WB, const BoulderOptions& options, int texture,
                RandomSequence* random, Scene* scene);

}  // namespace highwall::simulate
