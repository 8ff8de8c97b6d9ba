#include <highwall/mapping/dense_cloud.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <highwall/core/error.h>

#include "sorted_codes.h"
#include "voxel_filter.h"

namespace highwall {
namespace {

using internal::Codes;

constexpr double kBlockVoxels = 64.0;  // along an edge
constexpr float kNormalScale = 127.0f;
constexpr auto kNoBlock = std::numeric_limits<std::uint64_t>::max();

}  // namespace

void DenseCloudOptions::Validate() const {
  HIGHWALL_REQUIRE(
      voxel_size > 0.0 && std::isfinite(voxel_size),
      "DenseCloudOptions::voxel_size must be positive, is " + std::to_string(voxel_size));
  HIGHWALL_REQUIRE(max_observations >= 1,
                   "DenseCloudOptions::max_observations must be at least 1, is " +
                       std::to_string(max_observations));
  HIGHWALL_REQUIRE(min_translation >= 0.0,
                   "DenseCloudOptions::min_translation must not be negative, is " +
                       std::to_string(min_translation));
  HIGHWALL_REQUIRE(
      min_rotation >= 0.0,
      "DenseCloudOptions::min_rotation must not be negative, is " + std::to_string(min_rotation));
}

struct DenseCloud::Blocks {
  explicit Blocks(double size) : voxel_size(size) {}

  // Calls visit(point_W, block, stored) for each point of a keyframe inside of the map.
  template <typename Visit>
  void ForEachPoint(const Keyframe& keyframe, const Pose& T_WC, const Visit& visit) const {
    const Eigen::Matrix3f R_WC = T_WC.R().cast<float>();
    const Eigen::Vector3f p_WC = T_WC.p().cast<float>();
    const double inverse_block = 1.0 / (kBlockVoxels * voxel_size);
    for (const StoredPoint& stored : keyframe.points) {
      const Eigen::Vector3f p_C(stored.p_C[0], stored.p_C[1], stored.p_C[2]);
      const Eigen::Vector3f normal_C(stored.normal_C[0], stored.normal_C[1], stored.normal_C[2]);
      const ColoredPoint point{.p = R_WC * (keyframe.quantum * p_C) + p_WC,
                               .rgb = stored.rgb,
                               .normal = R_WC * (normal_C / kNormalScale)};
      const auto block = internal::VoxelCode(point.p, inverse_block);
      if (block) visit(point, *block, stored);
    }
  }

  Codes Touched(const Keyframe& keyframe, const Pose& T_WC) const {
    Codes codes;
    ForEachPoint(keyframe, T_WC, [&](const ColoredPoint&, std::uint64_t block, const auto&) {
      if (codes.empty() || codes.back() != block) codes.push_back(block);
    });
    std::ranges::sort(codes);
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
    return codes;
  }

  // Null outside of the region; no region: everywhere.
  internal::VoxelFilter* Find(std::uint64_t block, const Codes* region) {
    if (region != nullptr && !std::ranges::binary_search(*region, block)) return nullptr;
    return &filters.try_emplace(block, voxel_size).first->second;
  }

  void Add(const Keyframe& keyframe, const Pose& T_WC, const Codes* region) {
    std::uint64_t last = kNoBlock;
    internal::VoxelFilter* filter = nullptr;
    ForEachPoint(keyframe, T_WC, [&](const ColoredPoint& point, std::uint64_t block, const auto&) {
      if (block != last) filter = Find(block, region);
      last = block;
      if (filter != nullptr) filter->Add(point);
    });
  }

  double voxel_size;
  std::map<std::uint64_t, internal::VoxelFilter> filters;
};

// The region that is being put together again.
struct DenseCloud::Round {
  explicit Round(double voxel_size) : blocks(voxel_size) {}

  struct Move {
    Pose T_WC;
    Codes blocks;
  };

  bool whole = false;  // the region is all of the map
  Codes region;
  Blocks blocks;
  std::map<std::int64_t, Move> moves;
  std::int64_t next = std::numeric_limits<std::int64_t>::min();
};

DenseCloud::DenseCloud(const DenseCloudOptions& options) : options_(options) {
  options.Validate();
  blocks_ = std::make_unique<Blocks>(options.voxel_size);
}
DenseCloud::~DenseCloud() = default;

void DenseCloud::SetKeyframe(std::int64_t id, std::span<const ColoredPoint> cloud_C) {
  std::optional<Pose> T_WC;
  if (const auto old = keyframes_.find(id); old != keyframes_.end()) T_WC = old->second.T_WC;
  RemoveKeyframe(id);
  Keyframe& keyframe = keyframes_[id];
  keyframe.T_WC = T_WC;
  float size = 1e-6f;
  for (const ColoredPoint& point : cloud_C) {
    if (point.p.allFinite()) size = std::max(size, point.p.cwiseAbs().maxCoeff());
  }
  keyframe.quantum = size / std::numeric_limits<std::int16_t>::max();
  keyframe.points.reserve(cloud_C.size());
  for (const ColoredPoint& point : cloud_C) {
    if (!point.p.allFinite()) continue;
    StoredPoint& stored = keyframe.points.emplace_back();
    stored.rgb = point.rgb;
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      stored.p_C[axis] = static_cast<std::int16_t>(std::lround(point.p[i] / keyframe.quantum));
      stored.normal_C[axis] = static_cast<std::int8_t>(
          std::lround(std::clamp(point.normal[i] * kNormalScale, -kNormalScale, kNormalScale)));
    }
  }
}

void DenseCloud::SetPose(std::int64_t id, const Pose& T_WC) {
  HIGHWALL_REQUIRE(T_WC.IsFinite(),
                   "the pose of keyframe " + std::to_string(id) + " is not finite");
  const auto keyframe = keyframes_.find(id);
  HIGHWALL_REQUIRE(keyframe != keyframes_.end(), "there is no keyframe " + std::to_string(id));
  const bool first = !keyframe->second.T_WC;
  keyframe->second.T_WC = T_WC;
  const bool last = std::all_of(std::next(keyframe), keyframes_.end(),
                                [](const auto& entry) { return !entry.second.T_WC; });
  if (first && last) Append(keyframe->second);
}

void DenseCloud::Append(Keyframe& keyframe) {
  const auto limit = static_cast<std::uint32_t>(options_.max_observations);
  std::vector<StoredPoint> kept;
  blocks_->ForEachPoint(
      keyframe, *keyframe.T_WC,
      [&](const ColoredPoint& point, std::uint64_t block, const StoredPoint& stored) {
        if (blocks_->Find(block, nullptr)->Add(point, limit)) kept.push_back(stored);
      });
  kept.shrink_to_fit();
  keyframe.points = std::move(kept);
  keyframe.blocks = blocks_->Touched(keyframe, *keyframe.T_WC);
  keyframe.T_WC_in_map = keyframe.T_WC;
}

void DenseCloud::RemoveKeyframe(std::int64_t id) {
  const auto keyframe = keyframes_.find(id);
  if (keyframe == keyframes_.end()) return;
  orphaned_ = internal::Union(orphaned_, keyframe->second.blocks);
  keyframes_.erase(keyframe);
  round_.reset();
}

std::size_t DenseCloud::PointCount() const {
  std::size_t count = 0;
  for (const auto& [id, keyframe] : keyframes_) count += keyframe.points.size();
  return count;
}

std::size_t DenseCloud::MemoryBytes() const {
  std::size_t bytes = PointCount() * sizeof(StoredPoint);
  for (const auto& [code, filter] : blocks_->filters) bytes += filter.MemoryBytes();
  return bytes;
}

bool DenseCloud::HasMoved(const Keyframe& keyframe) const {
  if (!keyframe.T_WC) return false;
  if (!keyframe.T_WC_in_map) return true;
  const Pose moved = keyframe.T_WC_in_map->Inverse() * *keyframe.T_WC;
  return moved.p().norm() > options_.min_translation || moved.Angle() > options_.min_rotation;
}

bool DenseCloud::IsCurrent() const {
  return orphaned_.empty() && std::ranges::none_of(keyframes_, [this](const auto& entry) {
           return HasMoved(entry.second);
         });
}

void DenseCloud::StartRound() {
  round_ = std::make_unique<Round>(options_.voxel_size);
  round_->region = orphaned_;
  for (const auto& [id, keyframe] : keyframes_) {
    if (!HasMoved(keyframe)) continue;
    Round::Move& move = round_->moves[id];
    move.T_WC = *keyframe.T_WC;
    move.blocks = blocks_->Touched(keyframe, move.T_WC);
    round_->region = internal::Union(internal::Union(round_->region, keyframe.blocks), move.blocks);
  }
  round_->whole = 2 * round_->moves.size() >= keyframes_.size();
}

bool DenseCloud::Step() {
  Round& round = *round_;
  for (auto entry = keyframes_.lower_bound(round.next); entry != keyframes_.end(); ++entry) {
    const auto move = round.moves.find(entry->first);
    const bool moved = move != round.moves.end();
    if (!moved && !entry->second.T_WC_in_map) continue;
    const Codes& touched = moved ? move->second.blocks : entry->second.blocks;
    if (!round.whole && !internal::Intersect(touched, round.region)) continue;
    round.blocks.Add(entry->second, moved ? move->second.T_WC : *entry->second.T_WC_in_map,
                     round.whole ? nullptr : &round.region);
    if (entry->first == std::numeric_limits<std::int64_t>::max()) return false;
    round.next = entry->first + 1;
    return true;
  }
  return false;
}

void DenseCloud::FinishRound() {
  if (round_->whole) {
    blocks_->filters.swap(round_->blocks.filters);
  } else {
    for (const std::uint64_t code : round_->region) blocks_->filters.erase(code);
    blocks_->filters.merge(round_->blocks.filters);
  }
  for (auto& [id, move] : round_->moves) {
    Keyframe& keyframe = keyframes_.at(id);
    keyframe.T_WC_in_map = move.T_WC;
    keyframe.blocks = std::move(move.blocks);
  }
  orphaned_.clear();
  round_.reset();
}

bool DenseCloud::Rebuild(std::chrono::duration<double> budget) {
  const auto start = std::chrono::steady_clock::now();
  while (round_ != nullptr || !IsCurrent()) {
    if (round_ == nullptr) StartRound();
    if (!Step()) FinishRound();
    if (std::chrono::steady_clock::now() - start >= budget) break;
  }
  return round_ == nullptr && IsCurrent();
}

std::vector<ColoredPoint> DenseCloud::Merged() const {
  std::vector<ColoredPoint> points;
  for (const auto& [code, filter] : blocks_->filters) {
    const std::vector<ColoredPoint> block = filter.Points();
    points.insert(points.end(), block.begin(), block.end());
  }
  return points;
}

}  // namespace highwall
