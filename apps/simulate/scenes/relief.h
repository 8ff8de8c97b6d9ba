#pragma once

#include <cstdint>
#include <functional>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/materials/scene.h"
#include "simulate/random.h"

// Non-flat surfaces.
namespace highwall::simulate {

struct ReliefPoint {
  Eigen::Vector3d p_W;  // [m]
  VertexLook look;
};

// Adds a grid of rows x columns points with two triangles per cell. Its lit side is the one from
// which the columns lie to the left of the direction of ascending rows.
void AddSheet(int rows, int columns, int texture,
              const std::function<ReliefPoint(int row, int column)>& point, Scene* scene);

struct BoulderOptions {
  Eigen::Vector3d radii = {0.3, 0.25, 0.2};  // [m]
  int cuts = 12;                             // planes that cut off facets
  int level = 2;                             // 0: 20 triangles, 1: 80, 2: 320
  double sunk = 0.3;                         // [radii] below the origin of T_WB
  float dust = 0.0f;
  float light = 1.0f;
};

// Adds a broken rock: an ellipsoid with random facets, standing in the origin of B.
void AddBoulder(const Pose& T_WB, const BoulderOptions& options, int texture,
                RandomSequence* random, Scene* scene);

}  // namespace highwall::simulate
