#include <highwall/mapping/octomap_builder.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

#include "octomap_builder_impl.h"
#include "octree_io.h"

namespace highwall {
namespace {

void RequireBetween(double value, double low, double high, const char* field) {
  HIGHWALL_REQUIRE(value > low && value < high,
                   "OctomapBuilderOptions::" + std::string(field) + " must lie between " +
                       FixedText(low) + " and " + FixedText(high) + ", is " + FixedText(value));
}

// With two bits per voxel more children are equal. They are merged in a copy, so that the map
// keeps its log-odds.
internal::ScanOctree MergedForTwoBits(const internal::ScanOctree& tree) {
  internal::ScanOctree merged(tree);
  merged.toMaxLikelihood();
  merged.prune();
  return merged;
}

}  // namespace

void OctomapBuilderOptions::Validate() const {
  RequirePositiveFinite(resolution, "OctomapBuilderOptions::resolution");
  RequireNotNegative(min_depth, "OctomapBuilderOptions::min_depth");
  RequirePositive(max_range, "OctomapBuilderOptions::max_range");
  RequireBetween(hit, 0.5, 1.0, "hit");
  RequireBetween(miss, 0.0, 0.5, "miss");
  RequirePositive(far_range, "OctomapBuilderOptions::far_range");
  RequireBetween(far_hit, 0.5, 1.0, "far_hit");
  RequireBetween(clamp_min, 0.0, 0.5, "clamp_min");
  RequireBetween(clamp_max, 0.5, 1.0, "clamp_max");
  RequireBetween(occupancy_threshold, 0.0, 1.0, "occupancy_threshold");
  RequireWithin(threads, 1, 256, "OctomapBuilderOptions::threads");
}

OctomapBuilder::Impl::Impl(const OctomapBuilderOptions& o)
    : options(o),
      tree(o.resolution),
      scans(static_cast<std::size_t>(o.threads),
            internal::ScanVoxels(o.resolution, o.max_range, o.far_range)),
      helpers(scans.size() - 1, tree),
      team(scans.size()) {
  tree.setProbHit(o.hit);
  tree.setProbMiss(o.miss);
  tree.setClampingThresMin(o.clamp_min);
  tree.setClampingThresMax(o.clamp_max);
  tree.setOccupancyThres(o.occupancy_threshold);
}

const octomap::OcTreeNode* OctomapBuilder::Impl::Find(const Eigen::Vector3d& p_W) const {
  octomap::OcTreeKey key;
  if (!p_W.allFinite() || !tree.coordToKeyChecked(p_W.x(), p_W.y(), p_W.z(), key)) return nullptr;
  return tree.search(key);
}

bool OctomapBuilder::Impl::GatherPoints(std::span<const Eigen::Vector3f> points_W,
                                        const Eigen::Vector3f& origin_W) {
  return Gather({origin_W.x(), origin_W.y(), origin_W.z()},
                [&](std::size_t part, std::size_t parts, internal::ScanVoxels& scan) {
                  const std::size_t begin = points_W.size() * part / parts;
                  const std::size_t end = points_W.size() * (part + 1) / parts;
                  scan.AddPoints(points_W.subspan(begin, end - begin));
                });
}

void OctomapBuilder::Impl::CastRays() {
  constexpr std::size_t kTask = 256;
  std::vector<std::span<const internal::VoxelKey>> tasks;
  for (const internal::ScanVoxels& scan : scans) {
    const auto endpoints = scan.endpoints();
    for (std::size_t begin = 0; begin < endpoints.size(); begin += kTask) {
      tasks.push_back(endpoints.subspan(begin, std::min(kTask, endpoints.size() - begin)));
    }
  }
  team.Run(tasks.size(),
           [&](std::size_t worker, std::size_t task) { scans[worker].CastRays(tasks[task]); });
  for (std::size_t worker = 1; worker < scans.size(); ++worker) scans.front().Merge(scans[worker]);
}

void OctomapBuilder::Impl::KeepBricks(std::span<const std::uint64_t> mortons) {
  auto at = mortons.begin();
  std::erase_if(bricks, [&](const internal::VoxelBrick* brick) {
    at = std::lower_bound(at, mortons.end(), brick->morton);
    return at == mortons.end() || *at != brick->morton;
  });
}

void OctomapBuilder::Impl::Apply() {
  if (!std::isfinite(options.far_range)) {
    tree.Apply(bricks, helpers, team);
  } else {
    using internal::VoxelBrick;
    std::vector<VoxelBrick*> touched = bricks;
    std::erase_if(touched, [](const VoxelBrick* b) { return !b->any_free && !b->any_occupied; });
    tree.Apply(touched, helpers, team);
    // Far hits are on separate voxels: they are applied as the hits of a second scan of lower
    // weight.
    for (VoxelBrick* brick : bricks) brick->KeepFarHits();
    touched = bricks;
    std::erase_if(touched, [](const VoxelBrick* b) { return !b->any_occupied; });
    tree.setProbHit(options.far_hit);
    tree.Apply(touched, helpers, team);
    tree.setProbHit(options.hit);
  }
  ReportChange();
}

void OctomapBuilder::Impl::ReportChange() const {
  if (!on_change || bricks.empty()) return;
  Eigen::AlignedBox3d box;
  for (const internal::VoxelBrick* brick : bricks) {
    for (int corner : {0, 8}) {
      const auto key = internal::FirstVoxel(brick->morton);
      const Eigen::Vector3d voxel(key[0] + corner, key[1] + corner, key[2] + corner);
      const Eigen::Vector3d origin = Eigen::Vector3d::Constant(internal::kKeyOffset);
      box.extend((options.resolution * (voxel - origin)).eval());
    }
  }
  on_change(box);
}

OctomapBuilder::OctomapBuilder(const OctomapBuilderOptions& options) {
  options.Validate();
  impl_ = std::make_unique<Impl>(options);
}
OctomapBuilder::~OctomapBuilder() = default;
OctomapBuilder::OctomapBuilder(OctomapBuilder&&) noexcept = default;
OctomapBuilder& OctomapBuilder::operator=(OctomapBuilder&&) noexcept = default;

const OctomapBuilderOptions& OctomapBuilder::options() const {
  return impl_->options;
}

void OctomapBuilder::Insert(const cv::Mat& depth, const DepthUnprojector& unprojector,
                            const Pose& T_WC) {
  unprojector.RequireDepth(depth);
  HIGHWALL_REQUIRE(T_WC.IsFinite(), "the pose is not finite");
  const Eigen::Matrix3f R_WC = T_WC.R().cast<float>();
  const Eigen::Vector3f p_WC = T_WC.p().cast<float>();
  const auto min_depth =
      std::max(static_cast<float>(impl_->options.min_depth), std::numeric_limits<float>::min());
  // The image is split by columns: ranges vary more from the ground to the sky than from left to
  // right.
  const auto fill = [&](std::size_t part, std::size_t parts, internal::ScanVoxels& scan) {
    const auto columns = static_cast<std::size_t>(depth.cols);
    const auto begin = static_cast<std::ptrdiff_t>(columns * part / parts);
    const auto end = static_cast<std::ptrdiff_t>(columns * (part + 1) / parts);
    for (int v = 0; v < depth.rows; ++v) {
      scan.AddDepthRow(depth.ptr<float>(v) + begin, unprojector.RowX(v) + begin,
                       unprojector.RowY(v) + begin, static_cast<int>(end - begin), min_depth, R_WC,
                       p_WC);
    }
  };
  if (!impl_->Gather({p_WC.x(), p_WC.y(), p_WC.z()}, fill)) return;
  impl_->FinishScan();
  impl_->Apply();
}

void OctomapBuilder::Insert(const cv::Mat& depth, const PinholeCamera& camera, const Pose& T_WC) {
  Insert(depth, DepthUnprojector(camera), T_WC);
}

void OctomapBuilder::Insert(std::span<const Eigen::Vector3f> points_C, const Pose& T_WC) {
  HIGHWALL_REQUIRE(T_WC.IsFinite(), "the pose is not finite");
  const Eigen::Matrix3f R_WC = T_WC.R().cast<float>();
  const Eigen::Vector3f p_WC = T_WC.p().cast<float>();
  std::vector<Eigen::Vector3f> points_W;
  points_W.reserve(points_C.size());
  for (const Eigen::Vector3f& p_C : points_C) points_W.push_back(R_WC * p_C + p_WC);
  InsertWorld(points_W, p_WC);
}

void OctomapBuilder::InsertWorld(std::span<const Eigen::Vector3f> points_W,
                                 const Eigen::Vector3f& origin_W) {
  HIGHWALL_REQUIRE(origin_W.allFinite(), "the origin of the scan is not finite");
  if (!impl_->GatherPoints(points_W, origin_W)) return;
  impl_->FinishScan();
  impl_->Apply();
}

void OctomapBuilder::SetChangeCallback(ChangeCallback on_change) {
  impl_->on_change = std::move(on_change);
}

void OctomapBuilder::Clear() {
  const Eigen::AlignedBox3d known = impl_->on_change ? Bounds() : Eigen::AlignedBox3d();
  impl_->tree.clear();
  if (!known.isEmpty()) impl_->on_change(known);
}

std::optional<double> OctomapBuilder::Occupancy(const Eigen::Vector3d& p_W) const {
  const octomap::OcTreeNode* const node = impl_->Find(p_W);
  if (node == nullptr) return std::nullopt;
  return node->getOccupancy();
}

std::optional<bool> OctomapBuilder::IsOccupied(const Eigen::Vector3d& p_W) const {
  const octomap::OcTreeNode* const node = impl_->Find(p_W);
  if (node == nullptr) return std::nullopt;
  return impl_->tree.isNodeOccupied(node);
}

void OctomapBuilder::ForEachLeaf(const std::function<void(const OctreeLeaf&)>& visit) const {
  const internal::ScanOctree& tree = impl_->tree;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    visit({.center_W = {leaf.getX(), leaf.getY(), leaf.getZ()},
           .size = leaf.getSize(),
           .log_odds = leaf->getLogOdds(),
           .occupied = tree.isNodeOccupied(*leaf)});
  }
}

OctreeLeafCount OctomapBuilder::LeafCount() const {
  OctreeLeafCount count;
  ForEachLeaf([&](const OctreeLeaf& leaf) { ++(leaf.occupied ? count.occupied : count.free); });
  return count;
}

std::size_t OctomapBuilder::NodeCount() const {
  return impl_->tree.size();
}

std::size_t OctomapBuilder::MemoryBytes() const {
  return impl_->tree.memoryUsage();
}

Eigen::AlignedBox3d OctomapBuilder::Bounds() const {
  Eigen::AlignedBox3d box;
  ForEachLeaf([&](const OctreeLeaf& leaf) {
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * leaf.size);
    box.extend(leaf.center_W - half);
    box.extend(leaf.center_W + half);
  });
  return box;
}

void OctomapBuilder::WriteBinary(const std::filesystem::path& path) const {
  internal::WriteBinaryTree(path, MergedForTwoBits(impl_->tree));
}

std::string OctomapBuilder::BinaryData() const {
  TextWriter data;
  MergedForTwoBits(impl_->tree).writeBinaryData(data);
  return data.str();
}

void OctomapBuilder::Write(const std::filesystem::path& path) const {
  internal::WriteTree(path, impl_->tree);
}

OctomapBuilder OctomapBuilder::Read(const std::filesystem::path& path,
                                    const OctomapBuilderOptions& options) {
  const internal::OctreeFile file = internal::LoadOctreeFile(path);
  OctomapBuilderOptions with_resolution = options;
  with_resolution.resolution = file.resolution;
  OctomapBuilder builder(with_resolution);
  internal::ReadPayload(file, builder.impl_->tree);
  return builder;
}

}  // namespace highwall
