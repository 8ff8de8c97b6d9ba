#include <highwall/mapping/octomap_builder.h>

#include <cmath>
#include <string>

#include <highwall/core/error.h>

#include "octree_io.h"
#include "scan_octree.h"
#include "scan_voxels.h"

namespace highwall {
namespace {

void RequireBetween(double value, double low, double high, const char* field) {
  HIGHWALL_REQUIRE(value > low && value < high, "OctomapBuilderOptions::" + std::string(field) +
                                                    " must lie between " + std::to_string(low) +
                                                    " and " + std::to_string(high) + ", is " +
                                                    std::to_string(value));
}

}  // namespace

void OctomapBuilderOptions::Validate() const {
  HIGHWALL_REQUIRE(
      resolution > 0.0 && std::isfinite(resolution),
      "OctomapBuilderOptions::resolution must be positive, is " + std::to_string(resolution));
  HIGHWALL_REQUIRE(min_depth >= 0.0, "OctomapBuilderOptions::min_depth must not be negative, is " +
                                         std::to_string(min_depth));
  HIGHWALL_REQUIRE(max_range > 0.0, "OctomapBuilderOptions::max_range must be positive, is " +
                                        std::to_string(max_range));
  RequireBetween(hit, 0.5, 1.0, "hit");
  RequireBetween(miss, 0.0, 0.5, "miss");
  RequireBetween(clamp_min, 0.0, 0.5, "clamp_min");
  RequireBetween(clamp_max, 0.5, 1.0, "clamp_max");
  RequireBetween(occupancy_threshold, 0.0, 1.0, "occupancy_threshold");
}

struct OctomapBuilder::Impl {
  explicit Impl(const OctomapBuilderOptions& o)
      : options(o), tree(o.resolution), scan(o.resolution, o.max_range) {
    tree.setProbHit(o.hit);
    tree.setProbMiss(o.miss);
    tree.setClampingThresMin(o.clamp_min);
    tree.setClampingThresMax(o.clamp_max);
    tree.setOccupancyThres(o.occupancy_threshold);
  }

  // Null where nothing is known, or outside of the map.
  const octomap::OcTreeNode* Find(const Eigen::Vector3d& p_W) const {
    octomap::OcTreeKey key;
    if (!p_W.allFinite() || !tree.coordToKeyChecked(p_W.x(), p_W.y(), p_W.z(), key)) return nullptr;
    return tree.search(key);
  }

  OctomapBuilderOptions options;
  internal::ScanOctree tree;
  internal::ScanVoxels scan;
};

namespace {

// One scan: Add() its points in the sensor frame, then Commit(). A sensor outside of the map sees
// nothing.
class Scan {
 public:
  Scan(const Pose& T_WC, internal::ScanVoxels& voxels) : voxels_(voxels) {
    HIGHWALL_REQUIRE(T_WC.IsFinite(), "the pose is not finite");
    R_WC_ = T_WC.R().cast<float>();
    p_WC_ = T_WC.p().cast<float>();
    inside_ = voxels_.Start({p_WC_.x(), p_WC_.y(), p_WC_.z()});
  }

  void Add(const Eigen::Vector3f& p_C) {
    const Eigen::Vector3f p_W = R_WC_ * p_C + p_WC_;
    voxels_.AddEndpoint(p_W.x(), p_W.y(), p_W.z());
  }
  void Commit(internal::ScanOctree& tree) {
    if (inside_) tree.Apply(voxels_.Finish());
  }

 private:
  internal::ScanVoxels& voxels_;
  Eigen::Matrix3f R_WC_;
  Eigen::Vector3f p_WC_;
  bool inside_;
};

}  // namespace

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
  Scan scan(T_WC, impl_->scan);
  const auto min_depth = static_cast<float>(impl_->options.min_depth);
  for (int v = 0; v < depth.rows; ++v) {
    const float* const row = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      if (row[u] > 0.0f && row[u] >= min_depth) scan.Add(unprojector.Unproject(u, v, row[u]));
    }
  }
  scan.Commit(impl_->tree);
}

void OctomapBuilder::Insert(const cv::Mat& depth, const PinholeCamera& camera, const Pose& T_WC) {
  Insert(depth, DepthUnprojector(camera), T_WC);
}

void OctomapBuilder::Insert(std::span<const Eigen::Vector3f> points_C, const Pose& T_WC) {
  Scan scan(T_WC, impl_->scan);
  for (const Eigen::Vector3f& p_C : points_C) scan.Add(p_C);
  scan.Commit(impl_->tree);
}

void OctomapBuilder::InsertWorld(std::span<const Eigen::Vector3f> points_W,
                                 const Eigen::Vector3f& origin_W) {
  HIGHWALL_REQUIRE(origin_W.allFinite(), "the origin of the scan is not finite");
  internal::ScanVoxels& voxels = impl_->scan;
  if (!voxels.Start({origin_W.x(), origin_W.y(), origin_W.z()})) return;
  for (const Eigen::Vector3f& p_W : points_W) voxels.AddEndpoint(p_W.x(), p_W.y(), p_W.z());
  impl_->tree.Apply(voxels.Finish());
}

void OctomapBuilder::Clear() {
  impl_->tree.clear();
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
  // With two bits a voxel more children are equal: merged in a copy, the map keeps its log-odds.
  internal::ScanOctree merged(impl_->tree);
  merged.toMaxLikelihood();
  merged.prune();
  internal::WriteBinaryTree(path, merged);
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
