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

  // Null where nothing is known, or outside of the map.
  const octomap::OcTreeNode* Find(const Eigen::Vector3d& p_W) const;

  // Gathers a scan: fill(part, parts, scan) adds the endpoints of one of `parts` parts, on
  // whichever thread. False if the origin lies outside of the map. The scan is then in
  // scans.front().
  template <typename Fill>
  bool Gather(const octomap::point3d& origin_W, const Fill& fill) {
    for (internal::ScanVoxels& scan : scans) {
      if (!scan.Start(origin_W)) return false;
    }
    // A voxel that two threads meet has its ray cast twice: few parts, that share few voxels.
    const std::size_t parts = scans.size() == 1 ? 1 : 2 * scans.size();
    team.Run(parts,
             [&](std::size_t worker, std::size_t part) { fill(part, parts, scans[worker]); });
    CastRays();
    return true;
  }
  // From all endpoints, and unites what the threads saw.
  void CastRays();
  bool GatherPoints(std::span<const Eigen::Vector3f> points_W, const Eigen::Vector3f& origin_W);
  // Lists the bricks of the gathered scan.
  void FinishScan() { bricks = scans.front().Finish(); }
  // Drops all others from the list. mortons: ascending.
  void KeepBricks(std::span<const std::uint64_t> mortons);
  // Merges the listed bricks into the tree. Call once a scan.
  void Apply();
  // Tells the callback. mortons: ascending.
  void ReportChange(std::span<const std::uint64_t> mortons) const;

  OctomapBuilderOptions options;
  internal::ScanOctree tree;
  std::vector<internal::ScanVoxels> scans;    // of each worker
  std::vector<internal::ScanOctree> helpers;  // of each worker but the first
  WorkerTeam team;
  std::vector<internal::VoxelBrick*> bricks;  // of the last scan, in Morton order
  ChangeCallback on_change;
};

}  // namespace highwall
