#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/mapping/depth_camera.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of OctomapBuilder.
struct OctomapBuilderOptions {
  double resolution = 0.05;          // [m] > 0, edge of the smallest voxel
  double min_depth = 0.05;           // [m] >= 0; nearer pixels of a depth image are ignored
  double max_range = kDenseRange;    // [m] > 0, may be infinite; longer rays clear up to it and
                                     // have no end voxel
  double hit = 0.7;                  // probability in (0.5, 1) of an end voxel given the scan
  double miss = 0.4;                 // probability in (0, 0.5) of a traversed voxel
  double clamp_min = 0.12;           // probability in (0, 0.5), lower bound of a voxel
  double clamp_max = 0.97;           // probability in (0.5, 1), upper bound of a voxel
  double occupancy_threshold = 0.5;  // probability in (0, 1); a voxel is occupied at or above it
  double far_range = std::numeric_limits<double>::infinity();  // [m] > 0; an end voxel beyond it
  double far_hit = 0.6;  // is hit with this probability, in (0.5, 1), instead
  int threads = 1;       // [1, 256] that gather a scan; the map does not depend on their number

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Leaf of the octree: a cube of known space, 2^n voxels wide where a whole region has the same
// value.
struct OctreeLeaf {
  Eigen::Vector3d center_W;  // [m]
  double size = 0.0;         // [m] edge
  float log_odds = 0.0f;     // log(p / (1 - p))
  bool occupied = false;
};

// Numbers of leaves of an octree.
struct OctreeLeafCount {
  std::size_t occupied = 0;
  std::size_t free = 0;
};

// Probabilistic occupancy octree (Hornung, Wurm, Bennewitz, Stachniss and Burgard, "OctoMap",
// Autonomous Robots 2013; docs/equations.md, section 7) from depth images or points with poses.
//
// One scan updates a voxel once: by logit(hit) if a measurement ends in it, otherwise by
// logit(miss) if a ray to the centre of an end voxel passes through it; the sum is clamped (their
// Eq. 4). The map equals that of octomap::OcTree::insertPointCloud with discretize = true, leaf for
// leaf. The scan is gathered as bit masks over bricks of 8^3 voxels and merged into the octree
// brick by brick, so that inner nodes are updated and equal children merged once per scan; the
// octree is consistent between calls. With far_range, hits have a lower weight where depth is too
// noisy to distinguish voxels; near hits of the same scan take precedence over far ones.
//
// The map spans 2^15 voxels to each side of the origin of W; measurements beyond are dropped.
class OctomapBuilder {
 public:
  // Throws InvalidArgument naming the field.
  explicit OctomapBuilder(const OctomapBuilderOptions& options = {});
  ~OctomapBuilder();
  OctomapBuilder(OctomapBuilder&&) noexcept;
  OctomapBuilder& operator=(OctomapBuilder&&) noexcept;

  // Returns the options; after Read(), the resolution is that of the file.
  const OctomapBuilderOptions& options() const;

  // Inserts a depth image. depth: CV_32FC1 [m], of the size of the camera, 0 or NaN where not
  // measured; may be empty. Throws InvalidArgument for another image or a pose that is not finite.
  void Insert(const cv::Mat& depth, const DepthUnprojector& unprojector, const Pose& T_WC);
  // Overload for a single image; builds the ray table of the camera first.
  void Insert(const cv::Mat& depth, const PinholeCamera& camera, const Pose& T_WC);
  // Inserts points. points_C: [m] in the sensor frame; points that are not finite are skipped.
  void Insert(std::span<const Eigen::Vector3f> points_C, const Pose& T_WC);
  // Inserts points in the world frame. points_W: [m] in W, observed from origin_W. Throws
  // InvalidArgument if the origin is not finite.
  void InsertWorld(std::span<const Eigen::Vector3f> points_W, const Eigen::Vector3f& origin_W);

  // Callback after every change with the bounding box [m] of the change, no larger than the bricks
  // that the scan touched; an empty function disables it. It must not change the map.
  using ChangeCallback = std::function<void(const Eigen::AlignedBox3d& changed_W)>;
  void SetChangeCallback(ChangeCallback on_change);

  // Clears the map and keeps the options.
  void Clear();

  // Returns the occupancy probability of the voxel that contains p_W [m]; empty where unknown.
  std::optional<double> Occupancy(const Eigen::Vector3d& p_W) const;
  // Compares Occupancy() with the threshold; empty where unknown.
  std::optional<bool> IsOccupied(const Eigen::Vector3d& p_W) const;
  // Visits all leaves, in the order of the octree.
  void ForEachLeaf(const std::function<void(const OctreeLeaf&)>& visit) const;

  OctreeLeafCount LeafCount() const;
  std::size_t NodeCount() const;
  // Returns the memory of the octree in bytes.
  std::size_t MemoryBytes() const;
  // Returns the bounding box of the known space [m]; empty() while there is none.
  Eigen::AlignedBox3d Bounds() const;

  // Writes OctoMap's .bt: two bits per node, occupied or free (each voxel by the threshold). Throws
  // IoError; the old file is then kept.
  void WriteBinary(const std::filesystem::path& path) const;
  // Returns the content of that file after its header, as a message octomap_msgs/Octomap holds it.
  std::string BinaryData() const;
  // Writes OctoMap's .ot: full log-odds. Throws IoError; the old file is then kept.
  void Write(const std::filesystem::path& path) const;
  // Reads either format (distinguished by the first line), also of a ColorOcTree, without its
  // colours. options: all but the resolution are used. The whole file is checked first: throws
  // IoError if it is missing, truncated, too long or of another tree type.
  static OctomapBuilder Read(const std::filesystem::path& path,
                             const OctomapBuilderOptions& options = {});

 private:
  friend class KeyframeOctree;
  friend class OctreeSearch;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
