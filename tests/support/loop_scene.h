#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "support/odometry_drift.h"
#include "support/synthetic_scene.h"

// A walk round a ring of points and lines that ends where it began, with the camera looking
// outwards. The map drifts on the way and has not closed the loop.
namespace highwall::testing {

struct LoopSceneOptions {
  int per_lap = 48;  // keyframes, 0.25 m apart
  int points = 1000;
  int lines = 150;
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();  // [m] in C, per keyframe
  std::optional<OdometryDrift> odometry = {};       // additional drift
  // Changes of the scene before the start is in view again:
  bool shuffled_return = false;  // descriptors are permuted
  double strange_return = 0.0;   // share of the landmarks replaced by others elsewhere
  unsigned seed = 11;
  bool connected = false;  // no landmark is forgotten: there is no loop to find
  // From this keyframe on, the walk is in a separate submap whose world frame begins there, and no
  // landmark is known.
  std::optional<int> submap_from = {};
  int jump = 0;  // number of keyframes omitted before it
  MeasurementOptions measurement{};
  MatchingOptions matching{};
};

class LoopScene {
 public:
  // Number of keyframes of the first lap and the beginning of the second.
  int size() const { return options_.per_lap + 12 - options_.jump; }
  explicit LoopScene(const LoopSceneOptions& options)
      : model(model_sensor, options.measurement, Pose(), {}, options.matching), options_(options) {
    if (options.odometry) odometry_.emplace(*options.odometry);
    std::mt19937 rng(options.seed);
    for (int i = 0; i < options.points; ++i) scene.points.push_back(RandomPoint(rng));
    for (int i = 0; i < options.lines; ++i) scene.lines.push_back(RandomLine(rng));
    returned_ = scene;
    const auto strange = [&] { return Uniform(rng, 0.0, 1.0) < options.strange_return; };
    for (std::size_t i = 0; i < scene.points.size(); ++i) {
      const std::size_t other = options.shuffled_return ? (i * 7 + 3) % scene.points.size() : i;
      returned_.points[i].descriptor = scene.points[other].descriptor;
      if (!strange()) continue;
      returned_.points[i] = RandomPoint(rng);
      strange_points_.push_back(i);
    }
    for (std::size_t i = 0; i < scene.lines.size(); ++i) {
      const std::size_t other = options.shuffled_return ? (i * 7 + 3) % scene.lines.size() : i;
      returned_.lines[i].descriptor = scene.lines[other].descriptor;
      if (!strange()) continue;
      returned_.lines[i] = RandomLine(rng);
      strange_lines_.push_back(i);
    }
  }

  Pose TruePose(int i) const {
    const double azimuth = 2.0 * M_PI * i / options_.per_lap;
    const Eigen::Vector3d z(std::cos(azimuth), std::sin(azimuth), 0.0), y(0.0, 0.0, -1.0);
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    T.topLeftCorner<3, 3>() << y.cross(z), y, z;
    T.topRightCorner<3, 1>() = Radius() * z;
    return Pose::FromMatrix(T);
  }

  // Adds keyframe i, in order, with landmarks placed according to the map's estimate of its pose.
  KeyFrameId Add(int i) {
    const bool begins = i == options_.submap_from;
    if (begins) skipped_ = options_.jump;
    const int step = i + skipped_;
    const bool back = step >= options_.per_lap - 10;
    if (step == options_.per_lap - 10) MeetStrangers();
    if (!options_.connected) ForgetOldLandmarks(i);
    const Pose T_true = TruePose(step);
    if (begins) BeginSubmap();
    const Pose T_WC = i == 0   ? T_true
                      : begins ? kOtherWorld
                               : map.keyframe(KeyFrameId(i - 1))->T_WC * Step(T_true);
    truth.push_back(T_true);
    const Scene& seen = back ? returned_ : scene;
    const SyntheticView view = Look(seen, model_sensor, T_true,
                                    {.px = 0.7, .depth = false, .seed = static_cast<unsigned>(i)});
    const KeyFrameId id = map.AddKeyFrame(MakeFrame(view, i), T_WC, submap_).id;
    const Pose T_W_true = T_WC * T_true.Inverse();
    for (std::size_t f = 0; f < view.points.size(); ++f) {
      const auto s = static_cast<std::size_t>(view.points[f]);
      if (point_ids_[s] == kNoId) {
        point_ids_[s] = map.Add<MapPoint>(T_W_true * seen.points[s].p_W, i).id;
        all_points_[s].push_back(point_ids_[s]);
      }
      map.Observe(id, static_cast<int>(f), point_ids_[s]);
      map.RefreshPoint(point_ids_[s], kPyramid);
    }
    for (std::size_t f = 0; f < view.lines.size(); ++f) {
      const auto s = static_cast<std::size_t>(view.lines[f]);
      if (line_ids_[s] == kNoId) {
        MapLine& line = map.Add<MapLine>(T_W_true * seen.lines[s].segment_W, i);
        line.descriptor = seen.lines[s].descriptor;
        line.has_descriptor = true;
        line_ids_[s] = line.id;
        all_lines_[s].push_back(line.id);
      }
      map.Observe(id, static_cast<int>(f), line_ids_[s]);
    }
    return id;
  }

  // Initial camera pose in the world of the second submap, upright as in the first.
  const Pose kOtherWorld = Pose::FromMatrix([] {
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    T.topLeftCorner<3, 3>() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    T.topRightCorner<3, 1>() << 5.0, -3.0, 1.0;
    return T;
  }());

  const RgbdSensor model_sensor = IdealSensor();
  const MeasurementModel model;
  Scene scene;
  Map map;
  std::vector<Pose> truth;  // T_WC by keyframe

  // RMSE of the positions of the active keyframes [m]. The first keyframe is aligned with the
  // truth.
  double Rmse() const {
    double sum = 0.0;
    const auto ids = map.keyframe_ids();
    for (const KeyFrameId id : ids) {
      sum += (map.keyframe(id)->T_WC.p() - truth[id.index()].p()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(ids.size()));
  }

 private:
  double Radius() const { return 2.0 * options_.per_lap / 48; }  // [m]

  Eigen::Vector3d OnRing(std::mt19937& rng) const {
    const double azimuth = Uniform(rng, 0.0, 2.0 * M_PI);
    const double radius = Radius() + Uniform(rng, 2.5, 4.5);
    return {radius * std::cos(azimuth), radius * std::sin(azimuth), Uniform(rng, -1.6, 1.6)};
  }
  ScenePoint RandomPoint(std::mt19937& rng) const {
    const Eigen::Vector3d p_W = OnRing(rng);
    const double reach = Uniform(rng, 3.0, 9.0);
    return {p_W, RandomDescriptor(rng), reach};
  }
  SceneLine RandomLine(std::mt19937& rng) const {
    const Eigen::Vector3d p_W = OnRing(rng);
    const Eigen::Vector3d along = UniformInBox(rng, {-1, -1, -1}, {1, 1, 1}).normalized();
    const double length = Uniform(rng, 0.4, 1.0);
    return {Segment3(p_W, p_W + length * along), RandomDescriptor(rng)};
  }

  void BeginSubmap() {
    submap_ = map.AddSubmap();
    for (std::size_t s = 0; s < point_ids_.size(); ++s)
      all_points_[s].clear(), point_ids_[s] = kNoId;
    for (std::size_t s = 0; s < line_ids_.size(); ++s) all_lines_[s].clear(), line_ids_[s] = kNoId;
  }

  // Replaces the landmarks given by strange_return with new ones.
  void MeetStrangers() {
    for (const std::size_t s : strange_points_) all_points_[s].clear(), point_ids_[s] = kNoId;
    for (const std::size_t s : strange_lines_) all_lines_[s].clear(), line_ids_[s] = kNoId;
  }

  // Returns the odometry estimate of the step from the last keyframe to this one.
  Pose Step(const Pose& T_true) {
    const Pose Z = truth.back().Inverse() * T_true;
    return (odometry_ ? odometry_->Measure(Z) : Z) *
           Pose(Eigen::Quaterniond::Identity(), options_.drift);
  }

  // Landmarks that have not been in view for a while are not matched any more. A landmark merged
  // with an older one continues as the older one.
  void ForgetOldLandmarks(int keyframe) {
    constexpr int kWhile = 10;
    const KeyFrameId oldest(std::max(0, keyframe - kWhile));
    const auto current = [&]<class LandmarkId>(const std::vector<LandmarkId>& ids,
                                               const auto& find) -> LandmarkId {
      for (std::size_t i = ids.size(); i-- > 0;) {
        const auto* landmark = find(ids[i]);
        if (landmark == nullptr) continue;
        const bool old = landmark->observations.back().keyframe < oldest;
        return old ? kNoId : ids[i];
      }
      return kNoId;
    };
    for (std::size_t s = 0; s < point_ids_.size(); ++s) {
      point_ids_[s] = current(all_points_[s], [&](PointId id) { return map.Find(id); });
    }
    for (std::size_t s = 0; s < line_ids_.size(); ++s) {
      line_ids_[s] = current(all_lines_[s], [&](LineId id) { return map.Find(id); });
    }
  }

  LoopSceneOptions options_;
  SubmapId submap_ = kFirstSubmap;
  int skipped_ = 0;  // omitted keyframes of the walk
  std::optional<DriftingOdometry> odometry_;
  Scene returned_;
  std::vector<std::size_t> strange_points_, strange_lines_;  // of returned_
  std::vector<PointId> point_ids_ =
      std::vector<PointId>(static_cast<std::size_t>(options_.points), kNoId);
  std::vector<LineId> line_ids_ =
      std::vector<LineId>(static_cast<std::size_t>(options_.lines), kNoId);
  std::vector<std::vector<PointId>> all_points_ = decltype(all_points_)(point_ids_.size());
  std::vector<std::vector<LineId>> all_lines_ = decltype(all_lines_)(line_ids_.size());
};

}  // namespace highwall::testing
