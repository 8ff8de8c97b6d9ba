#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/texture.h"

namespace highwall::simulate {

// Triangles in the world frame, [m]. Their winding carries no meaning: surfaces are two-sided.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of vertices
};

// The plane that a group of triangles lies in, and its texture coordinates:
// s = s_axis . (p_W - origin), t likewise.
struct Surface {
  Eigen::Vector3d origin;          // [m]
  Eigen::Vector3d s_axis, t_axis;  // unit, orthogonal, in the plane
  Eigen::Vector3d normal;          // s_axis x t_axis
  int texture = 0;                 // index of Scene::textures
};

// A point light: irradiance power / (distance^2 + 1) on a surface that faces it.
struct Light {
  Eigen::Vector3d p_W;  // [m]
  double power = 1.0;
};

// The faces of a box in its own frame; an index of Scene::textures each.
struct BoxTextures {
  int sides = 0;  // -x, +x, +y and below
  int front = 0;  // -y
  int top = 0;    // +z
};

struct Scene {
  Mesh mesh;
  std::vector<int> surface_of_triangle;
  std::vector<Surface> surfaces;
  std::vector<std::unique_ptr<const Texture>> textures;
  std::vector<Light> lights;
  double ambient = 0.6;

  // Returns its index.
  int AddTexture(std::unique_ptr<const Texture> texture);
  // corner, corner + edge_s, corner + edge_s + edge_t, corner + edge_t; edges orthogonal [m].
  void AddRectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_s,
                    const Eigen::Vector3d& edge_t, int texture);
  // The box |x| <= size.x / 2, |y| <= size.y / 2, 0 <= z <= size.z of frame B.
  void AddBox(const Pose& T_WB, const Eigen::Vector3d& size, const BoxTextures& textures);
};

}  // namespace highwall::simulate
