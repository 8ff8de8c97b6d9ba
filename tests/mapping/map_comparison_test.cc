#include <highwall/mapping/map_comparison.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::map_comparison_test {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// Points at every centimetre of [0, 1] x [0, width] at height z.
Points Sheet(float z, float width = 1.0f) {
  Points points;
  for (int i = 0; i <= 100; ++i) {
    for (int j = 0; j <= static_cast<int>(100.0f * width); ++j) {
      points.emplace_back(0.01f * static_cast<float>(i), 0.01f * static_cast<float>(j), z);
    }
  }
  return points;
}

TriangleMesh UnitSquare() {
  return {{{.p = {0, 0, 0}}, {.p = {1, 0, 0}}, {.p = {1, 1, 0}}, {.p = {0, 1, 0}}},
          {{0, 1, 2}, {0, 2, 3}}};
}

TEST(CompareMaps, ASheetAboveAnotherIsOffByItsHeight) {
  const MapComparison result = CompareMaps(Sheet(0.03f), ReferenceSurface(Sheet(0.0f)));
  // Rounding of float coordinates of 1 m.
  EXPECT_NEAR(result.accuracy.mean, 0.03, 1e-6);
  EXPECT_NEAR(result.accuracy.median, 0.03, 1e-6);
  EXPECT_NEAR(result.completeness.percentile_90, 0.03, 1e-6);
  EXPECT_EQ(result.accuracy.count, 101u * 101u);
  ASSERT_EQ(result.thresholds.size(), 3u);
  EXPECT_EQ(result.thresholds[0].f_score, 0.0);  // 2 cm
  EXPECT_EQ(result.thresholds[1].f_score, 1.0);  // 5 cm
}

TEST(CompareMaps, SeparatesMissingFromWrongParts) {
  // Half of the surface is present and exact.
  const MapComparison result = CompareMaps(Sheet(0.0f, 0.5f), ReferenceSurface(Sheet(0.0f)));
  EXPECT_EQ(result.accuracy.percentile_90, 0.0);
  EXPECT_GT(result.completeness.percentile_90, 0.35);
  EXPECT_EQ(result.thresholds[0].precision, 1.0);
  EXPECT_NEAR(result.thresholds[0].recall, 0.52, 0.015);  // 50 cm and a margin of 2 cm
  EXPECT_NEAR(result.thresholds[0].f_score, 2.0 * 0.52 / 1.52, 0.015);
}

TEST(CompareMaps, DistancesToAMeshAreExact) {
  // The points lie off the samples, and their distances do not depend on the sample spacing.
  std::mt19937 rng(2);
  std::uniform_real_distribution<float> u(0.0f, 1.0f);
  Points points;
  for (int i = 0; i < 500; ++i) points.emplace_back(u(rng), u(rng), 0.004f);
  const MapComparison result = CompareMaps(points, ReferenceSurface(UnitSquare(), 0.05));
  EXPECT_NEAR(result.accuracy.mean, 0.004, 1e-7);
  EXPECT_NEAR(result.accuracy.percentile_90, 0.004, 1e-7);
}

TEST(ReferenceSurface, SamplesCoverAMeshEvenly) {
  const ReferenceSurface surface(UnitSquare(), 0.02);
  // About one sample per square of 2 cm.
  EXPECT_GT(surface.samples().size(), 2200u);
  EXPECT_LT(surface.samples().size(), 3000u);
  EXPECT_THROW(ReferenceSurface(UnitSquare(), 0.0), InvalidArgument);
  EXPECT_THROW(ReferenceSurface(UnitSquare(), 1e-5), InvalidArgument);
  EXPECT_THROW(ReferenceSurface(TriangleMesh{}, 0.1), InvalidArgument);
  EXPECT_THROW(ReferenceSurface(Points{}), InvalidArgument);
  EXPECT_THROW(CompareMaps(Points{{NAN, 0, 0}}, surface), InvalidArgument);
}

TEST(SquaredDistanceToTriangle, KnowsFaceEdgesAndCorners) {
  const std::array<Eigen::Vector3f, 3> triangle = {
      Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(2, 0, 0), Eigen::Vector3f(0, 2, 0)};
  EXPECT_FLOAT_EQ(SquaredDistanceToTriangle({0.5f, 0.5f, 3}, triangle), 9.0f);
  EXPECT_FLOAT_EQ(SquaredDistanceToTriangle({1, -2, 0}, triangle), 4.0f);
  EXPECT_FLOAT_EQ(SquaredDistanceToTriangle({2, 2, 1}, triangle), 3.0f);  // distance to x + y = 2
  EXPECT_FLOAT_EQ(SquaredDistanceToTriangle({-3, -4, 0}, triangle), 25.0f);
  const std::array<Eigen::Vector3f, 3> needle = {triangle[0], triangle[1], triangle[1]};
  EXPECT_FLOAT_EQ(SquaredDistanceToTriangle({1, 0, 5}, needle), 25.0f);
}

TEST(MarkSeen, TestsTheDepthOfEachPoint) {
  const PinholeCamera camera{.width = 64, .height = 48, .fx = 60, .fy = 60, .cx = 32, .cy = 24};
  const DepthView view{cv::Mat(48, 64, CV_32FC1, cv::Scalar(2.0f)), Pose()};
  const Points points = {{0, 0, 2.0f}, {0, 0, 2.04f}, {0, 0, 2.1f},      {0, 0, 1.9f},
                         {5, 0, 2.0f}, {0, 0, -2.0f}, {0.5f, 0.5f, 2.0f}};
  std::vector<char> seen(points.size(), 0);
  seen[2] = 1;  // seen in an earlier view
  MarkSeen(points, view, camera, 0.05, seen);
  EXPECT_EQ(seen, (std::vector<char>{1, 1, 1, 0, 0, 0, 1}));
  std::vector<char> short_one(1, 0);
  EXPECT_THROW(MarkSeen(points, view, camera, 0.05, short_one), InvalidArgument);
  EXPECT_THROW(MarkSeen(points, {cv::Mat(), Pose()}, camera, 0.05, seen), InvalidArgument);
  ReferenceSurface surface(points);
  surface.KeepSamples(seen);
  EXPECT_EQ(surface.samples().size(), 4u);
  EXPECT_THROW(surface.KeepSamples({1}), InvalidArgument);
  EXPECT_THROW(surface.KeepSamples({0, 0, 0, 0}), InvalidArgument);
}

TEST(OccupiedCentres, AreThoseOfTheSmallestVoxels) {
  OctomapBuilder map({.resolution = 0.1, .max_range = 10.0});
  Points wall;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      for (int k = 0; k < 8; ++k) {
        const Eigen::Vector3i index(i, j, k);
        wall.push_back(0.1f * index.cast<float>() + Eigen::Vector3f::Constant(0.05f));
      }
    }
  }
  map.InsertWorld(wall, {0.05f, 0.05f, 0.05f});
  EXPECT_EQ(map.LeafCount().occupied, 1u) << "all merged";
  EXPECT_EQ(OccupiedCentres(map).size(), 512u);
}

}  // namespace
}  // namespace highwall::map_comparison_test
