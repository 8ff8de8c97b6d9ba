#include <highwall/mapping/keyframe_octree.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <highwall/core/error.h>

#include "octomap_builder_impl.h"
#include "sorted_codes.h"
#include "voxel_filter.h"

namespace highwall {
namespace {

using Bricks = internal::Codes;
using internal::Intersect;
using internal::Union;

}  // namespace

void KeyframeOctreeOptions::Validate() const {
  octree.Validate();
  HIGHWALL_REQUIRE(min_translation >= 0.0,
                   "KeyframeOctreeOptions::min_translation must not be negative, is " +
                       std::to_string(min_translation));
  HIGHWALL_REQUIRE(min_rotation >= 0.0,
                   "KeyframeOctreeOptions::min_rotation must not be negative, is " +
                       std::to_string(min_rotation));
}

// The region that is being filled again.
struct KeyframeOctree::Round {
  explicit Round(const OctomapBuilderOptions& options) : map(options) {}

  struct Move {
    Pose T_WC;
    Bricks bricks;
  };

  bool whole = false;  // the region is all of the map
  Bricks region;
  OctomapBuilder map;
  std::map<std::int64_t, Move> moves;
  std::size_t surveyed = 0;  // moves whose bricks are in the region
  std::int64_t next = std::numeric_limits<std::int64_t>::min();
};

KeyframeOctree::KeyframeOctree(const KeyframeOctreeOptions& options)
    : options_(options), map_(options.octree) {
  options.Validate();
}
KeyframeOctree::~KeyframeOctree() = default;

void KeyframeOctree::SetKeyframe(std::int64_t id, const cv::Mat& depth,
                                 const DepthUnprojector& unprojector, const Pose& T_WC) {
  unprojector.RequireDepth(depth);
  const auto min_depth =
      std::max(static_cast<float>(options_.octree.min_depth), std::numeric_limits<float>::min());
  std::vector<Eigen::Vector3f> points_C;
  for (int v = 0; v < depth.rows; ++v) {
    const float* const row = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      if (row[u] >= min_depth) points_C.push_back(unprojector.Unproject(u, v, row[u]));
    }
  }
  SetKeyframe(id, points_C, T_WC);
}

void KeyframeOctree::SetKeyframe(std::int64_t id, std::span<const Eigen::Vector3f> points_C,
                                 const Pose& T_WC) {
  HIGHWALL_REQUIRE(T_WC.IsFinite(),
                   "the pose of keyframe " + std::to_string(id) + " is not finite");
  internal::VoxelFilter filter(0.5 * options_.octree.resolution);
  for (const Eigen::Vector3f& p_C : points_C) filter.Add({.p = p_C});
  const std::vector<ColoredPoint> merged = filter.Points();
  float size = 0.0f;
  for (const ColoredPoint& point : merged) size = std::max(size, point.p.cwiseAbs().maxCoeff());

  RemoveKeyframe(id);
  const bool last = keyframes_.empty() || id > keyframes_.rbegin()->first;
  Keyframe& keyframe = keyframes_[id];
  keyframe.T_WC = T_WC;
  keyframe.quantum = std::max(size, 1e-6f) / std::numeric_limits<std::int16_t>::max();
  keyframe.points_C.reserve(merged.size());
  for (const ColoredPoint& point : merged) {
    std::array<std::int16_t, 3>& stored = keyframe.points_C.emplace_back();
    for (int i = 0; i < 3; ++i) {
      stored[static_cast<std::size_t>(i)] =
          static_cast<std::int16_t>(std::lround(point.p[i] / keyframe.quantum));
    }
  }
  if (!last) return;
  keyframe.bricks = Gather(keyframe, T_WC, map_);
  map_.impl_->Apply();
  keyframe.T_WC_in_map = T_WC;
}

void KeyframeOctree::SetPose(std::int64_t id, const Pose& T_WC) {
  HIGHWALL_REQUIRE(T_WC.IsFinite(),
                   "the pose of keyframe " + std::to_string(id) + " is not finite");
  const auto keyframe = keyframes_.find(id);
  HIGHWALL_REQUIRE(keyframe != keyframes_.end(), "there is no keyframe " + std::to_string(id));
  keyframe->second.T_WC = T_WC;
}

void KeyframeOctree::RemoveKeyframe(std::int64_t id) {
  const auto keyframe = keyframes_.find(id);
  if (keyframe == keyframes_.end()) return;
  orphaned_ = Union(orphaned_, keyframe->second.bricks);
  keyframes_.erase(keyframe);
  round_.reset();
}

void KeyframeOctree::SetChangeCallback(OctomapBuilder::ChangeCallback on_change) {
  map_.SetChangeCallback(std::move(on_change));
}

OctomapBuilder KeyframeOctree::TakeMap() {
  keyframes_.clear();
  orphaned_.clear();
  round_.reset();
  return std::exchange(map_, OctomapBuilder(options_.octree));
}

std::size_t KeyframeOctree::ScanBytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, keyframe] : keyframes_) {
    bytes += sizeof(keyframe) + keyframe.points_C.size() * sizeof(keyframe.points_C.front()) +
             keyframe.bricks.size() * sizeof(std::uint64_t);
  }
  return bytes;
}

bool KeyframeOctree::HasMoved(const Keyframe& keyframe) const {
  if (!keyframe.T_WC_in_map) return true;
  const Pose moved = keyframe.T_WC_in_map->Inverse() * keyframe.T_WC;
  return moved.p().norm() > options_.min_translation || moved.Angle() > options_.min_rotation;
}

bool KeyframeOctree::IsCurrent() const {
  return orphaned_.empty() && std::ranges::none_of(keyframes_, [this](const auto& entry) {
           return HasMoved(entry.second);
         });
}

Bricks KeyframeOctree::Gather(const Keyframe& keyframe, const Pose& T_WC, OctomapBuilder& builder) {
  const Eigen::Matrix3f R_WC = T_WC.R().cast<float>();
  const Eigen::Vector3f p_WC = T_WC.p().cast<float>();
  std::vector<Eigen::Vector3f> points_W;
  points_W.reserve(keyframe.points_C.size());
  for (const auto& stored : keyframe.points_C) {
    const Eigen::Vector3f p_C(stored[0], stored[1], stored[2]);
    points_W.push_back(R_WC * (keyframe.quantum * p_C) + p_WC);
  }
  builder.impl_->bricks.clear();
  if (builder.impl_->GatherPoints(points_W, p_WC)) builder.impl_->FinishScan();
  Bricks bricks;
  for (const internal::VoxelBrick* brick : builder.impl_->bricks) bricks.push_back(brick->morton);
  return bricks;
}

void KeyframeOctree::StartRound() {
  round_ = std::make_unique<Round>(options_.octree);
  round_->region = orphaned_;
  for (const auto& [id, keyframe] : keyframes_) {
    if (!HasMoved(keyframe)) continue;
    round_->moves[id].T_WC = keyframe.T_WC;
    round_->region = Union(round_->region, keyframe.bricks);
  }
  round_->whole = 2 * round_->moves.size() >= keyframes_.size();
}

bool KeyframeOctree::Step() {
  Round& round = *round_;
  if (!round.whole && round.surveyed < round.moves.size()) {
    auto& [id, move] = *std::next(round.moves.begin(), static_cast<std::ptrdiff_t>(round.surveyed));
    move.bricks = Gather(keyframes_.at(id), move.T_WC, round.map);
    round.region = Union(round.region, move.bricks);
    ++round.surveyed;
    return true;
  }
  for (auto entry = keyframes_.lower_bound(round.next); entry != keyframes_.end(); ++entry) {
    const auto move = round.moves.find(entry->first);
    const bool moved = move != round.moves.end();
    if (!moved && !entry->second.T_WC_in_map) continue;  // came after the round began
    const Bricks& bricks = moved ? move->second.bricks : entry->second.bricks;
    if (!round.whole && !Intersect(bricks, round.region)) continue;
    const Pose& T_WC = moved ? move->second.T_WC : *entry->second.T_WC_in_map;
    Bricks touched = Gather(entry->second, T_WC, round.map);
    if (!round.whole) round.map.impl_->KeepBricks(round.region);
    round.map.impl_->Apply();
    if (moved) move->second.bricks = std::move(touched);
    if (entry->first == std::numeric_limits<std::int64_t>::max()) return false;
    round.next = entry->first + 1;
    return true;
  }
  return false;
}

void KeyframeOctree::FinishRound() {
  internal::ScanOctree& tree = map_.impl_->tree;
  if (round_->whole) {
    tree.swapContent(round_->map.impl_->tree);
  } else {
    tree.ReplaceBricks(round_->region, round_->map.impl_->tree);
  }
  if (map_.impl_->on_change) {
    // All of the map: the region from here on includes where its keyframes were and are.
    if (round_->whole) {
      for (const auto& [id, keyframe] : keyframes_) {
        round_->region = Union(round_->region, keyframe.bricks);
      }
      for (const auto& [id, move] : round_->moves) {
        round_->region = Union(round_->region, move.bricks);
      }
    }
    map_.impl_->ReportChange(round_->region);
  }
  for (auto& [id, move] : round_->moves) {
    Keyframe& keyframe = keyframes_.at(id);
    keyframe.T_WC_in_map = move.T_WC;
    keyframe.bricks = std::move(move.bricks);
  }
  orphaned_.clear();
  round_.reset();
}

bool KeyframeOctree::Rebuild(std::chrono::duration<double> budget) {
  const auto start = std::chrono::steady_clock::now();
  while (round_ != nullptr || !IsCurrent()) {
    if (round_ == nullptr) StartRound();
    if (!Step()) FinishRound();
    if (std::chrono::steady_clock::now() - start >= budget) break;
  }
  return round_ == nullptr && IsCurrent();
}

}  // namespace highwall
