#pragma once

#include <optional>
#include <random>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/seen_landmarks.h>

#include "inertial_scene.h"
#include "support/synthetic_scene.h"

// Common parts of the tests of the tightly coupled smoother: a body with camera and IMU in a place
// that is mapped.
namespace highwall::testing {

constexpr double kStart = 0.3, kImageStep = 1.0 / 15.0;  // [s]
constexpr double kPixel = 0.7;                           // [px] MeasurementOptions::point_sigma

// Returns points on all sides, and lines among them.
inline Scene MakeLandmarks() {
  Scene scene = MakeSurroundings();
  std::mt19937 rng(7);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p_W = UniformInBox(rng, {-4, -4, -4}, {4, 4, 4});
    const Eigen::Vector3d along = UniformInBox(rng, {-1, -1, -1}, {1, 1, 1}).normalized();
    if (p_W.norm() < 2.0) continue;
    scene.lines.push_back({Segment3(p_W, p_W + 0.8 * along), RandomDescriptor(rng)});
  }
  return scene;
}

// A place that keyframes have mapped, and a body with camera and IMU that moves in it.
class MappedPlace {
 public:
  // noise: scale of the image noise, 1 for that of the sensor.
  explicit MappedPlace(const InertialSceneOptions& options, double noise = 1.0)
      : scene_(options),
        noise_(noise),
        landmarks_(MakeLandmarks()),
        map_(landmarks_),
        seed_(1000 * options.seed) {
    for (int k = 0; k < 20; ++k) {
      const Pose T_WC = scene_.T_WC(0.25 * k);
      map_.Add(Look(T_WC), T_WC);
    }
  }

  InertialScene& scene() { return scene_; }
  MeasurementModel model() const { return MeasurementModel(IdealSensor(), {}); }
  void MoveMap(const Pose& T) { map_.map.Transform(T); }

  // Returns the map landmarks seen by an image at that stamp [s]; valid until the next call.
  SeenLandmarks See(double t) {
    latest_ = Look(scene_.T_WC(t));
    std::vector<PointId> points;
    for (const int i : latest_.points)
      points.push_back(map_.point_ids[static_cast<std::size_t>(i)]);
    std::vector<LineId> lines;
    for (const int i : latest_.lines) lines.push_back(map_.line_ids[static_cast<std::size_t>(i)]);
    return FindSeen(map_.map, latest_.features, {points, lines}, 1.0);
  }

 private:
  SyntheticView Look(const Pose& T_WC) {
    return testing::Look(landmarks_, IdealSensor(), T_WC, {noise_ * kPixel, noise_ > 0.0, ++seed_});
  }

  InertialScene scene_;
  double noise_;
  Scene landmarks_;
  SceneMap map_;
  SyntheticView latest_;
  unsigned seed_;  // of the noise of the latest image, none as another place's
};

}  // namespace highwall::testing
