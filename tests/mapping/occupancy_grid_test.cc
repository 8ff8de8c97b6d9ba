#include <highwall/mapping/occupancy_grid.h>

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "support/file_size_limit.h"
#include "support/temporary_directory.h"

namespace highwall::occupancy_grid_test {
namespace {

using testing::ReadText;
using testing::TemporaryDirectory;

using Points = std::vector<Eigen::Vector3f>;

// A floor at z = floor_z and a wall at x = 1.02 of height 1 m, scanned from 1.2 m above the floor,
// with the whole world rotated by R_WG.
OctomapBuilder Room(const Eigen::Quaterniond& R_WG, double floor_z) {
  OctomapBuilder map({.resolution = 0.05, .max_range = 10.0});
  Points points_W;
  const auto add = [&](double x, double y, double z) {
    points_W.push_back((R_WG * Eigen::Vector3d(x, y, z)).cast<float>());
  };
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      const double a = -0.99 + 0.02 * i, b = -0.99 + 0.02 * j;
      add(a, b, floor_z);
      add(1.02, a, floor_z + 0.5 + 0.5 * b);
    }
  }
  add(0.3, 0.2, floor_z - 0.6);  // a reflection below the floor
  const Eigen::Vector3f sensor_W = (R_WG * Eigen::Vector3d(0, 0, floor_z + 1.2)).cast<float>();
  for (int i = 0; i < 3; ++i) map.InsertWorld(points_W, sensor_W);
  return map;
}

void ExpectRoom(const OccupancyGrid& grid) {
  EXPECT_EQ(grid.Query({0.0, 0.0}), GridCell::kFree);
  EXPECT_EQ(grid.Query({-0.5, 0.5}), GridCell::kFree);
  EXPECT_EQ(grid.Query({1.02, 0.0}), GridCell::kOccupied);
  EXPECT_EQ(grid.Query({1.02, -0.7}), GridCell::kOccupied);
  EXPECT_EQ(grid.Query({1.5, 0.0}), GridCell::kUnknown);
  EXPECT_EQ(grid.Query({std::nan(""), 0.0}), GridCell::kUnknown);
}

TEST(ProjectToGrid, KeepsUnknownFreeAndOccupiedApart) {
  const OctomapBuilder map = Room(Eigen::Quaterniond::Identity(), 0.025);
  const OccupancyGrid grid = ProjectToGrid(map, {.z_min = 0.1, .z_max = 0.9});
  EXPECT_EQ(grid.resolution, 0.05);
  EXPECT_EQ(grid.cells.size(), static_cast<std::size_t>(grid.width * grid.height));
  // Corners of cells are at multiples of the resolution.
  const Eigen::Vector2d corner = grid.origin_G / grid.resolution;
  EXPECT_NEAR((corner - corner.array().round().matrix()).norm(), 0.0, 1e-9);
  ExpectRoom(grid);
}

TEST(ProjectToGrid, TheBandLeavesOutTheFloorAndHigherObstacles) {
  const OctomapBuilder map = Room(Eigen::Quaterniond::Identity(), 0.025);
  EXPECT_EQ(ProjectToGrid(map, {.z_min = -0.05, .z_max = 0.9}).Query({0.5, 0.5}),
            GridCell::kOccupied);
  EXPECT_EQ(ProjectToGrid(map, {.z_min = 1.1, .z_max = 1.3}).Query({1.02, 0.0}),
            GridCell::kUnknown);
  const OccupancyGrid none = ProjectToGrid(map, {.z_min = 50.0, .z_max = 51.0});
  EXPECT_EQ(none.width, 0);
  EXPECT_TRUE(none.cells.empty());
  EXPECT_EQ(ProjectToGrid(OctomapBuilder()).height, 0);
}

TEST(ProjectToGrid, ATiltedWorldGivesTheSameRoom) {
  const Eigen::Quaterniond R_WG = Eigen::Quaterniond(0.8, -0.5, 0.2, 0.3).normalized();
  const OctomapBuilder map = Room(R_WG, -0.4);
  const auto floor = FloorHeight(map, R_WG.conjugate());
  ASSERT_TRUE(floor.has_value());
  EXPECT_NEAR(*floor, -0.4, 0.05);
  const OccupancyGrid grid =
      ProjectToGrid(map, {.z_max = 0.9, .ground_height = *floor, .R_GW = R_WG.conjugate()});
  ExpectRoom(grid);
  // The walls and the space in front of them have no holes between the samples.
  for (double y = -0.8; y < 0.8; y += 0.01) {
    EXPECT_TRUE(grid.Query({1.0, y}) == GridCell::kOccupied ||
                grid.Query({1.04, y}) == GridCell::kOccupied)
        << y;
    EXPECT_EQ(grid.Query({0.4, y}), GridCell::kFree) << y;
  }
}

TEST(FloorHeight, FindsTheFloorBelowWallsAndAboveReflections) {
  for (const double z : {-1.23, 0.0, 0.31}) {
    const auto floor = FloorHeight(Room(Eigen::Quaterniond::Identity(), z));
    ASSERT_TRUE(floor.has_value());
    EXPECT_NEAR(*floor, z, 0.03);  // half a voxel of 0.05 m
  }
  EXPECT_EQ(FloorHeight(OctomapBuilder()), std::nullopt);
  EXPECT_THROW(FloorHeight(OctomapBuilder(), Eigen::Quaterniond::Identity(), 0.0), InvalidArgument);
}

TEST(FloorHeight, LiesBetweenTwoLevelsAsTheyShareTheFloor) {
  // A quarter of the floor is in the voxels of 0.05 to 0.10 m, and the rest in those below.
  OctomapBuilder map({.resolution = 0.05, .max_range = 10.0});
  Points points_W;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      const double x = -0.99 + 0.02 * i, y = -0.99 + 0.02 * j;
      points_W.push_back(Eigen::Vector3d(x, y, x < -0.5 ? 0.06 : 0.04).cast<float>());
    }
  }
  for (int i = 0; i < 3; ++i) map.InsertWorld(points_W, Eigen::Vector3f(0, 0, 1.2f));
  const auto floor = FloorHeight(map);
  ASSERT_TRUE(floor.has_value());
  EXPECT_NEAR(*floor, 0.025 + 0.25 * 0.05, 2e-3);  // cells at the border may count or not
}

TEST(FloorHeight, AnEmptyLevelBetweenTwoIsNotTheFloor) {
  // 2 x 2 m are in the voxels of 0.10 to 0.15 m, and next to them 0.3 x 2 m in those of 0.00 to
  // 0.05 m. The level between them is empty and must not hide both.
  OctomapBuilder map({.resolution = 0.05, .max_range = 10.0});
  Points points_W;
  for (double x = -0.99; x < 1.3; x += 0.02) {
    for (double y = -0.99; y < 1.0; y += 0.02) {
      points_W.push_back(Eigen::Vector3d(x, y, x < 1.0 ? 0.12 : 0.02).cast<float>());
    }
  }
  for (int i = 0; i < 3; ++i) map.InsertWorld(points_W, Eigen::Vector3f(0, 0, 3));
  const auto floor = FloorHeight(map);
  ASSERT_TRUE(floor.has_value());
  EXPECT_DOUBLE_EQ(*floor, 0.125);
}

TEST(UprightRotation, TurnsUpToZ) {
  for (const Eigen::Vector3d& up :
       {Eigen::Vector3d(0, -2, 0), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.3, 0.4, 0.5)}) {
    EXPECT_NEAR((UprightRotation(up) * up.normalized() - Eigen::Vector3d::UnitZ()).norm(), 0.0,
                1e-12);
  }
  EXPECT_THROW(UprightRotation(Eigen::Vector3d::Zero()), InvalidArgument);
}

TEST(OccupancyGridOptions, RefusesValuesOutOfRange) {
  EXPECT_NO_THROW(OccupancyGridOptions{}.Validate());
  EXPECT_THROW((OccupancyGridOptions{.z_min = 2.0, .z_max = 2.0}.Validate()), InvalidArgument);
  EXPECT_THROW((OccupancyGridOptions{.z_max = std::nan("")}.Validate()), InvalidArgument);
  EXPECT_THROW((OccupancyGridOptions{.ground_height = INFINITY}.Validate()), InvalidArgument);
  EXPECT_THROW((OccupancyGridOptions{.R_GW = Eigen::Quaterniond(0, 0, 0, 0)}.Validate()),
               InvalidArgument);
}

OccupancyGrid SmallGrid() {
  constexpr auto kU = GridCell::kUnknown, kF = GridCell::kFree, kO = GridCell::kOccupied;
  return {.width = 3,
          .height = 2,
          .resolution = 0.05,
          .origin_G = {-1.25, 0.5},
          .cells = {kO, kF, kU, kF, kF, kU}};
}

TEST(WriteOccupancyGrid, BytesAreThoseThatMapServerReads) {
  const TemporaryDirectory folder;
  WriteOccupancyGrid(folder / "map.yaml", SmallGrid());
  // The first row of the image is the one with the largest y.
  EXPECT_EQ(ReadText(folder / "map.pgm"),
            "P5\n3 2\n255\n" + std::string("\xfe\xfe\xcd\x00\xfe\xcd", 6));
  EXPECT_EQ(ReadText(folder / "map.yaml"),
            "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.25, 0.5, 0]\n"
            "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  EXPECT_EQ(folder.FileCount(), 2u);
}

TEST(WriteOccupancyGrid, QuotesNamesThatYamlWouldMisread) {
  const TemporaryDirectory folder;
  WriteOccupancyGrid(folder / "it's: a map.yaml", SmallGrid());
  EXPECT_TRUE(ReadText(folder / "it's: a map.yaml").starts_with("image: 'it''s: a map.pgm'\n"));
  EXPECT_TRUE(std::filesystem::exists(folder / "it's: a map.pgm"));
}

TEST(WriteOccupancyGrid, FailedWriteLeavesTheOldFiles) {
  const TemporaryDirectory folder;
  OccupancyGrid grid = SmallGrid();
  EXPECT_THROW(WriteOccupancyGrid(folder / "nowhere/map.yaml", grid), IoError);
  EXPECT_THROW(WriteOccupancyGrid(folder / "map.pgm", grid), InvalidArgument);
  EXPECT_THROW(WriteOccupancyGrid(folder / "map.yaml", OccupancyGrid{}), InvalidArgument);
  grid.width = 3000;
  grid.height = 10;
  grid.cells.assign(30000, GridCell::kFree);
  testing::ExpectAFullDiskKeeps(folder, {"map.yaml", "map.pgm"}, 4096, [&] {
    EXPECT_THROW(WriteOccupancyGrid(folder / "map.yaml", grid), IoError);
  });
}

}  // namespace
}  // namespace highwall::occupancy_grid_test
