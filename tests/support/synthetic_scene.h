#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>
#include <opencv2/core/types.hpp>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "map/projection_matcher.h"

// A scene of points and line segments with their own descriptors, and the output of an ideal
// extractor for an image of it, so that tests of tracking and mapping need no images.
namespace highwall::testing {

constexpr PyramidOptions kPyramid{};  // of every model without explicit options
constexpr double kScaleFactor = kPyramid.scale_factor;
constexpr int kLevels = kPyramid.levels;
// An outlier rule that rejects all matches of lines, except for one or two at the mean: for tests
// of its users.
inline const MeasurementOptions kStrictRule{.mad_rule = MadRule::kPaper};
inline const MatchingOptions kStrictLines{.lines = {.mad_k = 1e-9}};

struct ScenePoint {
  Eigen::Vector3d p_W;
  BinaryDescriptor256 descriptor;
  double reach;  // [m] distance at which it is a corner of level 0; nearer, of a higher level
};

struct SceneLine {
  Segment3 segment_W;
  BinaryDescriptor256 descriptor;
};

struct Scene {
  std::vector<ScenePoint> points;
  std::vector<SceneLine> lines;
};

// Two random descriptors differ in 128 +- 8 bits.
inline BinaryDescriptor256 RandomDescriptor(std::mt19937& rng) {
  BinaryDescriptor256 descriptor;
  for (std::uint8_t& byte : descriptor) byte = static_cast<std::uint8_t>(rng() & 0xff);
  return descriptor;
}

// Uniform in [low, high], identical with every standard library.
inline double Uniform(std::mt19937& rng, double low, double high) {
  return low + (high - low) * static_cast<double>(rng()) / 4294967295.0;
}

inline Eigen::Vector3d UniformInBox(std::mt19937& rng, const Eigen::Vector3d& low,
                                    const Eigen::Vector3d& high) {
  const double x = Uniform(rng, low.x(), high.x());
  const double y = Uniform(rng, low.y(), high.y());
  return {x, y, Uniform(rng, low.z(), high.z())};
}

// Returns a point in front of a camera near the origin of W that looks along z.
inline Scene MakeScene(unsigned seed, int points, int lines) {
  std::mt19937 rng(seed);
  const Eigen::Vector3d low(-3.0, -1.8, 2.0), high(3.0, 1.8, 4.5);
  Scene scene;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector3d p_W = UniformInBox(rng, low, high);
    const double reach = Uniform(rng, 3.0, 9.0);
    scene.points.push_back({p_W, RandomDescriptor(rng), reach});
  }
  for (int i = 0; i < lines; ++i) {
    const Eigen::Vector3d p_W = UniformInBox(rng, low, high);
    const Eigen::Vector3d along = UniformInBox(rng, {-1, -1, -0.5}, {1, 1, 0.5}).normalized();
    const double length = Uniform(rng, 0.4, 1.0);
    scene.lines.push_back({Segment3(p_W, p_W + length * along), RandomDescriptor(rng)});
  }
  return scene;
}

// Points on all sides of the origin, at 2 to 7 m, for a camera that rotates about all of its axes.
inline Scene MakeSurroundings() {
  std::mt19937 rng(3);
  Scene scene;
  while (scene.points.size() < 1500) {
    const Eigen::Vector3d p_W = UniformInBox(rng, {-4, -4, -4}, {4, 4, 4});
    if (p_W.norm() < 2.0) continue;
    scene.points.push_back({p_W, RandomDescriptor(rng), Uniform(rng, 3, 9)});
  }
  return scene;
}

inline RgbdSensor IdealSensor() {
  return RgbdSensor{};  // 640 x 480, no distortion, the depth noise of a Kinect
}

struct ViewNoise {
  double px = 0.0;     // [px] standard deviation of u and v at level 0, and across lines
  bool depth = false;  // with the depth noise of the sensor
  unsigned seed = 1;
};

// The view of a camera: points[i] is the index in the scene of point feature i.
struct SyntheticView {
  std::shared_ptr<const FrameFeatures> features;
  std::vector<int> points, lines;
};

inline int OctaveAt(const ScenePoint& point, double distance) {
  const double level = std::log(point.reach / distance) / std::log(kScaleFactor);
  return std::clamp(static_cast<int>(std::lround(level)), 0, kLevels - 1);
}

// Rebuilds the grid after the points of `features` were edited.
inline void IndexPoints(FrameFeatures& features, const PinholeCamera& camera) {
  std::vector<cv::KeyPoint> keypoints;
  for (const PointFeature& point : features.points) {
    cv::KeyPoint keypoint(static_cast<float>(point.uv.x()), static_cast<float>(point.uv.y()),
                          31.0F);
    keypoint.octave = point.octave;
    keypoints.push_back(keypoint);
  }
  features.point_grid = FeatureGrid(keypoints, {camera.width, camera.height});
}

inline void AppendDescriptor(cv::Mat& descriptors, const BinaryDescriptor256& descriptor) {
  cv::Mat row(1, 32, CV_8U);
  std::memcpy(row.ptr(), descriptor.data(), descriptor.size());
  descriptors.push_back(row);
}

// Observes a pixel at the depth of p_C, with noise.
inline PointFeature SeePoint(const ScenePoint& point, const Pose& T_CW, const RgbdSensor& sensor,
                             const ViewNoise& noise, std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d p_C = T_CW * point.p_W;
  PointFeature feature;
  feature.octave = OctaveAt(point, p_C.norm());
  feature.uv = sensor.camera.WithoutDistortion().Project(p_C);
  feature.depth = p_C.z();
  feature.depth_sigma = sensor.depth_noise.Sigma(p_C.z());
  const double sigma = noise.px * std::pow(kScaleFactor, feature.octave);
  feature.uv += sigma * Eigen::Vector2d(normal(rng), normal(rng));
  if (noise.depth) feature.depth += sensor.depth_noise.Sigma(p_C.z()) * normal(rng);
  return feature;
}

// Observes the visible part of a line, with noise across it at its ends. `segment` is the
// projection.
inline LineFeature SeeLine(const LineSegment& segment, const Segment3& segment_C,
                           const RgbdSensor& sensor, const ViewNoise& noise, std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const PinholeCamera camera = sensor.camera.WithoutDistortion();
  const auto along = (segment.e - segment.s).normalized();
  const Eigen::Vector2f across(-along.y(), along.x());
  const PluckerLine line_C = PluckerLine::FromPoints(segment_C.p(), segment_C.q());
  // Returns the point of the line that projects to a pixel on its image.
  const auto behind = [&](const Eigen::Vector2f& uv) -> Eigen::Vector3d {
    const Eigen::Vector3d ray = camera.Unproject(uv.cast<double>(), 1.0);
    // ray t = p + d s: a consistent system.
    Eigen::Matrix<double, 3, 2> A;
    A << ray, -line_C.d;
    const Eigen::Vector2d ts = A.colPivHouseholderQr().solve(line_C.ClosestToOrigin());
    return ts[0] * ray;
  };
  Eigen::Vector3d p_C = behind(segment.s), q_C = behind(segment.e);
  LineFeature feature;
  feature.segment = segment;
  feature.segment.s += static_cast<float>(noise.px * normal(rng)) * across;
  feature.segment.e += static_cast<float>(noise.px * normal(rng)) * across;
  if (noise.depth) {
    p_C *= 1.0 + sensor.depth_noise.Sigma(p_C.z()) * normal(rng) / p_C.z();
    q_C *= 1.0 + sensor.depth_noise.Sigma(q_C.z()) * normal(rng) / q_C.z();
  }
  SegmentDepth fit;
  fit.p_C = p_C;
  fit.q_C = q_C;
  feature.segment_C = fit;
  return feature;
}

// Returns the features of the scene from T_WC, in the order of the scene: exact (lines up to the
// rounding of their float pixels, 3e-5 px) or with noise.
inline SyntheticView Look(const Scene& scene, const RgbdSensor& sensor, const Pose& T_WC,
                          const ViewNoise& noise = {}) {
  std::mt19937 rng(noise.seed);
  const PinholeCamera camera = sensor.camera.WithoutDistortion();
  const Pose T_CW = T_WC.Inverse();
  SyntheticView view;
  auto features = std::make_shared<FrameFeatures>();
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    const Eigen::Vector3d p_C = T_CW * scene.points[i].p_W;
    if (p_C.z() < 0.3 || !camera.Contains(camera.Project(p_C), 5.0)) continue;
    features->points.push_back(SeePoint(scene.points[i], T_CW, sensor, noise, rng));
    AppendDescriptor(features->point_descriptors, scene.points[i].descriptor);
    view.points.push_back(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < scene.lines.size(); ++i) {
    const Segment3 segment_C = T_CW * scene.lines[i].segment_W;
    const auto segment = ProjectSegment(segment_C, camera, 0.3);
    if (!segment || segment->Length() < 25.0F) continue;
    features->lines.push_back(SeeLine(*segment, segment_C, sensor, noise, rng));
    AppendDescriptor(features->line_descriptors, scene.lines[i].descriptor);
    view.lines.push_back(static_cast<int>(i));
  }
  IndexPoints(*features, camera);
  view.features = features;
  return view;
}

inline Frame MakeFrame(const SyntheticView& view, std::int64_t index) {
  return {.index = index, .stamp = 1'000'000'000 + index * 33'000'000, .features = view.features};
}

// A map of keyframes in which every feature observes the landmark of its index in the scene.
class SceneMap {
 public:
  explicit SceneMap(const Scene& scene)
      : point_ids(scene.points.size(), kNoId), line_ids(scene.lines.size(), kNoId), scene_(scene) {}

  KeyFrameId Add(const SyntheticView& view, const Pose& T_WC) {
    const auto index = static_cast<std::int64_t>(map.num_keyframes());
    const KeyFrameId id = map.AddKeyFrame(MakeFrame(view, index), T_WC).id;
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      const auto s = static_cast<std::size_t>(view.points[i]);
      if (point_ids[s] == kNoId) point_ids[s] = map.Add<MapPoint>(scene_.points[s].p_W, index).id;
      map.Observe(id, static_cast<int>(i), point_ids[s]);
    }
    for (std::size_t i = 0; i < view.lines.size(); ++i) {
      const auto s = static_cast<std::size_t>(view.lines[i]);
      if (line_ids[s] == kNoId) {
        MapLine& line = map.Add<MapLine>(scene_.lines[s].segment_W, index);
        line.descriptor = scene_.lines[s].descriptor;
        line.has_descriptor = true;
        line_ids[s] = line.id;
      }
      map.Observe(id, static_cast<int>(i), line_ids[s]);
    }
    for (const PointId point : map.keyframe(id)->points) {
      map.RefreshPoint(point, kPyramid);
    }
    return id;
  }

  Map map;
  std::vector<PointId> point_ids;  // by index in the scene, kNoId where no keyframe saw it
  std::vector<LineId> line_ids;

 private:
  const Scene& scene_;
};

// Distance [m] and angle [rad] between two poses.
inline double PositionError(const Pose& a, const Pose& b) {
  return (a.p() - b.p()).norm();
}
inline double AngleError(const Pose& a, const Pose& b) {
  return (a.Inverse() * b).Angle();
}

}  // namespace highwall::testing
