#include "simulate/scenes/sunlight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "simulate/camera/raycaster.h"
#include "simulate/parallel_for.h"

namespace highwall::simulate {
namespace {

constexpr int kSkyDirections = 12;
constexpr double kSkyReach = 6.0;  // [m] more distant objects do not occlude the sky
constexpr double kLift = 0.01;     // [m] above the surface, to avoid self-shadowing
constexpr int kBlock = 1024;       // vertices per task

std::vector<Eigen::Vector3d> VertexNormals(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& corner = mesh.vertices[a];
    const Eigen::Vector3d twice_area = (mesh.vertices[b] - corner).cross(mesh.vertices[c] - corner);
    for (const std::uint32_t index : {a, b, c}) normals[index] += twice_area;
  }
  for (Eigen::Vector3d& normal : normals) normal.normalize();
  return normals;
}

// Returns directions over the upper hemisphere, weighted by the sine of elevation.
std::array<Eigen::Vector3d, kSkyDirections> SkyDirections() {
  std::array<Eigen::Vector3d, kSkyDirections> directions;
  for (int k = 0; k < kSkyDirections; ++k) {
    const double z = std::sqrt((k + 0.5) / kSkyDirections), r = std::sqrt(1.0 - z * z);
    const double azimuth = k * std::numbers::pi * (3.0 - std::sqrt(5.0));
    directions[static_cast<std::size_t>(k)] = {r * std::cos(azimuth), r * std::sin(azimuth), z};
  }
  return directions;
}

}  // namespace

void BakeSunlight(const SunlightOptions& options, Scene* scene, int threads) {
  const Mesh& mesh = scene->mesh;
  scene->looks.resize(mesh.vertices.size());
  const Raycaster raycaster(mesh);
  const std::vector<Eigen::Vector3d> normals = VertexNormals(mesh);
  const auto sky_directions = SkyDirections();
  const Eigen::Vector3d to_sun = options.to_sun.normalized();

  const auto irradiance = [&](std::size_t i) {
    const Eigen::Vector3d& normal = normals[i];
    const Eigen::Vector3d p_W = mesh.vertices[i] + kLift * normal;
    double sky = 0.0, possible = 0.0;
    for (const Eigen::Vector3d& direction : sky_directions) {
      const double facing = std::max(0.0, normal.dot(direction));
      possible += std::max(0.0, direction.z());
      if (facing > 0.0 && raycaster.IsFree(p_W, direction, kSkyReach)) sky += facing;
    }
    constexpr double kReflected = 0.22;  // by the surroundings
    double sum = options.sky * (kReflected + (1.0 - kReflected) * sky / possible);
    const double facing_sun = normal.dot(to_sun);
    constexpr double kFar = 1e3;
    if (facing_sun > 0.0 && raycaster.IsFree(p_W, to_sun, kFar)) sum += options.sun * facing_sun;
    return sum;
  };
  const auto count = mesh.vertices.size();
  ParallelFor(static_cast<int>((count + kBlock - 1) / kBlock), threads, [&](int block) {
    const std::size_t begin = static_cast<std::size_t>(block) * kBlock;
    for (std::size_t i = begin; i < std::min(count, begin + kBlock); ++i) {
      scene->looks[i].light *= static_cast<float>(irradiance(i));
    }
  });
}

}  // namespace highwall::simulate
