#include "calibration/depth_motion.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/so3.h>

#include "features/depth_grid.h"

namespace highwall::depth_motion_test {
namespace {

// Points on a surface whose depth changes in both directions, before and after a motion.
struct Pair {
  FrameFeatures first, second;
  std::vector<FeatureMatch> matches;
};

const RgbdSensor kSensor{};

Pair See(const Pose& T_21, unsigned seed) {
  const PinholeCamera& camera = kSensor.camera;
  const DepthGrid grid(camera);
  Pair pair;
  pair.first.depth_grid = cv::Mat(grid.camera().height, grid.camera().width, CV_32FC1);
  for (int v = 0; v < grid.camera().height; ++v) {
    for (int u = 0; u < grid.camera().width; ++u) {
      pair.first.depth_grid.at<float>(v, u) =
          static_cast<float>(1.0 + 0.04 * u + 0.05 * v + 0.5 * std::sin(0.4 * u));
    }
  }
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(0.0, camera.width - 1.0), v(0.0, camera.height - 1.0);
  std::normal_distribution<double> noise(0.0, 0.3);  // [px]
  for (int i = 0; i < 100; ++i) {
    PointFeature a, b;
    a.uv.x() = u(rng);
    a.uv.y() = v(rng);
    a.depth = pair.first.depth_grid.at<float>(grid.CellOf(a.uv));
    const Eigen::Vector3d p_2 = T_21 * camera.Unproject(a.uv, a.depth);
    b.uv = camera.Project(p_2);
    b.uv.x() += noise(rng);
    b.uv.y() += noise(rng);
    b.depth = p_2.z();
    pair.first.points.push_back(a);
    pair.second.points.push_back(b);
    pair.matches.push_back({i, i});
  }
  return pair;
}

// Adds eight pairs, whose depth images are changed.
template <class Change>
void AddPairs(const Pose& T_21, const Change& change, DepthMotion* motion) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Pair pair = See(T_21, seed);
    change(pair.first.depth_grid);
    motion->Add(pair.first, pair.second, pair.matches);
  }
}

const Pose kMotion(so3::Exp({0.02, -0.03, 0.01}), {0.15, -0.05, 0.1});

TEST(DepthMotion, FindsNothingWhereDepthIsRight) {
  const MeasurementModel model(kSensor, {});
  DepthMotion motion(model);
  AddPairs(
      kMotion, [](cv::Mat&) {}, &motion);
  EXPECT_FALSE(motion.Misread());
}

TEST(DepthMotion, FindsNothingWhereOnlyTheScaleIsWrong) {
  const MeasurementModel model(kSensor, {});
  DepthMotion motion(model);
  AddPairs(
      kMotion, [](cv::Mat& depth) { depth *= 0.2; }, &motion);
  EXPECT_FALSE(motion.Misread());
}

TEST(DepthMotion, NamesEachFlip) {
  const MeasurementModel model(kSensor, {});
  const std::vector<std::pair<int, std::string>> flips = {
      {1, "left to right"}, {0, "upside down"}, {-1, "turned by 180 degrees"}};
  for (const auto& [axis, text] : flips) {
    DepthMotion motion(model);
    AddPairs(
        kMotion, [axis = axis](cv::Mat& depth) { cv::flip(depth, depth, axis); }, &motion);
    const auto finding = motion.Misread();
    ASSERT_TRUE(finding) << text;
    EXPECT_EQ(finding->fault, SensorFault::kDepthMirrored);
    EXPECT_NE(finding->text.find(text), std::string::npos) << finding->text;
  }
}

TEST(DepthMotion, NamesInverseDepthAtAnyScale) {
  const MeasurementModel model(kSensor, {});
  for (const double at_one_metre : {0.2, 1.0, 4.0}) {
    DepthMotion motion(model);
    AddPairs(
        kMotion, [=](cv::Mat& depth) { depth = at_one_metre / depth; }, &motion);
    const auto finding = motion.Misread();
    ASSERT_TRUE(finding) << at_one_metre;
    EXPECT_EQ(finding->fault, SensorFault::kDepthInverse) << finding->text;
  }
}

// A camera at rest in front of something large that moves.
TEST(DepthMotion, FindsNothingWhereHalfOfTheImageMoves) {
  const MeasurementModel model(kSensor, {});
  DepthMotion motion(model);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Pair moving = See(kMotion, seed);
    const Pair still = See(Pose(), seed);
    for (std::size_t i = 0; i < moving.second.points.size() / 2; ++i) {
      moving.second.points[i] = still.second.points[i];
    }
    motion.Add(moving.first, moving.second, moving.matches);
  }
  EXPECT_FALSE(motion.Misread());
}

TEST(DepthMotion, FindsNothingInARotation) {
  const MeasurementModel model(kSensor, {});
  DepthMotion motion(model);
  AddPairs(
      Pose(so3::Exp({0.05, -0.08, 0.1}), Eigen::Vector3d::Zero()),
      [](cv::Mat& depth) { cv::flip(depth, depth, 1); }, &motion);
  EXPECT_FALSE(motion.Misread());
}

TEST(DepthMotion, FindsNothingInFewMatches) {
  const MeasurementModel model(kSensor, {});
  DepthMotion motion(model);
  Pair pair = See(kMotion, 1);
  cv::flip(pair.first.depth_grid, pair.first.depth_grid, 1);
  motion.Add(pair.first, pair.second, pair.matches);
  EXPECT_FALSE(motion.Misread());
}

}  // namespace
}  // namespace highwall::depth_motion_test
