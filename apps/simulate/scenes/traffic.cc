#include "simulate/scenes/traffic.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "simulate/scenes/person.h"
#include "simulate/scenes/sunlight.h"

namespace highwall::simulate {
namespace {

using Eigen::Vector3d;

// Colours of a frame's scene.
struct Paints {
  int yellow, dark, glass;
};

Paints AddPaints(Scene* scene) {
  const auto paint = [scene](const Colour& colour, float contrast) {
    return scene->AddTexture(std::make_unique<NoiseTexture>(
        colour, contrast, ValueNoise{.wavelength = 0.15f, .octaves = 4, .seed = 8}));
  };
  return {.yellow = paint(Rgb(0.8, 0.6, 0.1), 0.3f),
          .dark = paint(Rgb(0.12, 0.12, 0.12), 0.4f),
          .glass = paint(Rgb(0.2, 0.25, 0.3), 0.2f)};
}

Pose Placed(const Vector3d& p) {
  return Pose(Eigen::Quaterniond::Identity(), p);
}

// B: x forward, y left, z up, on the ground.
void AddTruck(const Pose& T_WB, const Paints& paints, Scene* scene) {
  const BoxTextures yellow{paints.yellow, paints.yellow, paints.yellow};
  const BoxTextures dark{paints.dark, paints.dark, paints.dark};
  const BoxTextures glass{paints.glass, paints.glass, paints.glass};
  scene->AddBox(T_WB * Placed({0.0, 0.0, 0.3}), {2.0, 0.6, 0.2}, dark);
  scene->AddBox(T_WB * Placed({-0.3, 0.0, 0.5}), {1.3, 0.85, 0.5}, yellow);
  scene->AddBox(T_WB * Placed({0.7, 0.0, 0.5}), {0.5, 0.8, 0.45}, yellow);
  scene->AddBox(T_WB * Placed({0.68, 0.0, 0.95}), {0.44, 0.74, 0.3}, glass);
  for (const double x : {-0.65, 0.65}) {
    for (const double y : {-0.36, 0.36}) {
      scene->AddBox(T_WB * Placed({x, y, -0.02}), {0.5, 0.16, 0.5}, dark);
    }
  }
}

}  // namespace

MovingScene MakeTraffic(const Course& course, const RoadSurface& surface) {
  return [course, surface](double t) {
    // On the ground, rotated by yaw from the direction of the course.
    const auto stand = [&](double s, double left, double yaw) {
      const Course::Frame frame = course.At(s);
      Eigen::Matrix3d R;
      R << frame.forward, frame.left, Vector3d::UnitZ();
      return Pose(Eigen::Quaterniond(R) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ()),
                  frame.Point(left, surface.Height(s, left)));
    };
    constexpr double kTruckSpeed = 1.1, kWorkerSpeed = 0.62;  // [m/s]
    constexpr double kTruckLane = 1.65, kWorkerLane = 0.4;    // [m]
    Scene scene;
    AddTruck(stand(13.0 - kTruckSpeed * t, kTruckLane, std::numbers::pi), AddPaints(&scene),
             &scene);
    AddPerson(stand(3.2 + kWorkerSpeed * t, kWorkerLane, 0.0),
              2.0 * std::numbers::pi * kStepsPerSecond * t, &scene);
    BakeSunlight({}, &scene, 1);
    return scene;
  };
}

}  // namespace highwall::simulate
