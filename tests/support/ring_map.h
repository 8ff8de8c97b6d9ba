#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <highwall/frontend/map/map.h>

#include "loops/keyframe_graph.h"
#include "support/odometry_drift.h"
#include "support/synthetic_scene.h"

// The map of a walk round a ring with a keyframe every 0.25 m, which ends one step before its
// start. Each keyframe shares landmarks with the five before it, the loop is not closed, and the
// poses are those of odometry.
namespace highwall::testing {

class RingMap {
 public:
  explicit RingMap(int keyframes) {
    std::mt19937 rng(5);
    const double radius = 0.25 * keyframes / (2.0 * M_PI);  // [m]
    for (int i = 0; i < keyframes; ++i) {
      const double azimuth = 2.0 * M_PI * i / keyframes;
      const Eigen::Vector3d z(std::cos(azimuth), std::sin(azimuth), 0.0), y(0.0, 0.0, -1.0);
      Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
      T.topLeftCorner<3, 3>() << y.cross(z), y, z;
      T.topRightCorner<3, 1>() = radius * z;
      truth.push_back(Pose::FromMatrix(T));
      Add(i, rng);
    }
  }

  // Sets the poses to those of odometry; landmarks stay where their first keyframes saw them.
  // levelled: an IMU keeps gravity aligned, and the map knows it.
  void Drift(const OdometryDrift& drift, bool levelled) {
    DriftingOdometry odometry(drift);
    Pose T = truth.front();
    for (std::size_t i = 1; i < truth.size(); ++i) {
      T = T * odometry.Measure(truth[i - 1].Inverse() * truth[i]);
      if (levelled) T = Levelled(T, truth[i]);
      map.keyframe(KeyFrameId(i))->T_WC = T;
    }
    for (const Landmark& landmark : landmarks_) {
      map.Find(landmark.id)->p_W = map.keyframe(landmark.first)->T_WC * landmark.p_C;
    }
    map.SetGravity(levelled ? std::make_optional(Eigen::Vector3d(0, 0, -9.81)) : std::nullopt);
  }

  // Returns the loop edge as measured without noise.
  LoopEdge Loop(KeyFrameId match, KeyFrameId keyframe) const {
    return {match, keyframe, truth[match.index()].Inverse() * truth[keyframe.index()]};
  }
  KeyFrameId last() const { return KeyFrameId(truth.size() - 1); }

  std::vector<Pose> truth;  // T_WC by keyframe
  Map map;

 private:
  // Returns T with the true direction of gravity and the heading of T.
  static Pose Levelled(const Pose& T, const Pose& truth) {
    const Eigen::Quaterniond off = T.q() * truth.q().conjugate();
    const Eigen::Quaterniond heading = Eigen::Quaterniond(off.w(), 0.0, 0.0, off.z()).normalized();
    return Pose(heading * truth.q(), T.p());
  }

  void Add(int index, std::mt19937& rng) {
    constexpr int kNew = 25, kViews = 6;  // new landmarks of a keyframe, keyframes that see one
    const RgbdSensor sensor = IdealSensor();
    for (int i = 0; i < kNew; ++i) {
      const Eigen::Vector3d p_C = UniformInBox(rng, {-1.0, -0.8, 2.5}, {1.0, 0.8, 3.5});
      points_.push_back(map.Add<MapPoint>(truth.back() * p_C, index).id);
      landmarks_.push_back({points_.back(), KeyFrameId(index), p_C});
    }
    const std::size_t seen = std::min<std::size_t>(points_.size(), kNew * kViews);
    auto features = std::make_shared<FrameFeatures>();
    for (std::size_t i = 0; i < seen; ++i) {
      PointFeature feature;
      feature.uv = {Uniform(rng, 10.0, 630.0), Uniform(rng, 10.0, 470.0)};
      feature.depth = 3.0;
      feature.depth_sigma = sensor.depth_noise.Sigma(feature.depth);
      feature.noise = {.px = 0.05F, .depth = 0.05F};  // the drift is that of shared errors
      features->points.push_back(feature);
      AppendDescriptor(features->point_descriptors, RandomDescriptor(rng));
    }
    IndexPoints(*features, sensor.camera.WithoutDistortion());
    const Frame frame{.index = index, .stamp = 1'000'000'000LL * index, .features = features};
    const KeyFrameId id = map.AddKeyFrame(frame, truth.back()).id;
    for (std::size_t i = 0; i < seen; ++i) {
      map.Observe(id, static_cast<int>(i), points_[points_.size() - seen + i]);
    }
  }

  struct Landmark {
    PointId id;
    KeyFrameId first;
    Eigen::Vector3d p_C;  // [m] in it
  };
  std::vector<PointId> points_;
  std::vector<Landmark> landmarks_;
};

}  // namespace highwall::testing
