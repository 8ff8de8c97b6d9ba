#include "simulate/scenes/relief.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

namespace highwall::simulate {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;

std::vector<Triangle> Icosahedron() {
  constexpr double kGolden = std::numbers::phi;
  const std::array<Eigen::Vector3d, 12> v = {{{-1, kGolden, 0},
                                              {1, kGolden, 0},
                                              {-1, -kGolden, 0},
                                              {1, -kGolden, 0},
                                              {0, -1, kGolden},
                                              {0, 1, kGolden},
                                              {0, -1, -kGolden},
                                              {0, 1, -kGolden},
                                              {kGolden, 0, -1},
                                              {kGolden, 0, 1},
                                              {-kGolden, 0, -1},
                                              {-kGolden, 0, 1}}};
  constexpr std::array<std::array<std::size_t, 3>, 20> kFaces = {
      {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
       {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  std::vector<Triangle> triangles;
  for (const auto& face : kFaces) {
    triangles.push_back(
        {v[face[0]].normalized(), v[face[1]].normalized(), v[face[2]].normalized()});
  }
  return triangles;
}

// Splits every triangle into four, on the unit sphere.
std::vector<Triangle> Refine(const std::vector<Triangle>& triangles) {
  std::vector<Triangle> finer;
  for (const auto& [a, b, c] : triangles) {
    const Eigen::Vector3d ab = (a + b).normalized(), bc = (b + c).normalized(),
                          ca = (c + a).normalized();
    finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return finer;
}

Eigen::Vector3d RandomDirection(RandomSequence* random) {
  const double z = random->Uniform(-1.0, 1.0), r = std::sqrt(1.0 - z * z);
  const double azimuth = random->Uniform(-std::numbers::pi, std::numbers::pi);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

}  // namespace

void AddSheet(int rows, int columns, int texture,
              const std::function<ReliefPoint(int row, int column)>& point, Scene* scene) {
  const int surface = scene->AddRelief(texture);
  const auto first = static_cast<std::uint32_t>(scene->mesh.vertices.size());
  const auto stride = static_cast<std::uint32_t>(columns);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const ReliefPoint p = point(i, j);
      scene->AddVertex(p.p_W, p.look);
      if (i == 0 || j == 0) continue;
      const std::uint32_t d =
          first + static_cast<std::uint32_t>(i) * stride + static_cast<std::uint32_t>(j);
      const std::uint32_t c = d - 1, b = d - stride, a = b - 1;
      // a and b in one row, c and d in the next; alternating diagonals avoid a visible pattern.
      if ((i + j) % 2 == 0) {
        scene->AddTriangle({a, c, d}, surface);
        scene->AddTriangle({a, d, b}, surface);
      } else {
        scene->AddTriangle({a, c, b}, surface);
        scene->AddTriangle({c, d, b}, surface);
      }
    }
  }
}

void AddBoulder(const Pose& T_WB, const BoulderOptions& options, int texture,
                RandomSequence* random, Scene* scene) {
  std::vector<Triangle> triangles = Icosahedron();
  for (int i = 0; i < options.level; ++i) triangles = Refine(triangles);
  struct Cut {
    Eigen::Vector3d normal;
    double distance;
  };
  std::vector<Cut> cuts;
  for (int i = 0; i < options.cuts; ++i) {
    cuts.push_back({RandomDirection(random), random->Uniform(0.55, 0.9)});
  }
  const Eigen::Vector3d up(0.0, 0.0, (1.0 - options.sunk) * options.radii.z());
  const Eigen::Vector2f place{static_cast<float>(random->Uniform(1.0, 3.0)),
                              static_cast<float>(random->Uniform(1.0, 3.0))};
  const int surface = scene->AddRelief(texture);
  for (Triangle& triangle : triangles) {
    for (Eigen::Vector3d& p : triangle) {
      for (const Cut& cut : cuts) {
        p -= std::max(0.0, p.dot(cut.normal) - cut.distance) * cut.normal;
      }
      p = p.cwiseProduct(options.radii);
    }
    // Every face has its own vertices, so that edges stay sharp. Its texture is projected along the
    // axis closest to its normal.
    const Eigen::Vector3d normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    Eigen::Index axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    std::array<std::uint32_t, 3> vertices{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2d st(triangle[k][(axis + 1) % 3], triangle[k][(axis + 2) % 3]);
      vertices[k] = scene->AddVertex(
          T_WB * (triangle[k] + up),
          {.st = st.cast<float>() + place, .dust = options.dust, .light = options.light});
    }
    scene->AddTriangle(vertices, surface);
  }
}

}  // namespace highwall::simulate
