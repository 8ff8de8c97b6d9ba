#include <highwall/mapping/keyframe_octree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <highwall/core/error.h>

#include "keyframe_rounds.h"
#include "octomap_builder_impl.h"
#include "sorted_codes.h"
#include "voxel_filter.h"

namespace highwall {
namespace {

using internal::Codes;

struct StoredScan {
  float quantum = 0.0f;  // [m]
  std::vector<std::array<std::int16_t, 3>> points_C;
};

// Stores the mean points of voxels.
StoredScan Store(std::span<const Eigen::Vector3f> points_C, double voxel_size) {
  internal::VoxelFilter filter(voxel_size);
  for (const Eigen::Vector3f& p_C : points_C) filter.Add({.p = p_C});
  const std::vector<ColoredPoint> merged = filter.Points();
  float size = 1e-6f;
  for (const ColoredPoint& point : merged) size = std::max(size, point.p.cwiseAbs().maxCoeff());
  StoredScan scan;
  scan.quantum = size / std::numeric_limits<std::int16_t>::max();
  scan.points_C.reserve(merged.size());
  for (const ColoredPoint& point : merged) {
    std::array<std::int16_t, 3>& stored = scan.points_C.emplace_back();
    for (int i = 0; i < 3; ++i) {
      stored[static_cast<std::size_t>(i)] =
          static_cast<std::int16_t>(std::lround(point.p[i] / scan.quantum));
    }
  }
  return scan;
}

}  // namespace

struct KeyframeOctree::Impl final : internal::RefillableMap {
  explicit Impl(const OctomapBuilderOptions& o) : options(o), map(o), copy(o) {}

  // Gathers the scan of a keyframe in `builder`, and lists its bricks.
  Codes Gather(std::int64_t id, const Pose& T_WC, OctomapBuilder& builder) const {
    const StoredScan& scan = scans.at(id);
    const Eigen::Matrix3f R_WC = T_WC.R().cast<float>();
    const Eigen::Vector3f p_WC = T_WC.p().cast<float>();
    std::vector<Eigen::Vector3f> points_W;
    points_W.reserve(scan.points_C.size());
    for (const auto& stored : scan.points_C) {
      const Eigen::Vector3f p_C(stored[0], stored[1], stored[2]);
      points_W.push_back(R_WC * (scan.quantum * p_C) + p_WC);
    }
    builder.impl_->bricks.clear();
    if (builder.impl_->GatherPoints(points_W, p_WC)) builder.impl_->FinishScan();
    Codes bricks;
    for (const internal::VoxelBrick* brick : builder.impl_->bricks) bricks.push_back(brick->morton);
    return bricks;
  }

  Codes Touched(std::int64_t id, const Pose& T_WC) override { return Gather(id, T_WC, copy); }
  void BeginCopy() override { copy.Clear(); }
  Codes AddToCopy(std::int64_t id, const Pose& T_WC, const Codes* region) override {
    Codes bricks = Gather(id, T_WC, copy);
    if (region != nullptr) copy.impl_->KeepBricks(*region);
    copy.impl_->Apply();
    return bricks;
  }
  void PutInPlace(const Codes* region) override {
    internal::ScanOctree& tree = map.impl_->tree;
    if (region == nullptr) {
      tree.swapContent(copy.impl_->tree);
    } else {
      tree.ReplaceBricks(*region, copy.impl_->tree);
    }
    copy.Clear();
  }

  OctomapBuilderOptions options;
  internal::KeyframeRounds rounds;
  std::map<std::int64_t, StoredScan> scans;
  OctomapBuilder map, copy;
};

KeyframeOctree::KeyframeOctree(const OctomapBuilderOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}
KeyframeOctree::~KeyframeOctree() = default;

void KeyframeOctree::SetKeyframe(std::int64_t id, std::span<const Eigen::Vector3f> points_C,
                                 const Pose& T_WC) {
  HIGHWALL_REQUIRE(T_WC.IsFinite(),
                   "the pose of keyframe " + std::to_string(id) + " is not finite");
  RemoveKeyframe(id);
  const bool last = impl_->rounds.IsLast(id);
  impl_->scans[id] = Store(points_C, 0.5 * impl_->options.resolution);
  impl_->rounds.SetPose(id, T_WC);
  if (!last) return;
  Codes bricks = impl_->Gather(id, T_WC, impl_->map);
  impl_->map.impl_->Apply();
  impl_->rounds.Join(id, std::move(bricks));
}

void KeyframeOctree::RequireKeyframe(std::int64_t id, const Pose& T_WC) const {
  HIGHWALL_REQUIRE(T_WC.IsFinite(),
                   "the pose of keyframe " + std::to_string(id) + " is not finite");
  HIGHWALL_REQUIRE(impl_->scans.contains(id), "there is no keyframe " + std::to_string(id));
}

void KeyframeOctree::SetPose(std::int64_t id, const Pose& T_WC) {
  RequireKeyframe(id, T_WC);
  impl_->rounds.SetPose(id, T_WC);
}

void KeyframeOctree::RemoveKeyframe(std::int64_t id) {
  impl_->rounds.Remove(id);
  impl_->scans.erase(id);
}

void KeyframeOctree::MoveKeyframe(std::int64_t id, const Pose& T_WC, KeyframeOctree& to) {
  RequireKeyframe(id, T_WC);
  HIGHWALL_REQUIRE(impl_->options.resolution == to.impl_->options.resolution,
                   "a scan is stored for octrees of the same resolution");
  auto scan = impl_->scans.extract(id);
  RemoveKeyframe(id);
  to.RemoveKeyframe(id);
  to.impl_->scans.insert(std::move(scan));
  to.impl_->rounds.SetPose(id, T_WC);
}

bool KeyframeOctree::Rebuild(std::chrono::duration<double> budget) {
  return impl_->rounds.Run(*impl_, budget);
}

bool KeyframeOctree::IsCurrent() const {
  return impl_->rounds.IsCurrent();
}

const OctomapBuilder& KeyframeOctree::map() const {
  return impl_->map;
}

OctomapBuilder KeyframeOctree::TakeMap() {
  impl_->scans.clear();
  impl_->rounds.Clear();
  return std::exchange(impl_->map, OctomapBuilder(impl_->options));
}

std::size_t KeyframeOctree::KeyframeCount() const {
  return impl_->scans.size();
}

std::size_t KeyframeOctree::ScanBytes() const {
  std::size_t bytes = impl_->rounds.MemoryBytes();
  for (const auto& [id, scan] : impl_->scans) {
    bytes += sizeof(scan) + scan.points_C.size() * sizeof(scan.points_C.front());
  }
  return bytes;
}

}  // namespace highwall
