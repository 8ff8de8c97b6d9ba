#include "local/local_mapper.h"

#include <algorithm>
#include <stop_token>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/internal/background_job.h>

#include "local/depthless_lines.h"
#include "local/depthless_points.h"
#include "map/covisibility.h"
#include "map/landmark_fusion.h"
#include "tracking/dynamic_objects.h"

namespace highwall {
namespace {

// A landmark is culled if it is matched in a smaller share of the frames that had it in view.
constexpr double kMinFoundRatio = 0.25;
// A keyframe is culled if this share of its points, or of its lines if it has no points, is
// observed by enough others, points at levels up to one coarser. This bounds the map by the area
// that it covers, however long the camera stays.
constexpr double kRedundantShare = 0.9;
// [s] With an IMU a recent keyframe is kept if its neighbours in time would be left farther apart
// than this, since a shorter IMU factor is more accurate. An older one is culled, and the IMU
// factor with it.
constexpr double kMaxMotionGap = 1.0;
// Relative to its depth: a less certain corner creates no landmark.
constexpr double kMaxDepthSigma = 0.03;

// Returns whether without `keyframe` the IMU factor of its successor `next` would span more than
// max_gap [s] or be missing.
bool LeavesGap(const KeyFrame& keyframe, const KeyFrame* next, double max_gap) {
  if (next == nullptr) return false;
  const auto& readings = keyframe.motion->from_previous;
  return readings == nullptr || ToSeconds(next->motion->stamp - readings->start()) > max_gap;
}

// Returns the features without the image, for a keyframe whose image is not used again.
std::shared_ptr<const FrameFeatures> WithoutImage(const FrameFeatures& features) {
  auto without = std::make_shared<FrameFeatures>(features);
  without->gray.release();
  return without;
}

// Returns how many keyframes were created from one to the other.
int Between(KeyFrameId older, KeyFrameId newer) {
  return newer.value() - older.value();
}

}  // namespace

// The adjustment around a keyframe, synchronous or on a thread of its own.
class LocalMapper::Adjustment {
 public:
  Adjustment(const KeyFrame& keyframe, std::unique_ptr<BundleAdjuster> bundle, bool background)
      : keyframe_(keyframe.id),
        submap_(keyframe.submap),
        bundle_(std::move(bundle)),
        task_(background, [this](const std::stop_token& stop) { bundle_->Solve(stop); }) {}

  KeyFrameId keyframe() const { return keyframe_; }
  SubmapId submap() const { return submap_; }
  bool IsDone() const { return task_.IsDone(); }
  void Cancel() { task_.Cancel(); }
  // Waits for the end. Rethrows the exception that ended the work.
  BundleAdjustmentReport Write(Map* map) {
    task_.Wait();
    return bundle_->Write(map);
  }

 private:
  const KeyFrameId keyframe_;
  const SubmapId submap_;
  const std::unique_ptr<BundleAdjuster> bundle_;
  BackgroundTask task_;  // last: it uses all of the above and ends first
};

LocalMapper::LocalMapper(const MeasurementModel& model, const LocalMapperOptions& options,
                         bool background, const LocalMapperParameters& parameters)
    : model_(model),
      options_(options),
      parameters_(parameters),
      background_(background),
      matcher_(model),
      corners_(model.camera()) {
  options_.Validate();
}

LocalMapper::~LocalMapper() = default;

LocalMappingReport LocalMapper::InsertKeyFrame(const TrackedFrame& tracked, Map& map,
                                               std::optional<InertialState> motion) {
  Finish(&map);
  LocalMappingReport report;
  const Landmarks left = CullKeyFrames(map, report);
  const cv::Mat& gray = tracked.frame.features->gray;
  std::optional<ImageLevels> image;
  if (options_.refine_corners && !gray.empty()) image.emplace(gray, model_.pyramid());
  Frame frame = tracked.frame;
  frame.features = image ? corners_.Refine(tracked, *image, map) : WithoutImage(*frame.features);
  KeyFrame& keyframe = map.AddKeyFrame(frame, tracked.T_WC, tracked.submap);
  keyframe.motion = std::move(motion);
  keyframe.found = tracked.found;
  keyframe.depth_grid = Standing(keyframe.depth_grid, tracked.moving);
  report.keyframe = newest_ = keyframe.id;
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    map.Observe(keyframe.id, static_cast<int>(i), tracked.points[i]);
  }
  for (std::size_t i = 0; i < tracked.lines.size(); ++i) {
    map.Observe(keyframe.id, static_cast<int>(i), tracked.lines[i]);
  }
  CullUnseen(left, map);  // only now: this keyframe may observe them
  CullLandmarks(keyframe.id, map, report);
  FuseNeighbours(keyframe.id, map, report);
  CreatePoints(keyframe, map, report);
  TriangulatePoints(keyframe, map, report);
  CreateLines(keyframe, map, report);
  if (tracked.num_points < parameters_.triangulation.scarce_points) {
    TriangulateLines(keyframe, map, report);
  }
  if (image) corners_.Remember(keyframe, *image, &map);
  RefreshPoints(keyframe.id, map);
  if (map.NumKeyFramesOf(tracked.submap) > 1) {
    AdjustAround(keyframe.id, map);
    if (!background_) report.bundle = Finish(&map).value_or(BundleAdjustmentReport());
  }
  return report;
}

bool LocalMapper::HasResult() const {
  return adjustment_ && adjustment_->IsDone();
}

std::optional<BundleAdjustmentReport> LocalMapper::Update(Map* map) {
  return HasResult() ? Finish(map) : std::nullopt;
}

std::optional<BundleAdjustmentReport> LocalMapper::Finish(Map* map) {
  if (!adjustment_) return std::nullopt;
  if (!options_.wait) adjustment_->Cancel();
  const std::unique_ptr<Adjustment> adjustment = std::move(adjustment_);
  const BundleAdjustmentReport report = adjustment->Write(map);
  if (map->keyframe(adjustment->keyframe()) != nullptr) {
    RefreshPoints(adjustment->keyframe(), *map);
  }
  return report;
}

SubmapId LocalMapper::submap() const {
  return adjustment_ ? adjustment_->submap() : SubmapId(kNoId);
}

void LocalMapper::Drop() {
  adjustment_.reset();
}

void LocalMapper::CreatePoints(KeyFrame& keyframe, Map& map, LocalMappingReport& report) {
  const auto& features = keyframe.frame.features->points;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (keyframe.points[i] != kNoId) continue;
    if (!HasSoundDepth(features[i], kMaxDepthSigma)) continue;
    const Eigen::Vector3d p_C = model_.camera().Unproject(features[i].uv, features[i].depth);
    const MapPoint& point = map.Add<MapPoint>(keyframe.T_WC * p_C, keyframe.frame.index);
    map.Observe(keyframe.id, static_cast<int>(i), point.id);
    recent_points_.emplace_back(point.id, keyframe.id);
    ++report.new_points;
  }
}

void LocalMapper::TriangulatePoints(const KeyFrame& keyframe, Map& map,
                                    LocalMappingReport& report) {
  const auto neighbours =
      Neighbours(map, keyframe.id, kSharedToSearch, parameters_.triangulation.keyframes);
  for (const DepthlessPoint& found :
       FindDepthlessPoints(model_, map, keyframe.id, neighbours, parameters_.triangulation,
                           parameters_.bundle.inliers)) {
    const MapPoint& point = map.Add<MapPoint>(found.p_W, keyframe.frame.index);
    for (const Observation& o : found.observations) {
      map.Observe(o.keyframe, o.index, point.id);
    }
    recent_points_.emplace_back(point.id, keyframe.id);
    ++report.triangulated_points;
  }
}

void LocalMapper::CreateLines(const KeyFrame& keyframe, Map& map, LocalMappingReport& report) {
  const FrameFeatures& features = *keyframe.frame.features;
  for (std::size_t i = 0; i < features.lines.size(); ++i) {
    if (keyframe.lines[i] != kNoId || !features.lines[i].segment_C) continue;
    const SegmentDepth& fit = *features.lines[i].segment_C;
    const Segment3 segment_C(fit.p_C, fit.q_C);
    if (segment_C.Length() < parameters_.min_line_length) continue;
    const int index = static_cast<int>(i);
    map.Observe(keyframe.id, index, AddLine(keyframe, index, keyframe.T_WC * segment_C, map));
    ++report.new_lines;
  }
}

void LocalMapper::TriangulateLines(const KeyFrame& keyframe, Map& map, LocalMappingReport& report) {
  const auto neighbours =
      Neighbours(map, keyframe.id, kSharedToSearch, parameters_.triangulation.keyframes);
  for (const DepthlessLine& found :
       FindDepthlessLines(model_, map, keyframe.id, neighbours, parameters_.triangulation,
                          parameters_.bundle.inliers)) {
    if (found.segment_W.Length() < parameters_.min_line_length) continue;
    const LineId line = AddLine(keyframe, found.observations.front().index, found.segment_W, map);
    for (const Observation& o : found.observations) map.Observe(o.keyframe, o.index, line);
    ++report.triangulated_lines;
  }
}

LineId LocalMapper::AddLine(const KeyFrame& keyframe, int index, const Segment3& segment_W,
                            Map& map) {
  MapLine& line = map.Add<MapLine>(segment_W, keyframe.frame.index);
  const cv::Mat& descriptors = keyframe.frame.features->line_descriptors;
  if (!descriptors.empty()) {
    line.descriptor = DescriptorRow(descriptors, index);
    line.has_descriptor = true;
  }
  recent_lines_.emplace_back(line.id, keyframe.id);
  return line.id;
}

void LocalMapper::FuseNeighbours(KeyFrameId id, Map& map, LocalMappingReport& report) const {
  const MapFusion fusion = FuseLandmarks(
      id, Neighbours(map, id, kSharedToSearch, options_.fused_keyframes), matcher_,
      {.inliers = parameters_.bundle.inliers, .keep_more_observed = true, .merge_lines = false},
      &map);
  report.fused_points += static_cast<int>(fusion.merged.points.size());
}

template <class Landmark>
bool LocalMapper::Fails(const Landmark& landmark, KeyFrameId created, KeyFrameId newest) const {
  const double ratio = static_cast<double>(landmark.found) / landmark.visible;
  if (ratio < kMinFoundRatio) return true;
  return Between(created, newest) >= parameters_.probation_keyframes &&
         static_cast<int>(landmark.observations.size()) < options_.min_observations;
}

void LocalMapper::CullLandmarks(KeyFrameId newest, Map& map, LocalMappingReport& report) {
  std::erase_if(recent_points_, [&](const auto& recent) {
    const MapPoint* point = map.Find(recent.first);
    if (point == nullptr) return true;
    if (Fails(*point, recent.second, newest)) {
      map.Remove(recent.first);
      ++report.culled_points;
      return true;
    }
    return Between(recent.second, newest) >= parameters_.probation_keyframes;
  });
  std::erase_if(recent_lines_, [&](const auto& recent) {
    const MapLine* line = map.Find(recent.first);
    if (line == nullptr) return true;
    if (Fails(*line, recent.second, newest)) {
      map.Remove(recent.first);
      ++report.culled_lines;
      return true;
    }
    return Between(recent.second, newest) >= parameters_.probation_keyframes;
  });
}

void LocalMapper::AdjustAround(KeyFrameId id, const Map& map) {
  // With an IMU the preceding keyframes come first: IMU factors connect them even without common
  // views.
  constexpr std::size_t kChain = 5;
  std::vector<KeyFrameId> free{id};
  for (const KeyFrame* k = map.keyframe(id); free.size() < kChain && k->motion;) {
    k = map.keyframe(k->motion->previous);
    if (k == nullptr || map.IsOrigin(k->id)) break;
    free.push_back(k->id);
  }
  for (const auto& [neighbour, shared] : map.Covisible(id, kSharedByPlace)) {
    if (static_cast<int>(free.size()) == options_.adjusted_keyframes) break;
    if (!map.IsOrigin(neighbour) && std::find(free.begin(), free.end(), neighbour) == free.end()) {
      free.push_back(neighbour);
    }
  }
  std::vector<PointId> points;
  std::vector<LineId> lines;
  for (const KeyFrameId k : free) {
    const KeyFrame& keyframe = *map.keyframe(k);
    points.insert(points.end(), keyframe.points.begin(), keyframe.points.end());
    lines.insert(lines.end(), keyframe.lines.begin(), keyframe.lines.end());
  }
  std::vector<KeyFrameId> fixed;
  for (const auto& [observer, shared] : map.Observers(points, lines)) {
    if (static_cast<int>(fixed.size()) == options_.fixed_keyframes) break;
    if (std::find(free.begin(), free.end(), observer) == free.end()) fixed.push_back(observer);
  }
  adjustment_ = std::make_unique<Adjustment>(
      *map.keyframe(id),
      std::make_unique<BundleAdjuster>(map, model_, free, fixed, parameters_.bundle), background_);
}

void LocalMapper::RefreshPoints(KeyFrameId id, Map& map) const {
  for (const PointId p : map.keyframe(id)->points) {
    if (p != kNoId) map.RefreshPoint(p, model_.pyramid());
  }
}

LocalMapper::Landmarks LocalMapper::CullKeyFrames(Map& map, LocalMappingReport& report) const {
  Landmarks left;
  const auto neighbours = map.Covisible(newest_, kSharedByPlace);
  if (neighbours.empty()) return left;
  const Stamp recent = map.keyframe(newest_)->frame.stamp - FromSeconds(parameters_.motion_span);
  for (const auto& [id, shared] : neighbours) {
    KeyFrame& keyframe = *map.keyframe(id);
    if (map.IsOrigin(id) || !IsRedundant(keyframe, map)) continue;
    if (LeavesGap(keyframe, map.Successor(id), kMaxMotionGap)) {
      if (keyframe.frame.stamp >= recent) continue;
      keyframe.motion->previous = kNoId;
      keyframe.motion->from_previous = nullptr;
    }
    left.points.insert(left.points.end(), keyframe.points.begin(), keyframe.points.end());
    left.lines.insert(left.lines.end(), keyframe.lines.begin(), keyframe.lines.end());
    map.RemoveKeyFrame(id, map.Covisible(id, 1).front().first);
    report.culled_keyframes.push_back(id);
  }
  return left;
}

bool LocalMapper::IsRedundant(const KeyFrame& keyframe, const Map& map) const {
  int points = 0, redundant_points = 0, lines = 0, redundant_lines = 0;
  for (std::size_t i = 0; i < keyframe.points.size(); ++i) {
    const MapPoint* point = map.Find(keyframe.points[i]);
    if (point == nullptr) continue;
    ++points;
    const int octave = keyframe.frame.features->points[i].octave;
    const auto others = std::count_if(
        point->observations.begin(), point->observations.end(), [&](const Observation& o) {
          return o.keyframe != keyframe.id &&
                 map.keyframe(o.keyframe)
                         ->frame.features->points[static_cast<std::size_t>(o.index)]
                         .octave <= octave + 1;
        });
    if (others >= parameters_.redundant_observers) ++redundant_points;
  }
  for (const LineId id : keyframe.lines) {
    const MapLine* line = map.Find(id);
    if (line == nullptr) continue;
    ++lines;
    const int others = static_cast<int>(line->observations.size()) - 1;
    if (others >= 2 * parameters_.redundant_observers) ++redundant_lines;
  }
  const auto [all, redundant] =
      points > 0 ? std::pair(points, redundant_points) : std::pair(lines, redundant_lines);
  return all > 0 && redundant >= kRedundantShare * all;
}

void LocalMapper::CullUnseen(const Landmarks& landmarks, Map& map) const {
  const auto too_few = [&](const auto* landmark) {
    return landmark != nullptr &&
           static_cast<int>(landmark->observations.size()) < options_.min_observations;
  };
  for (const PointId p : landmarks.points) {
    if (too_few(map.Find(p))) map.Remove(p);
  }
  for (const LineId l : landmarks.lines) {
    if (too_few(map.Find(l))) map.Remove(l);
  }
}

}  // namespace highwall
