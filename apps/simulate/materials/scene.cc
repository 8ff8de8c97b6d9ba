#include "simulate/materials/scene.h"

#include <utility>

namespace highwall::simulate {

int Scene::AddTexture(std::unique_ptr<const Texture> texture) {
  textures.push_back(std::move(texture));
  return static_cast<int>(textures.size()) - 1;
}

int Scene::AddRelief(int texture) {
  surfaces.push_back({.origin = Eigen::Vector3d::Zero(),
                      .s_axis = Eigen::Vector3d::UnitX(),
                      .t_axis = Eigen::Vector3d::UnitY(),
                      .normal = Eigen::Vector3d::UnitZ(),
                      .texture = texture,
                      .relief = true});
  return static_cast<int>(surfaces.size()) - 1;
}

std::uint32_t Scene::AddVertex(const Eigen::Vector3d& p_W, const VertexLook& look) {
  const auto index = static_cast<std::uint32_t>(mesh.vertices.size());
  looks.resize(mesh.vertices.size());  // earlier flat surfaces have none yet
  mesh.vertices.push_back(p_W);
  looks.push_back(look);
  return index;
}

void Scene::AddTriangle(const std::array<std::uint32_t, 3>& vertices, int surface) {
  mesh.triangles.push_back(vertices);
  surface_of_triangle.push_back(surface);
}

void Scene::AddRectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_s,
                         const Eigen::Vector3d& edge_t, int texture) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(),
                       {corner, corner + edge_s, corner + edge_s + edge_t, corner + edge_t});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  const int surface = static_cast<int>(surfaces.size());
  surface_of_triangle.insert(surface_of_triangle.end(), 2, surface);
  const Eigen::Vector3d s = edge_s.normalized(), t = edge_t.normalized();
  surfaces.push_back({corner, s, t, s.cross(t), texture});
}

void Scene::AddBox(const Pose& T_WB, const Eigen::Vector3d& size, const BoxTextures& box) {
  const Eigen::Vector3d x = T_WB.q() * Eigen::Vector3d(size.x(), 0, 0);
  const Eigen::Vector3d y = T_WB.q() * Eigen::Vector3d(0, size.y(), 0);
  const Eigen::Vector3d z = T_WB.q() * Eigen::Vector3d(0, 0, size.z());
  const Eigen::Vector3d front_left = T_WB.p() - 0.5 * (x + y);
  const Eigen::Vector3d back_right = T_WB.p() + 0.5 * (x + y);
  AddRectangle(front_left, x, z, box.front);
  AddRectangle(front_left + x, y, z, box.sides);
  AddRectangle(back_right, -x, z, box.sides);
  AddRectangle(front_left + y, -y, z, box.sides);
  AddRectangle(front_left + z, x, y, box.top);
  AddRectangle(front_left + y, x, -y, box.sides);
}

}  // namespace highwall::simulate
