// Dense maps of a box room (box_room.h) and their comparison.
#pragma once

#include <cstddef>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/mapping/dense_mapper.h>

namespace highwall {

// Coarse and with a short backlog, so that a room takes milliseconds and the test waits for the
// thread.
inline DenseMapOptions BoxRoomOptions(bool background) {
  DenseMapOptions options;
  options.cloud.voxel_size = 0.05;
  options.octree.resolution = 0.1;
  options.background = background;
  options.backlog = 2;
  return options;
}

// Compares all leaves bit for bit.
inline void ExpectSameLeaves(const OctomapBuilder& a, const OctomapBuilder& b) {
  const auto leaves = [](const OctomapBuilder& octree) {
    std::vector<std::tuple<double, double, double, double, float>> all;
    octree.ForEachLeaf([&](const OctreeLeaf& leaf) {
      const Eigen::Vector3d& centre = leaf.center_W;
      all.emplace_back(centre.x(), centre.y(), centre.z(), leaf.size, leaf.log_odds);
    });
    return all;
  };
  EXPECT_TRUE(leaves(a) == leaves(b));
  EXPECT_EQ(a.NodeCount(), b.NodeCount());
}

// Compares the points of the cloud as well.
inline void ExpectSameMap(const DenseMap& a, const DenseMap& b) {
  ASSERT_FALSE(a.cloud.empty());
  ASSERT_EQ(a.cloud.size(), b.cloud.size());
  for (std::size_t i = 0; i < a.cloud.size(); ++i) ASSERT_EQ(a.cloud[i].p, b.cloud[i].p) << i;
  ExpectSameLeaves(a.octree, b.octree);
}

}  // namespace highwall
