// Plans a path along the haul road of the generated mine from its depth images.
#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octomap_builder.h>

#include "simulate/scenes/mine.h"
#include "support/grid_planner.h"

namespace highwall::haul_road_plan_test {
namespace {

TEST(HaulRoad, APlannerReachesItsGoalAlongIt) {
  simulate::SimulationOptions options = simulate::FieldTestOptions();
  options.duration = 20.0;
  options.fps = 1.0;
  options.camera = {
      .width = 160, .height = 120, .fx = 153.75, .fy = 153.75, .cx = 79.5, .cy = 59.5};
  const simulate::Simulation mine = simulate::SimulateMine(options);
  OctomapBuilder map({.resolution = 0.1});
  const DepthUnprojector unprojector(options.camera);
  std::vector<Eigen::Vector2d> driven;
  for (int i = 0; i < mine.size(); ++i) {
    const simulate::SimulatedFrame frame = mine.Render(i);
    map.Insert(frame.depth, unprojector, frame.T_WC);
    driven.push_back(frame.T_WC.p().head<2>());
  }
  const OccupancyGrid grid = TraversabilityGrid(map);
  EXPECT_GT(std::ranges::count(grid.cells, GridCell::kOccupied), 200) << "the highwall";
  // The first metres were never observed.
  const Eigen::Vector2d start = driven[8], goal = driven.back();
  ASSERT_GT((goal - start).norm(), 6.0);
  const std::vector<Cell> path = Plan(grid, CellAt(grid, start), CellAt(grid, goal));
  ASSERT_FALSE(path.empty());
  EXPECT_EQ(path.front(), CellAt(grid, goal));
  double farthest = 0.0;
  for (const auto& [i, j] : path) {
    const Eigen::Vector2d p = grid.origin_G + grid.resolution * Eigen::Vector2d(i + 0.5, j + 0.5);
    double distance = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& d : driven) distance = std::min(distance, (p - d).norm());
    farthest = std::max(farthest, distance);
  }
  EXPECT_LT(farthest, 2.2) << "half the width of the road";
}

}  // namespace
}  // namespace highwall::haul_road_plan_test
