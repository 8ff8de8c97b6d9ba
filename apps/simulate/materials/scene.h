#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/materials/texture.h"

namespace highwall::simulate {

// Triangles in the world frame, [m]. Surfaces are two-sided; with baked light (sunlight.h), the lit
// side is the one from which the vertices appear anticlockwise.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of vertices
};

// Group of triangles with one texture. Flat: one plane, texture coordinates along its axes, s =
// s_axis . (p_W - origin), t likewise. Relief: each triangle has its own plane, the vertices have
// texture coordinates, and the plane below is unused.
struct Surface {
  Eigen::Vector3d origin;          // [m]
  Eigen::Vector3d s_axis, t_axis;  // unit, orthogonal, in the plane
  Eigen::Vector3d normal;          // s_axis x t_axis
  int texture = 0;                 // index of Scene::textures
  bool relief = false;
  float magnification = 1.0f;  // > 0; flat: magnification of the texture
};

// Additional attributes of a vertex; linear within a triangle.
struct VertexLook {
  Eigen::Vector2f st = {0.0f, 0.0f};  // [m] texture coordinates of a relief
  float dust = 0.0f;                  // [0, 1] share of the texture covered by dust
  float light = 1.0f;                 // irradiance
};

// Point light with irradiance power / (distance^2 + 1) on a surface that faces it.
struct Light {
  Eigen::Vector3d p_W;  // [m]
  double power = 1.0;
};

// Radiance of the sky, linear in the sine of elevation. Black by default.
struct Sky {
  Colour horizon = Colour::Zero();
  Colour zenith = Colour::Zero();
};

// Textures of the faces of a box in its own frame; indices of Scene::textures.
struct BoxTextures {
  int sides = 0;  // -x, +x, +y and below
  int front = 0;  // -y
  int top = 0;    // +z
};

struct Scene {
  Mesh mesh;
  // One per vertex, or none: then all surfaces are flat, clean, and lit by `lights`.
  std::vector<VertexLook> looks;
  std::vector<int> surface_of_triangle;
  std::vector<Surface> surfaces;
  std::vector<std::shared_ptr<const Texture>> textures;  // shared by the copies of a scene
  std::vector<Light> lights;
  double ambient = 0.6;
  Colour dust = Rgb(0.62, 0.55, 0.46);
  Sky sky;

  // Returns its index.
  int AddTexture(std::unique_ptr<const Texture> texture);
  // Adds an empty relief and returns the index of its surface.
  int AddRelief(int texture);
  // Adds a vertex to the mesh and returns its index.
  std::uint32_t AddVertex(const Eigen::Vector3d& p_W, const VertexLook& look);
  void AddTriangle(const std::array<std::uint32_t, 3>& vertices, int surface);
  // corner, corner + edge_s, corner + edge_s + edge_t, corner + edge_t; edges orthogonal [m].
  void AddRectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_s,
                    const Eigen::Vector3d& edge_t, int texture);
  // Adds the box |x| <= size.x / 2, |y| <= size.y / 2, 0 <= z <= size.z of frame B.
  void AddBox(const Pose& T_WB, const Eigen::Vector3d& size, const BoxTextures& textures);
};

}  // namespace highwall::simulate
