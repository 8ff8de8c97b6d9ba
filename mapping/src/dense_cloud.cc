#include <highwall/mapping/dense_cloud.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

#include "cloud_block.h"
#include "keyframe_rounds.h"
#include "sorted_codes.h"
#include "voxel_filter.h"

namespace highwall {
namespace {

using internal::CloudBlock;
using internal::Codes;

constexpr float kNormalScale = 127.0f;
constexpr auto kNoBlock = std::numeric_limits<std::uint64_t>::max();

struct StoredPoint {
  std::array<std::int16_t, 3> p_C;
  std::array<std::uint8_t, 3> rgb;
  std::array<std::int8_t, 3> normal_C;
};

struct StoredCloud {
  float quantum = 0.0f;  // [m]
  std::vector<StoredPoint> points;
};

StoredCloud Store(std::span<const ColoredPoint> cloud_C) {
  StoredCloud cloud;
  float size = 1e-6f;
  for (const ColoredPoint& point : cloud_C) {
    if (point.p.allFinite()) size = std::max(size, point.p.cwiseAbs().maxCoeff());
  }
  cloud.quantum = size / std::numeric_limits<std::int16_t>::max();
  cloud.points.reserve(cloud_C.size());
  for (const ColoredPoint& point : cloud_C) {
    if (!point.p.allFinite()) continue;
    StoredPoint& stored = cloud.points.emplace_back();
    stored.rgb = point.rgb;
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      stored.p_C[axis] = static_cast<std::int16_t>(std::lround(point.p[i] / cloud.quantum));
      stored.normal_C[axis] = static_cast<std::int8_t>(
          std::lround(std::clamp(point.normal[i] * kNormalScale, -kNormalScale, kNormalScale)));
    }
  }
  return cloud;
}

// Merged cloud: blocks by their codes.
class Blocks {
 public:
  explicit Blocks(double voxel_size) : voxel_size_(voxel_size) {}

  // Adds the points of a keyframe that lie in the region (null: everywhere). Calls added(stored
  // point) for each point accepted by a voxel of fewer than `limit` points. Returns the blocks that
  // the keyframe touches.
  template <typename Added>
  Codes Add(const StoredCloud& cloud, const Pose& T_WC, const Codes* region, std::uint32_t limit,
            const Added& added) {
    CloudBlock* block = nullptr;
    Eigen::Vector3d corner_W;
    std::uint64_t last = kNoBlock;
    Codes touched;
    ForEachPoint(cloud, T_WC,
                 [&](const ColoredPoint& point, std::uint64_t code, const StoredPoint& stored) {
                   if (code != last) {
                     touched.push_back(code);
                     block = Find(code, region);
                     corner_W = Corner(code);
                     last = code;
                   }
                   if (block == nullptr) return;
                   const Eigen::Vector3d p = (point.p.cast<double>() - corner_W) / voxel_size_;
                   if (block->Add(p.cast<float>(), point, limit)) added(stored);
                 });
    return Sorted(std::move(touched));
  }

  Codes Touched(const StoredCloud& cloud, const Pose& T_WC) const {
    Codes codes;
    ForEachPoint(cloud, T_WC, [&](const ColoredPoint&, std::uint64_t code, const StoredPoint&) {
      if (codes.empty() || codes.back() != code) codes.push_back(code);
    });
    return Sorted(std::move(codes));
  }

  // Replaces the blocks of the region (null: all blocks).
  void Replace(const Codes* region, Blocks& by) {
    if (region == nullptr) {
      blocks_.swap(by.blocks_);
      return;
    }
    for (const std::uint64_t code : *region) blocks_.erase(code);
    blocks_.merge(by.blocks_);
  }

  std::size_t PointCount() const {
    std::size_t count = 0;
    for (const auto& [code, block] : blocks_) count += block.size();
    return count;
  }
  std::size_t MemoryBytes() const {
    std::size_t bytes = 0;
    for (const auto& [code, block] : blocks_) bytes += block.MemoryBytes();
    return bytes;
  }
  void AppendPoints(std::vector<ColoredPoint>& points) const {
    for (const auto& [code, block] : blocks_) block.AppendPoints(Corner(code), voxel_size_, points);
  }
  // Appends the points and removes the blocks one by one.
  void TakePoints(std::vector<ColoredPoint>& points) {
    while (!blocks_.empty()) {
      const auto first = blocks_.begin();
      first->second.AppendPoints(Corner(first->first), voxel_size_, points);
      blocks_.erase(first);
    }
  }

 private:
  // Calls visit(point_W, code of its block, stored) for each point inside of the map.
  template <typename Visit>
  void ForEachPoint(const StoredCloud& cloud, const Pose& T_WC, const Visit& visit) const {
    const Eigen::Matrix3f R_WC = T_WC.R().cast<float>();
    const Eigen::Vector3f p_WC = T_WC.p().cast<float>();
    const double inverse_block = 1.0 / (CloudBlock::kEdge * voxel_size_);
    for (const StoredPoint& stored : cloud.points) {
      const Eigen::Vector3f p_C(stored.p_C[0], stored.p_C[1], stored.p_C[2]);
      const Eigen::Vector3f normal_C(stored.normal_C[0], stored.normal_C[1], stored.normal_C[2]);
      const ColoredPoint point{.p = R_WC * (cloud.quantum * p_C) + p_WC,
                               .rgb = stored.rgb,
                               .normal = R_WC * (normal_C / kNormalScale)};
      const auto code = internal::VoxelCode(point.p, inverse_block);
      if (code) visit(point, *code, stored);
    }
  }

  static Codes Sorted(Codes codes) {
    std::ranges::sort(codes);
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
    return codes;
  }

  // Returns null outside of the region.
  CloudBlock* Find(std::uint64_t code, const Codes* region) {
    if (region != nullptr && !std::ranges::binary_search(*region, code)) return nullptr;
    return &blocks_[code];
  }
  Eigen::Vector3d Corner(std::uint64_t code) const {
    return CloudBlock::kEdge * voxel_size_ * internal::VoxelOfCode(code).cast<double>();
  }

  double voxel_size_;
  std::map<std::uint64_t, CloudBlock> blocks_;
};

}  // namespace

void DenseCloudOptions::Validate() const {
  RequirePositiveFinite(voxel_size, "DenseCloudOptions::voxel_size");
  RequireWithin(max_observations, 1, 256, "DenseCloudOptions::max_observations");
}

struct DenseCloud::Impl final : internal::RefillableMap {
  explicit Impl(const DenseCloudOptions& o)
      : options(o), blocks(o.voxel_size), copy(o.voxel_size) {}

  Codes Touched(std::int64_t id, const Pose& T_WC) override {
    return blocks.Touched(clouds.at(id), T_WC);
  }
  void BeginCopy() override { copy = Blocks(options.voxel_size); }
  Codes AddToCopy(std::int64_t id, const Pose& T_WC, const Codes* region) override {
    return copy.Add(clouds.at(id), T_WC, region, CloudBlock::kMaxCount, [](const StoredPoint&) {});
  }
  void PutInPlace(const Codes* region) override {
    blocks.Replace(region, copy);
    copy = Blocks(options.voxel_size);
  }
  // Merges a new keyframe into the map and drops its points that no voxel accepts.
  void Append(std::int64_t id, const Pose& T_WC) {
    StoredCloud& cloud = clouds.at(id);
    std::vector<StoredPoint> kept;
    blocks.Add(cloud, T_WC, nullptr, static_cast<std::uint32_t>(options.max_observations),
               [&](const StoredPoint& stored) { kept.push_back(stored); });
    kept.shrink_to_fit();
    cloud.points = std::move(kept);
    rounds.Join(id, blocks.Touched(cloud, T_WC));
  }

  DenseCloudOptions options;
  internal::KeyframeRounds rounds;
  std::map<std::int64_t, StoredCloud> clouds;
  Blocks blocks, copy;
};

DenseCloud::DenseCloud(const DenseCloudOptions& options) {
  options.Validate();
  impl_ = std::make_unique<Impl>(options);
}
DenseCloud::~DenseCloud() = default;

void DenseCloud::SetKeyframe(std::int64_t id, std::span<const ColoredPoint> cloud_C) {
  const std::optional<Pose> T_WC = impl_->rounds.PoseOf(id);
  RemoveKeyframe(id);
  impl_->clouds[id] = Store(cloud_C);
  if (T_WC) impl_->rounds.SetPose(id, *T_WC);
}

void DenseCloud::RequireKeyframe(std::int64_t id, const Pose& T_WC) const {
  HIGHWALL_REQUIRE(T_WC.IsFinite(),
                   "the pose of keyframe " + std::to_string(id) + " is not finite");
  HIGHWALL_REQUIRE(Contains(id), "there is no keyframe " + std::to_string(id));
}

void DenseCloud::SetPose(std::int64_t id, const Pose& T_WC) {
  RequireKeyframe(id, T_WC);
  const bool joins = !impl_->rounds.PoseOf(id) && impl_->rounds.IsLast(id);
  impl_->rounds.SetPose(id, T_WC);
  if (joins) impl_->Append(id, T_WC);
}

void DenseCloud::RemoveKeyframe(std::int64_t id) {
  impl_->rounds.Remove(id);
  impl_->clouds.erase(id);
}

void DenseCloud::MoveKeyframe(std::int64_t id, const Pose& T_WC, DenseCloud& to) {
  RequireKeyframe(id, T_WC);
  auto cloud = impl_->clouds.extract(id);
  RemoveKeyframe(id);
  to.RemoveKeyframe(id);
  to.impl_->clouds.insert(std::move(cloud));
  to.impl_->rounds.SetPose(id, T_WC);
}

bool DenseCloud::Contains(std::int64_t id) const {
  return impl_->clouds.contains(id);
}

std::size_t DenseCloud::KeyframeCount() const {
  return impl_->clouds.size();
}

std::size_t DenseCloud::PointCount() const {
  std::size_t count = 0;
  for (const auto& [id, cloud] : impl_->clouds) count += cloud.points.size();
  return count;
}

std::size_t DenseCloud::MemoryBytes() const {
  return PointCount() * sizeof(StoredPoint) + impl_->blocks.MemoryBytes();
}

bool DenseCloud::IsCurrent() const {
  return impl_->rounds.IsCurrent();
}

bool DenseCloud::Rebuild(std::chrono::duration<double> budget) {
  return impl_->rounds.Run(*impl_, budget);
}

std::vector<ColoredPoint> DenseCloud::Merged() const {
  std::vector<ColoredPoint> points;
  points.reserve(impl_->blocks.PointCount());
  impl_->blocks.AppendPoints(points);
  return points;
}

std::vector<ColoredPoint> DenseCloud::TakeMerged() {
  if (impl_->rounds.MovesAll()) impl_->blocks = Blocks(impl_->options.voxel_size);
  Rebuild();
  impl_->clouds.clear();
  impl_->rounds.Clear();
  std::vector<ColoredPoint> points;
  points.reserve(impl_->blocks.PointCount());
  impl_->blocks.TakePoints(points);
  return points;
}

}  // namespace highwall
