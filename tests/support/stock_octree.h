#pragma once

#include <octomap/OcTree.h>

#include <highwall/mapping/octomap_builder.h>

namespace highwall {

// Returns an empty tree of the octomap library with the same sensor model.
inline octomap::OcTree StockTree(const OctomapBuilderOptions& options) {
  octomap::OcTree tree(options.resolution);
  tree.setProbHit(options.hit);
  tree.setProbMiss(options.miss);
  tree.setClampingThresMin(options.clamp_min);
  tree.setClampingThresMax(options.clamp_max);
  tree.setOccupancyThres(options.occupancy_threshold);
  return tree;
}

}  // namespace highwall
