// Map: functions on submaps.
#include <algorithm>

#include <highwall/core/error.h>
#include <highwall/frontend/map/keyframe_index.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

const Map::Submap& Map::submap(SubmapId id) const {
  HIGHWALL_REQUIRE(id.index() < submaps_.size(), "Map: there is no such submap");
  return submaps_[id.index()];
}

SubmapId Map::AddSubmap() {
  const SubmapId id(submaps_.size());
  submaps_.emplace_back().root = id;
  return id;
}

SubmapId Map::Root(SubmapId id) const {
  return submap(id).root;
}

std::vector<SubmapId> Map::roots() const {
  std::vector<SubmapId> roots;
  for (const Submap& each : submaps_) {
    if (each.keyframes > 0) roots.push_back(each.root);
  }
  std::sort(roots.begin(), roots.end());
  roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
  return roots;
}

std::vector<KeyFrameId> Map::KeyFramesOf(SubmapId id) const {
  const SubmapId root = Root(id);
  std::vector<KeyFrameId> ids = keyframe_ids();
  std::erase_if(ids, [&](KeyFrameId k) { return Root(keyframe(k)->submap) != root; });
  return ids;
}

std::size_t Map::NumKeyFramesOf(SubmapId id) const {
  const SubmapId root = Root(id);
  std::size_t count = 0;
  for (const Submap& each : submaps_) {
    if (each.root == root) count += each.keyframes;
  }
  return count;
}

bool Map::IsOrigin(KeyFrameId id) const {
  const KeyFrame* const kf = keyframe(id);
  return kf != nullptr && submap(Root(kf->submap)).first == id;
}

void Map::Join(SubmapId a, SubmapId b) {
  const auto [root, other] = std::minmax({Root(a), Root(b)});
  if (root == other) return;
  for (Submap& each : submaps_) {
    if (each.root == other) each.root = root;
  }
  auto& gravity_W = submaps_[root.index()].gravity_W;
  if (!gravity_W) gravity_W = submap(other).gravity_W;
  factors_.Join(root, other);
}

void Map::RemoveSubmap(SubmapId id) {
  for (const KeyFrameId k : KeyFramesOf(id)) {
    KeyFrame& kf = *keyframe(k);
    ForEachKind([&]<class Landmark>() {
      // By value: removing a landmark writes into this list.
      const LandmarkIds<Landmark> observed = PartOf<Landmark>(kf);
      for (const Id<Landmark> landmark : observed) Remove(landmark);
    });
    index_->Remove(k, *kf.frame.features);
    --submaps_[kf.submap.index()].keyframes;
    factors_.Remove(k);
    keyframes_.Remove(k);
  }
}

void Map::Transform(const Pose& T_new_old) {
  Move(T_new_old, [](KeyFrameId) { return true; });
  for (Submap& each : submaps_) {
    if (each.gravity_W) each.gravity_W = T_new_old.q() * *each.gravity_W;
  }
  for (const SubmapId root : roots()) factors_.Transform(root, T_new_old);
}

void Map::Transform(const Pose& T_new_old, SubmapId id) {
  const SubmapId root = Root(id);
  Move(T_new_old, [&](KeyFrameId k) { return Root(keyframe(k)->submap) == root; });
  if (auto& gravity_W = submaps_[root.index()].gravity_W) {
    gravity_W = T_new_old.q() * *gravity_W;
  }
  factors_.Transform(root, T_new_old);
}

template <class Takes>
void Map::Move(const Pose& T_new_old, const Takes& takes) {
  const Eigen::Quaterniond q = T_new_old.q();
  const auto follows = [&](const auto& landmark) {
    return landmark.observations.empty() || takes(landmark.observations.front().keyframe);
  };
  for (KeyFrame& kf : keyframes_) {
    if (!takes(kf.id)) continue;
    kf.T_WC = T_new_old * kf.T_WC;
    if (kf.motion) kf.motion->v_WB = q * kf.motion->v_WB;
  }
  ForEachKind([&]<class Landmark>() {
    table<Landmark>().ForEach([&](Landmark& landmark) {
      if (!follows(landmark)) return;
      auto& position = LandmarkTraits<Landmark>::PositionOf(landmark);
      position = T_new_old * position;
      LandmarkTraits<Landmark>::Rotate(q, landmark);
    });
  });
}

const std::optional<Eigen::Vector3d>& Map::gravity_W(SubmapId id) const {
  return submap(Root(id)).gravity_W;
}

void Map::SetGravity(const std::optional<Eigen::Vector3d>& gravity_W, SubmapId id) {
  submaps_[Root(id).index()].gravity_W = gravity_W;
}

}  // namespace highwall
