#include "local/local_mapper.h"

#include <algorithm>
#include <stop_token>
#include <type_traits>
#include <utility>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/internal/background_job.h>
#include <highwall/internal/stage_timer.h>

#include "local/landmark_kinds.h"
#include "map/covisibility.h"
#include "map/landmark_fusion.h"
#include "pose/support.h"
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

void AppendLandmarks(const KeyFrame& keyframe, PerKind<LandmarkIds>* all) {
  ForEachKind([&]<class Landmark>() {
    const LandmarkIds<Landmark>& own = PartOf<Landmark>(keyframe);
    LandmarkIds<Landmark>& ids = PartOf<Landmark>(*all);
    ids.insert(ids.end(), own.begin(), own.end());
  });
}

// Returns how many keyframes were created from one to the other.
int Between(KeyFrameId older, KeyFrameId newer) {
  return newer.value() - older.value();
}

}  // namespace

// The adjustment around a keyframe, synchronous or on a thread of its own.
class LocalMapper::Adjustment {
 public:
  Adjustment(const KeyFrame& keyframe, std::unique_ptr<BundleAdjuster> bundle, bool background,
             RunProfile* profile)
      : keyframe_(keyframe.id),
        submap_(keyframe.submap),
        bundle_(std::move(bundle)),
        task_(background,
              [this, profile](const std::stop_token& stop) {
                const StageTimer timer(profile, "local adjustment");
                bundle_->Solve(stop);
              },
              {"local mapping", profile, ThreadPriority::kBackground}) {}

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
                         bool background, const LocalMapperParameters& parameters,
                         RunProfile* profile)
    : model_(model),
      options_(options),
      parameters_(parameters),
      background_(background),
      profile_(profile),
      matcher_(model),
      corners_(model.camera()) {
  options_.Validate();
}

LocalMapper::~LocalMapper() = default;

LocalMappingReport LocalMapper::InsertKeyFrame(const TrackedFrame& tracked, Map& map,
                                               std::optional<InertialState> motion) {
  Finish(&map);
  LocalMappingReport report;
  const PerKind<LandmarkIds> left = CullKeyFrames(map, report);
  const cv::Mat& gray = tracked.frame.features->gray;
  std::optional<ImageLevels> image;
  if (options_.refine_corners && !gray.empty()) image.emplace(gray, model_.pyramid());
  Frame frame = tracked.frame;
  frame.features = image ? corners_.Refine(tracked, *image, map) : WithoutImage(*frame.features);
  KeyFrame& keyframe = map.AddKeyFrame(frame, tracked.T_WC, tracked.submap);
  keyframe.motion = std::move(motion);
  keyframe.found = tracked.found;
  keyframe.image_motion = tracked.image_motion;
  keyframe.depth_grid = Standing(keyframe.depth_grid, tracked.moving);
  report.keyframe = newest_ = keyframe.id;
  ForEachKind([&]<class Landmark>() {
    int index = 0;
    for (const Id<Landmark> id : PartOf<Landmark>(tracked)) map.Observe(keyframe.id, index++, id);
  });
  CullUnseen(left, map);  // only now: this keyframe may observe them
  PerKind<NumOfKind> culled{};
  ForEachKind(
      [&]<class Landmark>() { PartOf<Landmark>(culled) = CullRecent<Landmark>(keyframe.id, map); });
  report.culled_points = culled.points;
  report.culled_lines = culled.lines;
  FuseNeighbours(keyframe.id, map, report);
  CreateLandmarks(keyframe, tracked.num_points < parameters_.triangulation.scarce_points, map,
                  report);
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

void LocalMapper::CreateLandmarks(const KeyFrame& keyframe, bool scarce_points, Map& map,
                                  LocalMappingReport& report) {
  PerKind<NumOfKind> from_depth{}, triangulated{};
  ForEachKind([&]<class Landmark>() {
    PartOf<Landmark>(from_depth) = CreateFromDepth<Landmark>(keyframe, map);
    PartOf<Landmark>(triangulated) =
        CreateFrom(FindDepthless<Landmark>(keyframe.id, scarce_points, map), keyframe, map);
  });
  report.new_points = from_depth.points;
  report.new_lines = from_depth.lines;
  report.triangulated_points = triangulated.points;
  report.triangulated_lines = triangulated.lines;
}

template <class Landmark>
std::vector<Depthless<Landmark>> LocalMapper::FindDepthless(KeyFrameId id, bool scarce_points,
                                                            const Map& map) const {
  // New landmarks change which keyframes are neighbours.
  const auto neighbours = [&] {
    return Neighbours(map, id, kSharedToSearch, parameters_.triangulation.keyframes);
  };
  std::vector<Depthless<Landmark>> found;
  if constexpr (std::is_same_v<Landmark, MapPoint>) {
    found = FindDepthlessPoints(model_, map, id, neighbours(), parameters_.triangulation,
                                parameters_.bundle.inliers);
  } else if constexpr (std::is_same_v<Landmark, MapLine>) {
    if (!scarce_points) return {};
    found = FindDepthlessLines(model_, map, id, neighbours(), parameters_.triangulation,
                               parameters_.bundle.inliers);
    std::erase_if(found, [&](const Depthless<MapLine>& line) {
      return line.geometry_W.Length() < parameters_.min_line_length;
    });
  }
  return found;
}

template <class Landmark>
int LocalMapper::CreateFromDepth(const KeyFrame& keyframe, Map& map) {
  const auto& features = PartOf<Landmark>(*keyframe.frame.features);
  int created = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (PartOf<Landmark>(keyframe)[i] != kNoId) continue;
    const auto geometry_C = FromDepth(features[i], model_.camera(), parameters_.min_line_length);
    if (!geometry_C) continue;
    const Observation observation{keyframe.id, static_cast<int>(i)};
    Create<Landmark>(keyframe.T_WC * *geometry_C, {&observation, 1}, keyframe, map);
    ++created;
  }
  return created;
}

template <class Landmark>
int LocalMapper::CreateFrom(const std::vector<Depthless<Landmark>>& found, const KeyFrame& keyframe,
                            Map& map) {
  for (const auto& [geometry_W, observations] : found) {
    Create<Landmark>(geometry_W, observations, keyframe, map);
  }
  return static_cast<int>(found.size());
}

template <class Landmark>
void LocalMapper::Create(const typename LandmarkTraits<Landmark>::Geometry& geometry_W,
                         std::span<const Observation> observations, const KeyFrame& keyframe,
                         Map& map) {
  Landmark& landmark = map.Add<Landmark>(geometry_W, keyframe.frame.index);
  TakeDescriptor(*keyframe.frame.features, observations.front().index, &landmark);
  for (const Observation& o : observations) map.Observe(o.keyframe, o.index, landmark.id);
  PartOf<Landmark>(recent_).emplace_back(landmark.id, keyframe.id);
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

template <class Landmark>
int LocalMapper::CullRecent(KeyFrameId newest, Map& map) {
  int culled = 0;
  std::erase_if(PartOf<Landmark>(recent_), [&](const auto& recent) {
    const Landmark* const landmark = map.Find(recent.first);
    if (landmark == nullptr) return true;
    if (Fails(*landmark, recent.second, newest)) {
      map.Remove(recent.first);
      ++culled;
      return true;
    }
    return Between(recent.second, newest) >= parameters_.probation_keyframes;
  });
  return culled;
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
  PerKind<LandmarkIds> observed;
  for (const KeyFrameId k : free) AppendLandmarks(*map.keyframe(k), &observed);
  std::vector<KeyFrameId> fixed;
  for (const auto& [observer, shared] : map.Observers(observed)) {
    if (static_cast<int>(fixed.size()) == options_.fixed_keyframes) break;
    if (std::find(free.begin(), free.end(), observer) == free.end()) fixed.push_back(observer);
  }
  adjustment_ = std::make_unique<Adjustment>(
      *map.keyframe(id),
      std::make_unique<BundleAdjuster>(map, model_, free, fixed, parameters_.bundle), background_,
      profile_);
}

void LocalMapper::RefreshPoints(KeyFrameId id, Map& map) const {
  for (const PointId p : map.keyframe(id)->points) {
    if (p != kNoId) map.RefreshPoint(p, model_.pyramid());
  }
}

PerKind<LandmarkIds> LocalMapper::CullKeyFrames(Map& map, LocalMappingReport& report) const {
  PerKind<LandmarkIds> left;
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
    AppendLandmarks(keyframe, &left);
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

void LocalMapper::CullUnseen(const PerKind<LandmarkIds>& landmarks, Map& map) const {
  ForEachKind([&]<class Landmark>() {
    for (const Id<Landmark> id : PartOf<Landmark>(landmarks)) {
      const Landmark* const landmark = map.Find(id);
      if (landmark == nullptr) continue;
      const auto observations = static_cast<int>(landmark->observations.size());
      if (observations < options_.min_observations) map.Remove(id);
    }
  });
}

}  // namespace highwall
