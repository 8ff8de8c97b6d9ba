#include <highwall/core/error.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/features/orb_matcher.h>
#include <highwall/frontend/map/keyframe_index.h>
#include <highwall/frontend/map/map.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include <opencv2/core/utility.hpp>

namespace highwall {
namespace {

// Observations of a point up to this number need no memory from the heap.
constexpr std::size_t kUsualObservations = 64;

// Returns the index of the descriptor with the smallest median distance to the others.
std::size_t MostCentral(std::span<const std::uint8_t* const> descriptors) {
  std::size_t best = 0;
  int best_median = std::numeric_limits<int>::max();
  cv::AutoBuffer<int, kUsualObservations> distances(descriptors.size());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    std::ranges::transform(descriptors, distances.data(), [&](const std::uint8_t* other) {
      return HammingDistance(descriptors[i], other);
    });
    int* const end = distances.data() + descriptors.size();
    int* const middle = distances.data() + (descriptors.size() - 1) / 2;
    std::nth_element(distances.data(), middle, end);
    if (*middle < best_median) {
      best_median = *middle;
      best = i;
    }
  }
  return best;
}

}  // namespace

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
  clone.landmarks_ = landmarks_;
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
  for (const KeyFrameId id : keyframes) {
    ForEachKind([&]<class Landmark>() {
      clone.table<Landmark>().Put(table<Landmark>(), *keyframe(id), clone.keyframes_);
    });
  }
  return clone;
}

KeyFrame* Map::keyframe(KeyFrameId id) {
  return keyframes_.Find(id);
}

const KeyFrame* Map::keyframe(KeyFrameId id) const {
  return keyframes_.Find(id);
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
  ForEachKind([&]<class Landmark>() {
    PartOf<Landmark>(keyframe).assign(PartOf<Landmark>(*frame.features).size(), kNoId);
  });
  index_->Add(keyframe.id, *frame.features);
  return keyframe;
}

void Map::RemoveKeyFrame(KeyFrameId id, KeyFrameId parent) {
  KeyFrame* kf = keyframe(id);
  if (kf == nullptr) return;
  HIGHWALL_REQUIRE(parent != id && keyframe(parent) != nullptr,
                   "Map::RemoveKeyFrame: the parent must be another live keyframe");
  ForEachKind([&]<class Landmark>() {
    // By value: forgetting an observation writes into this list.
    const LandmarkIds<Landmark> observed = PartOf<Landmark>(*kf);
    for (const Id<Landmark> landmark : observed) Forget(id, landmark);
  });
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
  MapPoint* p = Find(id);
  if (p == nullptr || p->observations.empty()) return;
  cv::AutoBuffer<const std::uint8_t*, kUsualObservations> descriptors(p->observations.size());
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < p->observations.size(); ++i) {
    const Observation& o = p->observations[i];
    const KeyFrame& kf = *keyframe(o.keyframe);
    descriptors[i] = kf.frame.features->point_descriptors.ptr(o.index);
    normal += (p->p_W - kf.T_WC.p()).normalized();
  }
  const std::size_t central = MostCentral({descriptors.data(), descriptors.size()});
  std::copy_n(descriptors[central], p->descriptor.size(), p->descriptor.begin());
  p->normal_W = normal.normalized();

  // The latest observation determines the distance at which the corner matches a pyramid level.
  const Observation& last = p->observations.back();
  const KeyFrame& kf = *keyframe(last.keyframe);
  const double distance = (p->p_W - kf.T_WC.p()).norm();
  const int octave = kf.frame.features->points[static_cast<std::size_t>(last.index)].octave;
  p->max_distance = distance * std::pow(pyramid.scale_factor, octave);
  p->min_distance = p->max_distance / std::pow(pyramid.scale_factor, pyramid.levels - 1);
}

std::vector<std::pair<KeyFrameId, int>> Map::MostFirst(const std::vector<int>& count) {
  std::vector<std::pair<KeyFrameId, int>> observers;
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] > 0) observers.emplace_back(KeyFrameId(i), count[i]);
  }
  std::sort(observers.begin(), observers.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first < b.first;
  });
  return observers;
}

std::vector<std::pair<KeyFrameId, int>> Map::Covisible(KeyFrameId id, int min_shared) const {
  const KeyFrame* kf = keyframe(id);
  if (kf == nullptr) return {};
  auto observers = Observers(*kf);
  std::erase_if(observers, [&](const auto& o) { return o.first == id || o.second < min_shared; });
  return observers;
}

}  // namespace highwall
