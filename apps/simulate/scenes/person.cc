#include "simulate/scenes/person.h"

#include <cmath>
#include <memory>

#include <Eigen/Geometry>

namespace highwall::simulate {
namespace {

using Eigen::Vector3d;

BoxTextures Paint(const Colour& colour, float contrast, Scene* scene) {
  const int paint = scene->AddTexture(std::make_unique<NoiseTexture>(
      colour, contrast, ValueNoise{.wavelength = 0.15f, .octaves = 4, .seed = 8}));
  return {paint, paint, paint};
}

BoxTextures MakeVest(Scene* scene) {
  const int vest = scene->AddTexture(
      std::make_unique<MasonryTexture>(MasonryOptions{.cell = {5.0f, 0.16f},
                                                      .joint = 0.0f,
                                                      .shift = 0.0f,
                                                      .checker = true,
                                                      .first = Rgb(0.95, 0.5, 0.05),
                                                      .second = Rgb(0.85, 0.85, 0.8),
                                                      .contrast = 0.2f}));
  return {vest, vest, vest};
}

Pose MovedTo(const Vector3d& p) {
  return Pose(Eigen::Quaterniond::Identity(), p);
}

}  // namespace

void AddPerson(const Pose& T_WB, double stride, Scene* scene) {
  constexpr double kHip = 0.85, kSwing = 0.4;  // [m], [rad]
  const BoxTextures trousers = Paint(Rgb(0.15, 0.2, 0.35), 0.3f, scene);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Quaterniond q(
        Eigen::AngleAxisd(side * kSwing * std::sin(stride), Vector3d::UnitY()));
    const Pose T_WL = T_WB * Pose(q, Vector3d(0, 0.1 * side, kHip)) * MovedTo({0, 0, -kHip});
    scene->AddBox(T_WL, {0.15, 0.14, kHip}, trousers);
  }
  scene->AddBox(T_WB * MovedTo({0, 0, kHip}), {0.24, 0.42, 0.6}, MakeVest(scene));
  scene->AddBox(T_WB * MovedTo({0, 0, kHip + 0.62}), {0.2, 0.18, 0.24},
                Paint(Rgb(0.75, 0.72, 0.2), 0.2f, scene));
}

}  // namespace highwall::simulate
