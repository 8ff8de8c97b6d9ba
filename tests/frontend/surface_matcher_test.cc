#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor.h>

#include "box_world.h"
#include "pose/surface_matcher.h"

namespace highwall::surface_matcher_test {
namespace {

const PinholeCamera kCamera = RgbdSensor{}.camera;
const DepthGrid kGrid(kCamera);
const DepthNoise kNoise = DepthNoise::Kinect();
// A box on the left, in front of the wall and above the floor: normals along x, y and z.
const testing::BoxWorld kWorld{.boxes = {{{-1.6, -0.5, 2.0}, {-0.6, 1.0, 3.0}}}};

cv::Mat Look(const Pose& T_WC, const testing::BoxWorld& world = kWorld) {
  return kGrid.Sample(testing::DepthOf(world, kCamera, T_WC), 0.3, 8.0);
}

TEST(SurfaceMatcher, PatchesLieOnTheSurfacesWithTheirNormals) {
  const auto patches = FindPatches(Look(Pose()), kGrid, kNoise);
  ASSERT_GT(patches.size(), 300U);
  std::size_t exact = 0;
  for (const SurfacePatch& patch : patches) {
    const auto fits = [&](double distance, double cosine, double tolerance) {
      return std::abs(distance) < tolerance && cosine > 1.0 - tolerance;
    };
    const auto on_surface = [&](double tolerance) {
      return fits(patch.a.z() - 4.0, -patch.n.z(), tolerance) ||  // wall
             fits(patch.a.y() - 1.0, -patch.n.y(), tolerance) ||  // floor
             fits(patch.a.z() - 2.0, -patch.n.z(), tolerance) ||  // front of the box
             fits(patch.a.x() + 0.6, patch.n.x(), tolerance);     // its side
    };
    // At the corner of the box a window may contain a little of its side.
    EXPECT_TRUE(on_surface(0.03)) << patch.a.transpose() << " with normal " << patch.n.transpose();
    exact += on_surface(1e-5) ? 1 : 0;  // floats of 4 m
  }
  EXPECT_GT(exact, 0.8 * static_cast<double>(patches.size()));
}

TEST(SurfaceMatcher, FindsNoPatchesOnRoughSurfacesOrWithoutDepth) {
  cv::Mat depth = Look(Pose());
  std::mt19937 rng(1);
  for (float& z : cv::Mat_<float>(depth)) {
    z += static_cast<float>(std::uniform_real_distribution<double>(-0.1, 0.1)(rng));
  }
  // Three sigmas of the noise are some 5 cm at the wall.
  EXPECT_LT(FindPatches(depth, kGrid, kNoise).size(), 20U);
  EXPECT_TRUE(FindPatches(cv::Mat::zeros(depth.size(), CV_32FC1), kGrid, kNoise).empty());
}

TEST(SurfaceMatcher, RowsVanishAtTheTruePose) {
  const auto patches = FindPatches(Look(Pose()), kGrid, kNoise);
  const Pose truth = Pose::FromTangent({0.05, -0.03, 0.08}, {0.02, -0.03, 0.01});
  const cv::Mat depth = Look(truth);
  const auto rows = MatchPatches(patches, depth, cv::Mat(), truth, kGrid, kNoise);
  EXPECT_EQ(rows.size(), 300U);
  int exact = 0, near = 0;
  for (const PointToPlaneRow& row : rows) {
    const double r = std::abs(row.Evaluate(truth.R(), truth.p(), nullptr));
    exact += r < 1e-2 ? 1 : 0;
    near += r < 1.0 ? 1 : 0;
  }
  // At an edge the cell may see the other surface, within the gate.
  EXPECT_GT(exact, 200);
  EXPECT_GT(near, 270);
}

TEST(SurfaceMatcher, LeavesOutDynamicObjects) {
  const cv::Mat depth = Look(Pose());
  const auto patches = FindPatches(depth, kGrid, kNoise);
  const cv::Mat moving(depth.size(), CV_8UC1, cv::Scalar(255));
  EXPECT_TRUE(MatchPatches(patches, depth, moving, Pose(), kGrid, kNoise).empty());
}

TEST(SurfaceMatcher, RowsSpreadOverTheDirectionsOfTheNormals) {
  std::vector<PointToPlaneRow> rows(1000, {.n = {0, 0, -1}});
  for (std::size_t i = 0; i < 20; ++i) rows[37 * i].n = {1, 0, 0};
  for (std::size_t i = 0; i < 200; ++i) rows[3 * i + 1].n = {0, -1, 0};
  const auto spread = SpreadOverNormals(rows, 90);
  const auto count = [&](const Eigen::Vector3d& n) {
    return std::count_if(spread.begin(), spread.end(),
                         [&](const PointToPlaneRow& row) { return row.n == n; });
  };
  const auto all = std::count_if(rows.begin(), rows.end(),
                                 [](const PointToPlaneRow& row) { return row.n.x() == 1.0; });
  ASSERT_LT(all, 30);
  EXPECT_EQ(count({1, 0, 0}), all);
  EXPECT_EQ(count({0, -1, 0}), count({0, 0, -1}));
  EXPECT_GE(spread.size(), 89U);
  EXPECT_LE(spread.size(), 90U);
  EXPECT_EQ(SpreadOverNormals(rows, 1000).size(), rows.size());
}

}  // namespace
}  // namespace highwall::surface_matcher_test
