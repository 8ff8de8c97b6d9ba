#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <highwall/core/error.h>
#include <highwall/mapping/color_octree.h>
#include <highwall/mapping/map_comparison.h>
#include <highwall/mapping/octomap_builder.h>

#include "support/file_size_limit.h"
#include "support/temporary_directory.h"

namespace highwall::octomap_file_test {
namespace {

using testing::ReadText;
using testing::TemporaryDirectory;
using testing::WriteText;

OctomapBuilder RandomMap(double resolution = 0.1) {
  OctomapBuilder map({.resolution = resolution});
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> u(-1.5f, 1.5f);
  for (int scan = 0; scan < 4; ++scan) {
    std::vector<Eigen::Vector3f> points_W;
    for (int i = 0; i < 300; ++i) points_W.emplace_back(u(rng), u(rng), 2.0f);
    map.InsertWorld(points_W, {0.1f * u(rng), 0, 0});
  }
  return map;
}

std::vector<OctreeLeaf> Leaves(const OctomapBuilder& map) {
  std::vector<OctreeLeaf> leaves;
  map.ForEachLeaf([&](const OctreeLeaf& leaf) { leaves.push_back(leaf); });
  return leaves;
}

TEST(OctomapFile, FullFormatKeepsEveryLeaf) {
  const TemporaryDirectory folder;
  const OctomapBuilder map = RandomMap(1.0 / 12.0);
  map.Write(folder / "map.ot");
  const OctomapBuilder read = OctomapBuilder::Read(folder / "map.ot");
  EXPECT_EQ(read.options().resolution, 1.0 / 12.0);
  EXPECT_EQ(read.NodeCount(), map.NodeCount());
  const auto expected = Leaves(map), actual = Leaves(read);
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].center_W, expected[i].center_W);
    EXPECT_EQ(actual[i].log_odds, expected[i].log_odds);
  }
}

TEST(OctomapFile, BinaryFormatKeepsOccupiedAndFree) {
  const TemporaryDirectory folder;
  const OctomapBuilder map = RandomMap();
  const auto before = Leaves(map);
  map.WriteBinary(folder / "map.bt");
  map.Write(folder / "map.ot");
  const OctomapBuilder read = OctomapBuilder::Read(folder / "map.bt");
  for (const OctreeLeaf& leaf : before) {
    ASSERT_EQ(read.IsOccupied(leaf.center_W), leaf.occupied);
    ASSERT_NEAR(read.Occupancy(leaf.center_W).value(), leaf.occupied ? 0.97 : 0.12, 1e-6);
  }
  EXPECT_EQ(read.Bounds().min(), map.Bounds().min());
  EXPECT_EQ(read.Bounds().max(), map.Bounds().max());
  EXPECT_LT(std::filesystem::file_size(folder / "map.bt"),
            std::filesystem::file_size(folder / "map.ot") / 4);
  // Writing leaves the map unchanged.
  EXPECT_EQ(Leaves(map).size(), before.size());
}

TEST(OctomapFile, BinaryDataAreTheFileAfterItsHeader) {
  const TemporaryDirectory folder;
  const OctomapBuilder map = RandomMap();
  map.WriteBinary(folder / "map.bt");
  const std::string file = testing::ReadText(folder / "map.bt"), header = "\ndata\n";
  EXPECT_EQ(map.BinaryData(), file.substr(file.find(header) + header.size()));
}

TEST(OctomapFile, MapsGrowOnAfterReading) {
  const TemporaryDirectory folder;
  RandomMap().Write(folder / "map.ot");
  OctomapBuilder map = RandomMap(), read = OctomapBuilder::Read(folder / "map.ot");
  const std::vector<Eigen::Vector3f> points_W = {{1.2f, 0.3f, 1.1f}, {-0.7f, 0.2f, 1.9f}};
  map.InsertWorld(points_W, {0, 0, 0});
  read.InsertWorld(points_W, {0, 0, 0});
  const auto expected = Leaves(map), actual = Leaves(read);
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].log_odds, expected[i].log_odds);
  }
}

TEST(OctomapFile, OctomapItselfReadsBothFormatsAndIsRead) {
  const TemporaryDirectory folder;
  const OctomapBuilder map = RandomMap();
  map.Write(folder / "map.ot");
  map.WriteBinary(folder / "map.bt");
  const std::unique_ptr<octomap::AbstractOcTree> full(
      octomap::AbstractOcTree::read(folder / "map.ot"));
  ASSERT_NE(full, nullptr);
  EXPECT_EQ(full->getTreeType(), "OcTree");
  EXPECT_EQ(full->getResolution(), 0.1);
  EXPECT_EQ(full->size(), map.NodeCount());
  octomap::OcTree binary(1.0);
  ASSERT_TRUE(binary.readBinary(folder / "map.bt"));
  map.ForEachLeaf([&](const OctreeLeaf& leaf) {
    const octomap::OcTreeNode* const node =
        binary.search(leaf.center_W.x(), leaf.center_W.y(), leaf.center_W.z());
    ASSERT_NE(node, nullptr);
    ASSERT_EQ(binary.isNodeOccupied(node), leaf.occupied);
  });
  std::stringstream bytes;
  binary.writeBinaryConst(bytes);
  WriteText(folder / "stock.bt", bytes.str());
  EXPECT_EQ(OctomapBuilder::Read(folder / "stock.bt").NodeCount(), binary.size());
}

TEST(OctomapFile, EmptyMapSurvivesBothFormats) {
  const TemporaryDirectory folder;
  const OctomapBuilder map;
  map.Write(folder / "map.ot");
  map.WriteBinary(folder / "map.bt");
  EXPECT_EQ(OctomapBuilder::Read(folder / "map.ot").NodeCount(), 0u);
  EXPECT_EQ(OctomapBuilder::Read(folder / "map.bt").NodeCount(), 0u);
}

TEST(OctomapFile, EveryTruncationIsAnIoError) {
  const TemporaryDirectory folder;
  const OctomapBuilder map = RandomMap(0.4);
  map.Write(folder / "map.ot");
  map.WriteBinary(folder / "map.bt");
  for (const char* name : {"map.ot", "map.bt"}) {
    const std::string bytes = ReadText(folder / name);
    ASSERT_GT(bytes.size(), 150u);
    for (std::size_t size = 0; size < bytes.size(); size += 3) {
      WriteText(folder / "cut", bytes.substr(0, size));
      EXPECT_THROW(OctomapBuilder::Read(folder / "cut"), IoError) << name << " at " << size;
    }
    WriteText(folder / "long", bytes + "x");
    EXPECT_THROW(OctomapBuilder::Read(folder / "long"), IoError);
  }
}

TEST(OctomapFile, MalformedFilesAreIoErrors) {
  const TemporaryDirectory folder;
  const auto refuses = [&](const std::string& bytes) {
    WriteText(folder / "bad", bytes);
    EXPECT_THROW(OctomapBuilder::Read(folder / "bad"), IoError) << bytes;
  };
  const std::string bt = "# Octomap OcTree binary file\n";
  const std::string ot = "# Octomap OcTree file\n";
  refuses("");
  refuses("ply\n");
  refuses(ot + "id OcTreeStamped\nsize 0\nres 0.1\ndata\n");
  refuses(ot + "id OcTree\nsize many\nres 0.1\ndata\n");
  refuses(ot + "id OcTree\nsize 0\nres 0\ndata\n");
  refuses(ot + "id OcTree\nsize 0\nres nan\ndata\n");
  refuses(ot + "id OcTree\nsize 0\ndata\n");
  refuses(ot + "id OcTree\nsize 0\nres 0.1\nwhat 1\ndata\n");
  refuses(ot + "id OcTree\nsize 2\nres 0.1\ndata\n" + std::string(5, '\0'));
  refuses(ot + "id OcTree\nsize 1\nres 0.1\ndata\n" + std::string("\0\0\xc0\x7f\0", 5));
  // An endless chain of inner nodes would exhaust the stack.
  refuses(bt + "id OcTree\nsize 100000\nres 0.1\ndata\n" + std::string(200000, '\x03'));
  EXPECT_THROW(OctomapBuilder::Read(folder / "missing.bt"), IoError);
}

TEST(OctomapFile, FailedWriteLeavesTheOldFile) {
  const TemporaryDirectory folder;
  const OctomapBuilder map = RandomMap(0.02);
  EXPECT_THROW(map.Write(folder / "nowhere/map.ot"), IoError);
  EXPECT_THROW(map.WriteBinary(folder / "nowhere/map.bt"), IoError);
  testing::ExpectAFullDiskKeeps(folder, {"map.ot", "map.bt"}, 1000, [&] {
    EXPECT_THROW(map.Write(folder / "map.ot"), IoError);
    EXPECT_THROW(map.WriteBinary(folder / "map.bt"), IoError);
  });
}

TEST(WriteColorOctree, IsReadAsTheOctreeThatItWasMadeOf) {
  const TemporaryDirectory folder;
  const OctomapBuilder map = RandomMap();
  std::vector<ColoredPoint> points;
  for (const Eigen::Vector3f& centre : OccupiedCentres(map)) {
    points.push_back({.p = centre, .rgb = {static_cast<std::uint8_t>(points.size()), 7, 200}});
  }
  WriteColorOctree(folder / "map_color.ot", map, points);
  const OctomapBuilder read = OctomapBuilder::Read(folder / "map_color.ot");
  EXPECT_EQ(read.options().resolution, 0.1);
  const auto sorted = [](std::vector<Eigen::Vector3f> centres) {
    std::ranges::sort(centres, [](const auto& a, const auto& b) {
      return std::tie(a.x(), a.y(), a.z()) < std::tie(b.x(), b.y(), b.z());
    });
    return centres;
  };
  EXPECT_EQ(sorted(OccupiedCentres(read)), sorted(OccupiedCentres(map)));
  const auto volume = [](const OctomapBuilder& of, bool occupied) {
    double sum = 0.0;
    for (const OctreeLeaf& leaf : Leaves(of)) {
      if (leaf.occupied == occupied) sum += leaf.log_odds * std::pow(leaf.size, 3);
    }
    return sum;
  };
  for (const bool occupied : {false, true}) {
    EXPECT_NEAR(volume(read, occupied), volume(map, occupied), 1e-6);
  }
  const std::string bytes = ReadText(folder / "map_color.ot");
  for (int i = 0; i < 24; ++i) {
    const std::size_t size = bytes.size() - 1 - static_cast<std::size_t>(i) * bytes.size() / 25;
    WriteText(folder / "cut.ot", bytes.substr(0, size));
    EXPECT_THROW(OctomapBuilder::Read(folder / "cut.ot"), IoError) << size;
  }
}

TEST(WriteColorOctree, IsAColorOcTreeOfTheSameSpaceWithTheColoursOfThePoints) {
  const TemporaryDirectory folder;
  OctomapBuilder map({.resolution = 0.1, .max_range = 10.0});
  const std::vector<Eigen::Vector3f> ends = {{2.05f, 0.05f, 0.05f}, {2.05f, 0.55f, 0.05f}};
  map.InsertWorld(ends, {0.05f, 0.05f, 0.05f});
  const std::vector<ColoredPoint> points = {{.p = ends[0], .rgb = {10, 20, 30}},
                                            {.p = {1.05f, 0.05f, 0.05f}, .rgb = {9, 9, 9}}};
  WriteColorOctree(folder / "map.ot", map, points);
  const std::unique_ptr<octomap::AbstractOcTree> read(
      octomap::AbstractOcTree::read((folder / "map.ot").string()));
  const auto* const tree = dynamic_cast<octomap::ColorOcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  EXPECT_EQ(tree->getResolution(), 0.1);
  std::size_t leaves = 0;
  for (auto leaf = tree->begin_leafs(); leaf != tree->end_leafs(); ++leaf) {
    const Eigen::Vector3d p(leaf.getX(), leaf.getY(), leaf.getZ());
    EXPECT_EQ(map.IsOccupied(p), tree->isNodeOccupied(*leaf));
    ++leaves;
  }
  EXPECT_GE(leaves, map.LeafCount().occupied + map.LeafCount().free);
  EXPECT_EQ(tree->search(2.05, 0.05, 0.05)->getColor(),
            octomap::ColorOcTreeNode::Color(10, 20, 30));
  EXPECT_EQ(tree->search(2.05, 0.55, 0.05)->getColor(),
            octomap::ColorOcTreeNode::Color(255, 255, 255));
  EXPECT_THROW(WriteColorOctree(folder / "nowhere/map.ot", map, points), IoError);
}

}  // namespace
}  // namespace highwall::octomap_file_test
