// Height maps, the ground and drivable areas on a generated terrain.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/mapping/height_map.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/octree_size.h>

#include "ground_plane.h"
#include "support/grid_planner.h"

namespace highwall::terrain_test {
namespace {

using Points = std::vector<Eigen::Vector3f>;
using Height = std::function<double(double x, double y)>;
constexpr double kResolution = 0.1;

// A terrain over [0, 12] x [0, 12] m, seen from high above.
OctomapBuilder Survey(const Height& height, const Points& more = {}) {
  OctomapBuilder map({.resolution = kResolution, .max_range = 100.0});
  Points points = more;
  for (double x = 0.05; x < 12.0; x += 0.05) {
    for (double y = 0.05; y < 12.0; y += 0.05) {
      points.push_back(Eigen::Vector3d(x, y, height(x, y)).cast<float>());
    }
  }
  for (const double x : {3.01, 9.01}) {
    map.InsertWorld(points, Eigen::Vector3d(x, 6.01, 15.01).cast<float>());
  }
  return map;
}

// Two benches, 3 m apart, with a face between them and a haul road along x = 9 to 11 m that climbs
// from the lower one to the upper one at 1 in 3, with a wall next to it.
double Mine(double x, double y) {
  const bool road = x > 9.0 && x < 11.5;
  const double ramp = std::clamp((y - 1.5) / 3.0, 0.0, 3.0);
  return 0.05 + (road ? ramp : y < 6.0 ? 0.0 : 3.0);
}

TEST(MakeHeightMap, HoldsTheTerrain) {
  const HeightMap heights = MakeHeightMap(Survey(Mine));
  ASSERT_GT(heights.width, 115);
  int wrong = 0, known = 0;
  for (int j = 0; j < heights.height; ++j) {
    for (int i = 0; i < heights.width; ++i) {
      if (std::isnan(heights.At(i, j))) continue;
      ++known;
      const Eigen::Vector2d p = heights.origin_G + kResolution * Eigen::Vector2d(i + 0.5, j + 0.5);
      // One voxel, plus the rise of the ramp over half a cell.
      wrong += std::abs(heights.At(i, j) - Mine(p.x(), p.y())) > 0.1;
    }
  }
  EXPECT_GT(known, 14000);
  EXPECT_LT(wrong, known / 50) << "those on the edges of the face";
  EXPECT_TRUE(std::isnan(heights.At(-1, 0)));
  EXPECT_EQ(MakeHeightMap(OctomapBuilder()).width, 0);
}

TEST(MakeHeightMap, SeparatesTheTopFromTheGround) {
  Points roof;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      roof.emplace_back(2.0f + 0.05f * static_cast<float>(i), 2.0f + 0.05f * static_cast<float>(j),
                        4.05f);
    }
  }
  const OctomapBuilder map = Survey([](double, double) { return 0.05; }, roof);
  const HeightMap top = MakeHeightMap(map, HeightSource::kTop);
  const HeightMap ground = MakeHeightMap(map, HeightSource::kGround);
  const auto cell = [&](const HeightMap& heights, double x, double y) {
    return heights.At(static_cast<int>((x - heights.origin_G.x()) / kResolution),
                      static_cast<int>((y - heights.origin_G.y()) / kResolution));
  };
  EXPECT_NEAR(cell(top, 2.55, 2.55), 4.05, 1e-5);
  EXPECT_NEAR(cell(ground, 2.05, 2.05), 0.05, 1e-5);
  EXPECT_NEAR(cell(top, 8.05, 8.05), 0.05, 1e-5);
}

TEST(FitGroundPlane, FindsTheFloorAmongWallsAndNoise) {
  std::mt19937 rng(9);
  std::uniform_real_distribution<double> u(-3.0, 3.0);
  const Eigen::Matrix3d R_WG = so3::Exp(Eigen::Vector3d(-1.4, 0.3, 0.2)).toRotationMatrix();
  Points points;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d floor(u(rng), u(rng), -1.2 + 0.003 * u(rng));
    const Eigen::Vector3d wall(3.0, u(rng), u(rng)), clutter(u(rng), u(rng), u(rng));
    for (const Eigen::Vector3d& p_G : {floor, wall, clutter}) {
      points.push_back((R_WG * p_G).cast<float>());
    }
  }
  const Eigen::Vector3d up = R_WG.col(2);
  // The camera's estimate of the up direction has an error of 20 degrees.
  const Eigen::Vector3d expected = so3::Exp(Eigen::Vector3d(0.35, 0, 0)) * up;
  const Eigen::Vector3d eye = Eigen::Vector3d::Zero();
  const auto plane = FitGroundPlane(points, expected, eye);
  ASSERT_TRUE(plane);
  // 3000 points with 5 mm noise over 6 m, with some clutter among them.
  EXPECT_LT(std::acos(std::min(1.0, plane->up_W.dot(up))), 2e-3);
  EXPECT_NEAR(plane->height, -1.2, 3e-3);
  // The wall has as many points, and its normal could be the up direction.
  const auto wall = FitGroundPlane(points, R_WG.col(0) + 0.2 * up, 10.0 * R_WG.col(0));
  ASSERT_TRUE(wall);
  EXPECT_GT(wall->up_W.dot(R_WG.col(0)), 0.999);
  EXPECT_FALSE(FitGroundPlane(points, R_WG.col(0), eye, {.max_tilt = 20.0, .min_share = 0.2}));
  EXPECT_FALSE(FitGroundPlane(points, expected, eye, {.min_share = 0.9}));
  EXPECT_FALSE(FitGroundPlane({}, expected, eye));
  EXPECT_THROW(FitGroundPlane(points, Eigen::Vector3d::Zero(), eye), InvalidArgument);
  EXPECT_THROW(FitGroundPlane(points, expected, eye, {.max_tilt = 90.0}), InvalidArgument);
  EXPECT_THROW(FitGroundPlane(points, expected, eye, {.thickness = 0.0}), InvalidArgument);
  EXPECT_THROW(FitGroundPlane(points, expected, eye, {.min_share = 0.0}), InvalidArgument);
  EXPECT_THROW(FitGroundPlane(points, expected, eye, {.trials = 0}), InvalidArgument);
}

TEST(TraversabilityGrid, APlannerFindsTheHaulRoad) {
  const OccupancyGrid grid =
      TraversabilityGrid(Survey(Mine), {.max_slope = 25.0, .max_step = 0.25, .slope_radius = 0.5});
  const auto path = Plan(grid, CellAt(grid, {2.0, 2.0}), CellAt(grid, {2.0, 10.0}));
  ASSERT_FALSE(path.empty());
  bool on_road = true;
  for (const auto& [i, j] : path) {
    const double x = grid.origin_G.x() + grid.resolution * i;
    const double y = grid.origin_G.y() + grid.resolution * j;
    if (y > 4.5 && y < 7.5) on_road &= x > 8.9 && x < 11.6;
  }
  EXPECT_TRUE(on_road) << "the face lies between the benches, but for the road";
  // 1 in 3 is 18.4 degrees, which is too steep for another vehicle.
  const OccupancyGrid gentle =
      TraversabilityGrid(Survey(Mine), {.max_slope = 15.0, .max_step = 0.25, .slope_radius = 0.5});
  EXPECT_TRUE(Plan(gentle, CellAt(gentle, {2.0, 2.0}), CellAt(gentle, {2.0, 10.0})).empty());
}

TEST(TraversabilityGrid, LowObstaclesBlockAndHighOnesDoNot) {
  Points beams;
  for (double y = 0.0; y < 12.0; y += 0.05) {
    for (double x : {4.02, 4.07, 4.12}) beams.push_back(Eigen::Vector3d(x, y, 1.5).cast<float>());
    for (double x : {8.02, 8.07, 8.12}) beams.push_back(Eigen::Vector3d(x, y, 5.0).cast<float>());
  }
  const OccupancyGrid grid = TraversabilityGrid(Survey([](double, double) { return 0.05; }, beams));
  int low = 0, high = 0;
  for (double y = 0.5; y < 11.5; y += 0.1) {
    low += grid.Query({4.05, y}) == GridCell::kOccupied;
    high += grid.Query({8.05, y}) == GridCell::kOccupied;
  }
  EXPECT_GT(low, 90);
  EXPECT_EQ(high, 0);
  EXPECT_EQ(grid.Query({6.0, 6.0}), GridCell::kFree);
  EXPECT_EQ(grid.Query({-5.0, 6.0}), GridCell::kUnknown);
  EXPECT_EQ(TraversabilityGrid(OctomapBuilder()).width, 0);
}

// A kerb of 0.4 m, which is a slope of 11 degrees over the slope radius.
TEST(TraversabilityGrid, AKerbBlocksWhicheverWayItRuns) {
  for (const bool along_x : {true, false}) {
    const OccupancyGrid grid = TraversabilityGrid(
        Survey([&](double x, double y) { return (along_x ? y : x) > 6.01 ? 0.45 : 0.05; }));
    for (double along = 2.05; along < 10.0; along += 0.5) {
      int blocked = 0;
      for (double across = 5.55; across < 6.5; across += 0.1) {
        const Eigen::Vector2d place(along_x ? along : across, along_x ? across : along);
        blocked += grid.Query(place) == GridCell::kOccupied;
      }
      EXPECT_EQ(blocked, 2) << along << " m along it, a cell on either side";
    }
  }
}

TEST(TraversabilityOptions, RefusesValuesOutOfRange) {
  EXPECT_NO_THROW(TraversabilityOptions{}.Validate());
  EXPECT_THROW((TraversabilityOptions{.max_slope = 90.0}.Validate()), InvalidArgument);
  EXPECT_THROW((TraversabilityOptions{.max_step = 0.0}.Validate()), InvalidArgument);
  EXPECT_THROW((TraversabilityOptions{.vehicle_height = 0.3}.Validate()), InvalidArgument);
  EXPECT_THROW((TraversabilityOptions{.slope_radius = 0.0}.Validate()), InvalidArgument);
  EXPECT_THROW((TraversabilityOptions{.R_GW = Eigen::Quaterniond(0, 0, 0, 0)}.Validate()),
               InvalidArgument);
}

TEST(PredictOctreeBytes, IsRightWithinAFactorOfTwo) {
  const PinholeCamera camera{
      .width = 160, .height = 120, .fx = 131, .fy = 131, .cx = 79.5, .cy = 59.5};
  const DepthUnprojector unprojector(camera);
  std::vector<DepthView> views;
  for (int i = 0; i < 4; ++i) {
    cv::Mat depth(camera.height, camera.width, CV_32FC1);
    for (int v = 0; v < depth.rows; ++v) {
      for (int u = 0; u < depth.cols; ++u) {
        depth.at<float>(v, u) = 2.0f + 0.5f * std::sin(0.05f * static_cast<float>(u + v));
      }
    }
    views.push_back({depth, Pose(so3::Exp(Eigen::Vector3d(0, 0.2 * i, 0)), {0.1 * i, 0, 0})});
  }
  for (const double resolution : {0.1, 0.05, 0.025}) {
    const OctomapBuilderOptions options{.resolution = resolution};
    OctomapBuilder map(options);
    for (const DepthView& view : views) map.Insert(view.depth, unprojector, view.T_WC);
    const double predicted = PredictOctreeBytes(views, unprojector, options);
    EXPECT_GT(predicted, 0.5 * static_cast<double>(map.MemoryBytes())) << resolution;
    EXPECT_LT(predicted, 2.0 * static_cast<double>(map.MemoryBytes())) << resolution;
  }
  // At a tenth of a millimetre the map exceeds any machine's memory, and the prediction is still
  // fast.
  EXPECT_GT(PredictOctreeBytes(views, unprojector, {.resolution = 1e-4}), 1e10);
  EXPECT_EQ(PredictOctreeBytes({}, unprojector, {}), 0.0);
  EXPECT_THROW(PredictOctreeBytes(views, unprojector, {.resolution = 0.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::terrain_test
