#include <highwall/mapping/octree_queries.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/mapping/map_comparison.h>

namespace highwall::octree_queries_test {
namespace {

using Points = std::vector<Eigen::Vector3f>;
using Eigen::Vector3d;

constexpr double kResolution = 0.05;

// The inside of a box |x|, |y|, |z| < 1.
OctomapBuilder Box() {
  OctomapBuilder map({.resolution = kResolution, .max_range = 10.0});
  Points points;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 100; ++i) {
      for (int j = 0; j < 100; ++j) {
        for (const float side : {-1.02f, 1.02f}) {
          Eigen::Vector3f p;
          p[axis] = side;
          p[(axis + 1) % 3] = -0.99f + 0.02f * static_cast<float>(i);
          p[(axis + 2) % 3] = -0.99f + 0.02f * static_cast<float>(j);
          points.push_back(p);
        }
      }
    }
  }
  map.InsertWorld(points, {0.01f, 0.01f, 0.01f});
  return map;
}

TEST(CastRay, EndsAtTheWall) {
  const OctomapBuilder map = Box();
  const auto hit = CastRay(map, {0.01, 0.01, 0.01}, {2, 0, 0}, 5.0);
  ASSERT_TRUE(hit);
  EXPECT_TRUE(hit->known);
  EXPECT_NEAR(hit->p_W.x(), 1.025, 1e-9);
  EXPECT_NEAR(hit->distance, (hit->p_W - Vector3d(0.01, 0.01, 0.01)).norm(), 1e-12);
  EXPECT_EQ(CastRay(map, {0.01, 0.01, 0.01}, {1, 0, 0}, 0.5), std::nullopt);
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    const auto any = CastRay(map, {0.01, 0.01, 0.01}, {u(rng), u(rng), u(rng)}, 5.0, true);
    ASSERT_TRUE(any);
    EXPECT_EQ(map.IsOccupied(any->p_W), true);
  }
}

TEST(CastRay, EndsAtOrPassesThroughTheUnknown) {
  const OctomapBuilder map = Box();
  const auto outside = CastRay(map, {-5, 0.01, 0.01}, {1, 0, 0}, 10.0);
  ASSERT_TRUE(outside);
  EXPECT_FALSE(outside->known);
  EXPECT_LT(outside->distance, kResolution);
  const auto through = CastRay(map, {-5, 0.01, 0.01}, {1, 0, 0}, 10.0, true);
  ASSERT_TRUE(through);
  EXPECT_TRUE(through->known);
  EXPECT_NEAR(through->p_W.x(), -1.025, 1e-9);
}

TEST(NearestObstacle, IsThatOfAnExhaustiveSearch) {
  const OctomapBuilder map = Box();
  const Points centres = OccupiedCentres(map);
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> u(-1.5, 1.5);
  for (int i = 0; i < 100; ++i) {
    const Vector3d p(u(rng), u(rng), u(rng));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3f& centre : centres) {
      const Vector3d half = Vector3d::Constant(0.5 * kResolution);
      const Vector3d at =
          p.cwiseMax(centre.cast<double>() - half).cwiseMin(centre.cast<double>() + half);
      nearest = std::min(nearest, (at - p).norm());
    }
    const auto obstacle = NearestObstacle(map, p, 10.0);
    ASSERT_TRUE(obstacle);
    // The centres above are floats.
    EXPECT_NEAR(obstacle->distance, nearest, 1e-6);
    EXPECT_NEAR((obstacle->p_W - p).norm(), obstacle->distance, 1e-12);
  }
  EXPECT_EQ(NearestObstacle(map, {0, 0, 0}, 0.5), std::nullopt);
  EXPECT_EQ(NearestObstacle(OctomapBuilder(), {0, 0, 0}, 0.5), std::nullopt);
  EXPECT_EQ(NearestObstacle(map, {1.03, 0, 0}, 0.5)->distance, 0.0);
}

// Tests a point inside, 0.5 m from a wall at 1 m, and one outside, 1.95 m from its back at 1.05 m.
TEST(NearestObstacle, ReachesAsFarAsAsked) {
  const OctomapBuilder map = Box();
  const Vector3d inside(0.5, 0.01, 0.01), outside(3.0, 0.01, 0.01);
  EXPECT_EQ(NearestObstacle(map, inside, 0.49), std::nullopt);
  EXPECT_NEAR(NearestObstacle(map, inside, 0.51)->distance, 0.5, 1e-9);
  EXPECT_EQ(NearestObstacle(map, outside, 1.94), std::nullopt);
  EXPECT_NEAR(NearestObstacle(map, outside, 1.96)->distance, 1.95, 1e-9);
}

TEST(NearestFrontier, IsAFreeVoxelBesideTheUnknown) {
  // The view is along +x through a window, and the space around the cone is unknown.
  OctomapBuilder map({.resolution = kResolution, .max_range = 10.0});
  Points points;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      points.emplace_back(2.02f, 0.02f + 0.05f * static_cast<float>(i),
                          0.02f + 0.05f * static_cast<float>(j));
    }
  }
  map.InsertWorld(points, {0.01f, 0.01f, 0.01f});
  const Vector3d p(1.5, 0.0, 0.0);
  const auto frontier = NearestFrontier(map, p, 5.0);
  ASSERT_TRUE(frontier);
  EXPECT_EQ(map.IsOccupied(*frontier), false);
  bool beside_unknown = false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-kResolution, kResolution}) {
      beside_unknown |= !map.Occupancy(*frontier + side * Vector3d::Unit(axis));
    }
  }
  EXPECT_TRUE(beside_unknown);
  // The cone is 0.75 m wide there on each side, seen at 45 degrees minus half a voxel.
  EXPECT_NEAR((*frontier - p).norm(), 0.75 * std::cos(std::atan(0.5)), 0.1);
  EXPECT_EQ(NearestFrontier(map, p, 0.3), std::nullopt);
}

TEST(OctreeQueries, RefuseNonFiniteArguments) {
  const OctomapBuilder map;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(CastRay(map, {nan, 0, 0}, {1, 0, 0}, 1.0), InvalidArgument);
  EXPECT_THROW(CastRay(map, {0, 0, 0}, {0, 0, 0}, 1.0), InvalidArgument);
  EXPECT_THROW(CastRay(map, {0, 0, 0}, {1, 0, 0}, INFINITY), InvalidArgument);
  EXPECT_THROW(NearestObstacle(map, {0, nan, 0}, 1.0), InvalidArgument);
  EXPECT_THROW(NearestObstacle(map, {0, 0, 0}, 0.0), InvalidArgument);
  EXPECT_THROW(NearestFrontier(map, {0, 0, nan}, 1.0), InvalidArgument);
}

}  // namespace
}  // namespace highwall::octree_queries_test
