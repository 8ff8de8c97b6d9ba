#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <highwall/internal/worker_team.h>
#include <highwall/mapping/octomap_builder.h>

#include "scan_octree.h"
#include "scan_voxels.h"

namespace highwall {

struct OctomapBuilder::Impl {
  explicit Impl(const OctomapBuilderOptions& options);

  // Returns null in unknown space and outside of the map.
  const octomap::OcTreeNode* Find(const Eigen::Vector3d& p_W) const;

  // Gathers a scan: fill(part, parts, scan) adds the endpoints of one of `parts` parts, on any
  // thread. Returns false if the origin is outside of the map. The scan is then in scans.front().
  template <typename Fill>
  bool Gather(const octomap::point3d& origin_W, const Fill& fill) {
    for (internal::ScanVoxels& scan : scans) {
      if (!scan.Start(origin_W)) return false;
    }
    // The ray of a voxel hit by two threads is cast twice: a small number of parts shares few
    // voxels.
    const std::size_t parts = scans.size() == 1 ? 1 : 2 * scans.size();
    team.Run(parts,
             [&](std::size_t worker, std::size_t part) { fill(part, parts, scans[worker]); });
    CastRays();
    return true;
  }
  // Casts the rays of all endpoints and merges the scans of the threads.
  void CastRays();
  bool GatherPoints(std::span<const Eigen::Vector3f> points_W, const Eigen::Vector3f& origin_W);
  // Lists the bricks of the gathered scan.
  void FinishScan() { bricks = scans.front().Finish(); }
  // Removes all bricks but these from the list. mortons: ascending.
  void KeepBricks(std::span<const std::uint64_t> mortons);
  // Merges the listed bricks into the tree. Call once per scan.
  void Apply();
  // Calls the change callback for the listed bricks.
  void ReportChange() const;

  OctomapBuilderOptions options;
  internal::ScanOctree tree;
  std::vector<internal::ScanVoxels> scans;    // one per worker
  std::vector<internal::ScanOctree> helpers;  // one per worker except the first
  WorkerTeam team;
  std::vector<internal::VoxelBrick*> bricks;  // of the last scan, in Morton order
  ChangeCallback on_change;
};

}  // namespace highwall
