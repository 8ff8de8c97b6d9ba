#include <highwall/core/error.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/features/orb_matcher.h>
#include <highwall/frontend/map/keyframe_index.h>
#include <highwall/frontend/map/map.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <unordered_map>

namespace highwall {
namespace {

bool Sees(const std::vector<Observation>& observations, KeyFrameId keyframe) {
  return std::any_of(observations.begin(), observations.end(),
                     [&](const Observation& o) { return o.keyframe == keyframe; });
}

// Landmark observed by each feature of a keyframe. Points and lines differ only in these.
template <class Landmark>
using Slots = std::vector<decltype(Landmark::id)>;

template <class Landmark>
bool Observe(KeyFrame* keyframe, Slots<Landmark>& slots, int index, Landmark* landmark) {
  if (landmark == nullptr || slots[static_cast<std::size_t>(index)] != kNoId ||
      Sees(landmark->observations, keyframe->id)) {
    return false;
  }
  slots[static_cast<std::size_t>(index)] = landmark->id;
  auto& observations = landmark->observations;
  const auto next = std::find_if(observations.begin(), observations.end(),
                                 [&](const Observation& o) { return o.keyframe > keyframe->id; });
  observations.insert(next, {keyframe->id, index});
  return true;
}

template <class Landmark>
void Forget(Slots<Landmark>& slots, KeyFrameId keyframe, Landmark& landmark) {
  std::erase_if(landmark.observations, [&](const Observation& o) {
    if (o.keyframe != keyframe) return false;
    slots[static_cast<std::size_t>(o.index)] = kNoId;
    return true;
  });
}

int Hamming(const BinaryDescriptor256& a, const BinaryDescriptor256& b) {
  return HammingDistance(a.data(), b.data());
}

// Returns the descriptor with the smallest median distance to the others.
BinaryDescriptor256 MostCentral(const std::vector<BinaryDescriptor256>& descriptors) {
  std::size_t best = 0;
  int best_median = std::numeric_limits<int>::max();
  std::vector<int> distances;
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    distances.clear();
    for (const auto& other : descriptors) distances.push_back(Hamming(descriptors[i], other));
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>((distances.size() - 1) / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    if (*middle < best_median) {
      best_median = *middle;
      best = i;
    }
  }
  return descriptors[best];
}

// landmarks_of: the points or the lines of a keyframe. Ids are marked instead of sorted: each is
// seen by many keyframes, and one byte per id between the first and the last is cheap up to
// millions.
template <class LandmarkId>
std::vector<LandmarkId> SeenBy(const Map& map, std::span<const KeyFrameId> keyframes,
                               std::span<const LandmarkId> except,
                               std::vector<LandmarkId> KeyFrame::*landmarks_of) {
  LandmarkId first = kNoId, end = kNoId;
  for (const KeyFrameId id : keyframes) {
    for (const LandmarkId landmark : map.keyframe(id)->*landmarks_of) {
      if (landmark == kNoId) continue;
      if (first == kNoId || landmark < first) first = landmark;
      if (!(landmark < end)) end = LandmarkId(landmark.value() + 1);
    }
  }
  std::vector<LandmarkId> seen;
  if (first == kNoId) return seen;
  std::vector<std::uint8_t> marked(end.index() - first.index(), 0);
  const auto mark = [&](LandmarkId landmark, std::uint8_t value) {
    if (!(landmark < first) && landmark < end) marked[landmark.index() - first.index()] = value;
  };
  for (const KeyFrameId id : keyframes) {
    for (const LandmarkId landmark : map.keyframe(id)->*landmarks_of) mark(landmark, 1);
  }
  for (const LandmarkId landmark : except) mark(landmark, 0);
  for (LandmarkId landmark = first; landmark < end; ++landmark) {
    if (marked[landmark.index() - first.index()] != 0) seen.push_back(landmark);
  }
  return seen;
}

}  // namespace

std::vector<PointId> PointsSeenBy(const Map& map, std::span<const KeyFrameId> keyframes,
                                  std::span<const PointId> except) {
  return SeenBy(map, keyframes, except, &KeyFrame::points);
}

std::vector<LineId> LinesSeenBy(const Map& map, std::span<const KeyFrameId> keyframes,
                                std::span<const LineId> except) {
  return SeenBy(map, keyframes, except, &KeyFrame::lines);
}

BinaryDescriptor256 DescriptorRow(const cv::Mat& descriptors, int index) {
  BinaryDescriptor256 d;
  std::memcpy(d.data(), descriptors.ptr(index), d.size());
  return d;
}

Map::Map() : index_(std::make_unique<KeyFrameIndex>()) {}
Map::~Map() = default;
Map::Map(Map&&) noexcept = default;
Map& Map::operator=(Map&&) noexcept = default;

Map Map::Clone() const {
  Map clone;
  clone.keyframes_ = keyframes_;
  clone.points_ = points_;
  clone.lines_ = lines_;
  clone.removed_ = removed_;
  clone.submaps_ = submaps_;
  clone.feature_type_ = feature_type_;
  clone.knows_feature_type_ = knows_feature_type_;
  clone.factors_ = factors_;
  return clone;
}

Map Map::CloneOf(std::span<const KeyFrameId> keyframes) const {
  Map clone;
  clone.submaps_ = submaps_;
  clone.feature_type_ = feature_type_;
  clone.knows_feature_type_ = knows_feature_type_;
  for (const KeyFrameId id : keyframes) clone.keyframes_.Put(*keyframe(id));
  const auto is_elsewhere = [&](const Observation& o) {
    return clone.keyframe(o.keyframe) == nullptr;
  };
  const auto put = [&](const auto& ids, const auto& from, auto& into) {
    for (const auto id : ids) {
      if (id == kNoId || into.Find(id) != nullptr) continue;
      std::erase_if(into.Put(*from.Find(id)).observations, is_elsewhere);
    }
  };
  for (const KeyFrameId id : keyframes) {
    put(keyframe(id)->points, points_, clone.points_);
    put(keyframe(id)->lines, lines_, clone.lines_);
  }
  return clone;
}

KeyFrame& Map::AddKeyFrame(const Frame& frame, const Pose& T_WC, SubmapId submap_id) {
  (void)submap(submap_id);  // throws if there is none
  KeyFrame& keyframe = keyframes_.Add();
  keyframe.submap = submap_id;
  Submap& made_in = submaps_[submap_id.index()];
  if (made_in.first == kNoId) made_in.first = keyframe.id;
  ++made_in.keyframes;
  keyframe.frame = frame;
  keyframe.T_WC = T_WC;
  keyframe.depth_grid = frame.features->depth_grid;
  keyframe.points.assign(frame.features->points.size(), kNoId);
  keyframe.lines.assign(frame.features->lines.size(), kNoId);
  index_->Add(keyframe.id, *frame.features);
  return keyframe;
}

MapPoint& Map::AddPoint(const Eigen::Vector3d& p_W, std::int64_t frame_index) {
  MapPoint& point = points_.Add();
  point.p_W = p_W;
  point.first_frame = frame_index;
  return point;
}

MapLine& Map::AddLine(const Segment3& segment_W, std::int64_t frame_index) {
  MapLine& line = lines_.Add();
  line.segment_W = segment_W;
  line.first_frame = frame_index;
  return line;
}

KeyFrame* Map::keyframe(KeyFrameId id) {
  return keyframes_.Find(id);
}
const KeyFrame* Map::keyframe(KeyFrameId id) const {
  return keyframes_.Find(id);
}
MapPoint* Map::point(PointId id) {
  return points_.Find(id);
}
const MapPoint* Map::point(PointId id) const {
  return points_.Find(id);
}
MapLine* Map::line(LineId id) {
  return lines_.Find(id);
}
const MapLine* Map::line(LineId id) const {
  return lines_.Find(id);
}

std::vector<KeyFrameId> Map::keyframe_ids() const {
  return keyframes_.ids();
}
std::vector<PointId> Map::point_ids() const {
  return points_.ids();
}
std::vector<LineId> Map::line_ids() const {
  return lines_.ids();
}

bool Map::ObservePoint(KeyFrameId keyframe_id, int index, PointId id) {
  KeyFrame* kf = keyframe(keyframe_id);
  return kf != nullptr && Observe(kf, kf->points, index, point(id));
}

bool Map::ObserveLine(KeyFrameId keyframe_id, int index, LineId id) {
  KeyFrame* kf = keyframe(keyframe_id);
  return kf != nullptr && Observe(kf, kf->lines, index, line(id));
}

void Map::ForgetPointObservation(KeyFrameId keyframe_id, PointId id) {
  KeyFrame* kf = keyframe(keyframe_id);
  MapPoint* p = point(id);
  if (kf == nullptr || p == nullptr) return;
  Forget(kf->points, keyframe_id, *p);
  if (p->observations.empty()) RemovePoint(id);
}

void Map::ForgetLineObservation(KeyFrameId keyframe_id, LineId id) {
  KeyFrame* kf = keyframe(keyframe_id);
  MapLine* l = line(id);
  if (kf == nullptr || l == nullptr) return;
  Forget(kf->lines, keyframe_id, *l);
  if (l->observations.empty()) RemoveLine(id);
}

void Map::RemovePoint(PointId id) {
  MapPoint* p = point(id);
  if (p == nullptr) return;
  for (const Observation& o : p->observations) {
    keyframe(o.keyframe)->points[static_cast<std::size_t>(o.index)] = kNoId;
  }
  points_.Remove(id);
}

void Map::RemoveLine(LineId id) {
  MapLine* l = line(id);
  if (l == nullptr) return;
  for (const Observation& o : l->observations) {
    keyframe(o.keyframe)->lines[static_cast<std::size_t>(o.index)] = kNoId;
  }
  lines_.Remove(id);
}

void Map::MergePoints(PointId from, PointId into) {
  if (from == into || point(from) == nullptr || point(into) == nullptr) return;
  const std::vector<Observation> moved = point(from)->observations;
  point(into)->visible += point(from)->visible;
  point(into)->found += point(from)->found;
  RemovePoint(from);
  for (const Observation& o : moved) ObservePoint(o.keyframe, o.index, into);
}

void Map::MergeLines(LineId from, LineId into) {
  if (from == into || line(from) == nullptr || line(into) == nullptr) return;
  const std::vector<Observation> moved = line(from)->observations;
  line(into)->visible += line(from)->visible;
  line(into)->found += line(from)->found;
  RemoveLine(from);
  for (const Observation& o : moved) ObserveLine(o.keyframe, o.index, into);
}

void Map::RemoveKeyFrame(KeyFrameId id, KeyFrameId parent) {
  KeyFrame* kf = keyframe(id);
  if (kf == nullptr) return;
  HIGHWALL_REQUIRE(parent != id && keyframe(parent) != nullptr,
                   "Map::RemoveKeyFrame: the parent must be another live keyframe");
  // By value: forgetting an observation writes into these lists.
  const std::vector<PointId> points = kf->points;
  const std::vector<LineId> lines = kf->lines;
  for (const PointId p : points) ForgetPointObservation(id, p);
  for (const LineId l : lines) ForgetLineObservation(id, l);
  if (KeyFrame* next = Successor(id)) {
    InertialState& motion = *next->motion;
    const bool tied = kf->motion && kf->motion->previous != kNoId;
    motion.previous = tied ? kf->motion->previous : kNoId;
    if (tied) {
      const double before = kf->motion->from_previous->delta().duration;
      const double after = motion.from_previous->delta().duration;
      motion.weight = (before * kf->motion->weight + after * motion.weight) / (before + after);
    }
    motion.from_previous = tied ? std::make_shared<const ImuPreintegration>(
                                      kf->motion->from_previous->Joined(*motion.from_previous))
                                : nullptr;
  }
  removed_[id] = {parent, keyframe(parent)->T_WC.Inverse() * kf->T_WC};
  factors_.Carry(id, parent, removed_[id].T_parent);
  index_->Remove(id, *kf->frame.features);
  --submaps_[kf->submap.index()].keyframes;
  keyframes_.Remove(id);
}

KeyFrame* Map::Successor(KeyFrameId id) {
  if (id == kNoId) return nullptr;
  // Ids ascend with time: only the next active keyframe can be the successor.
  for (KeyFrameId i = id; ++i < keyframes_.end_id();) {
    KeyFrame* next = keyframes_.Find(i);
    if (next != nullptr) return next->motion && next->motion->previous == id ? next : nullptr;
  }
  return nullptr;
}

const KeyFrame* Map::Resolve(KeyFrameId id, Pose* T) const {
  const KeyFrame* live = keyframe(id);
  while (live == nullptr) {
    const auto removed = removed_.find(id);
    if (removed == removed_.end()) return nullptr;
    *T = removed->second.T_parent * *T;
    id = removed->second.parent;
    live = keyframe(id);
  }
  return live;
}

Pose Map::ResolvePose(KeyFrameId id) const {
  Pose T;
  const KeyFrame* const live = Resolve(id, &T);
  HIGHWALL_REQUIRE(live != nullptr, "Map::ResolvePose: no such keyframe");
  return live->T_WC * T;
}

std::optional<std::pair<KeyFrameId, Pose>> Map::ActiveKeyFrameOf(KeyFrameId id) const {
  Pose T;
  const KeyFrame* const live = Resolve(id, &T);
  return live != nullptr ? std::optional(std::pair(live->id, T)) : std::nullopt;
}

std::optional<SubmapId> Map::RootOf(KeyFrameId id) const {
  Pose T;
  const KeyFrame* const live = Resolve(id, &T);
  return live != nullptr ? std::optional(Root(live->submap)) : std::nullopt;
}

bool Map::AddFactor(MapFactor factor) {
  for (AnchoredBodyPose& pose : factor.poses) {
    Pose T_live_K;
    const KeyFrame* const live = Resolve(pose.keyframe, &T_live_K);
    if (live == nullptr) return false;
    pose = {live->id, T_live_K * pose.T_KB};
  }
  factors_.Add(std::move(factor));
  return true;
}

void Map::RefreshPoint(PointId id, const PyramidOptions& pyramid) {
  MapPoint* p = point(id);
  if (p == nullptr || p->observations.empty()) return;
  std::vector<BinaryDescriptor256> descriptors;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (const Observation& o : p->observations) {
    const KeyFrame& kf = *keyframe(o.keyframe);
    descriptors.push_back(DescriptorRow(kf.frame.features->point_descriptors, o.index));
    normal += (p->p_W - kf.T_WC.p()).normalized();
  }
  p->descriptor = MostCentral(descriptors);
  p->normal_W = normal.normalized();

  // The latest observation determines the distance at which the corner matches a pyramid level.
  const Observation& last = p->observations.back();
  const KeyFrame& kf = *keyframe(last.keyframe);
  const double distance = (p->p_W - kf.T_WC.p()).norm();
  const int octave = kf.frame.features->points[static_cast<std::size_t>(last.index)].octave;
  p->max_distance = distance * std::pow(pyramid.scale_factor, octave);
  p->min_distance = p->max_distance / std::pow(pyramid.scale_factor, pyramid.levels - 1);
}

std::vector<std::pair<KeyFrameId, int>> Map::Observers(std::span<const PointId> points,
                                                       std::span<const LineId> lines) const {
  std::unordered_map<KeyFrameId, int> count;
  const auto add = [&](const auto* landmark) {
    if (landmark == nullptr) return;
    for (const Observation& o : landmark->observations) ++count[o.keyframe];
  };
  for (const PointId id : points) add(point(id));
  for (const LineId id : lines) add(line(id));
  std::vector<std::pair<KeyFrameId, int>> observers(count.begin(), count.end());
  std::sort(observers.begin(), observers.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first < b.first;
  });
  return observers;
}

std::vector<std::pair<KeyFrameId, int>> Map::Covisible(KeyFrameId id, int min_shared) const {
  const KeyFrame* kf = keyframe(id);
  if (kf == nullptr) return {};
  auto observers = Observers(kf->points, kf->lines);
  std::erase_if(observers, [&](const auto& o) { return o.first == id || o.second < min_shared; });
  return observers;
}

}  // namespace highwall
