#include <highwall/mapping/depth_filter.h>

#include <gtest/gtest.h>
#include <highwall/core/error.h>

#include "box_room.h"

namespace highwall::depth_filter_test {
namespace {

// A wall at z [m] in front of a static camera.
KeyframeImage Wall(std::int64_t id, float z) {
  const PinholeCamera camera = SmallCamera().pinhole;
  return {id, 0, cv::Mat(camera.height, camera.width, CV_32FC1, cv::Scalar(z)),
          cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar(10, 20, 30)), Pose()};
}

TEST(DepthFilter, AFrameComesOutWhenTheNextHasComeIn) {
  DepthFilter filter(SmallCamera(), 0.01);
  EXPECT_FALSE(filter.Push(Wall(4, 2.0f)));
  EXPECT_EQ(filter.Push(Wall(7, 2.0f))->id, 4);
  EXPECT_EQ(filter.Push(Wall(9, 2.0f))->id, 7);
  EXPECT_EQ(filter.Flush()->id, 9);
  EXPECT_FALSE(filter.Flush());
}

TEST(DepthFilter, DropsPointsThatBothNeighboursSeeThrough) {
  DepthFilter filter(SmallCamera(), 0.01);
  KeyframeImage ghost = Wall(2, 2.0f);
  ghost.depth.at<float>(50, 50) = 1.0f;
  filter.Push(Wall(1, 2.0f));
  filter.Push(ghost);
  const cv::Mat depth = filter.Push(Wall(3, 2.0f))->depth;
  EXPECT_EQ(depth.at<float>(50, 50), 0.0f);
  EXPECT_NEAR(depth.at<float>(100, 50), 2.0f, 1e-5);  // rounding of the inverse depth
}

TEST(DepthFilter, PutsNeighboursWhereTheyAreNow) {
  DepthFilter filter(SmallCamera(), 0.01);
  filter.Push(Wall(1, 2.0f));
  filter.Push(Wall(2, 1.0f));
  // From one metre farther back, the first keyframe sees the wall at the place where the second
  // sees it.
  filter.SetPoses({{1, {Pose(Eigen::Quaterniond::Identity(), {0, 0, -1})}}, {2, {}}});
  const cv::Mat depth = filter.Flush()->depth;
  EXPECT_NEAR(depth.at<float>(60, 80), 1.0f, 1e-5);
}

TEST(DepthFilter, ComparesFramesOfOneLayerAlone) {
  for (const bool joined : {false, true}) {
    DepthFilter filter(SmallCamera(), 0.01);
    filter.Push(Wall(1, 2.0f));
    KeyframeImage elsewhere = Wall(2, 1.0f);
    elsewhere.layer = 5;
    filter.Push(elsewhere);
    if (joined) filter.SetPoses({{1, {Pose(), 5}}, {2, {Pose(), 5}}});
    const KeyframeImage out = *filter.Flush();
    EXPECT_EQ(out.layer, 5);
    // The first frame sees through the wall of the second one if both are in the same world.
    EXPECT_NEAR(out.depth.at<float>(60, 80), joined ? 0.0f : 1.0f, 1e-5);
  }
}

TEST(DepthFilter, ForgetsFramesThatAreNoMore) {
  DepthFilter filter(SmallCamera(), 0.01);
  filter.Push(Wall(1, 2.0f));
  filter.Push(Wall(2, 1.0f));
  filter.SetPoses({{2, {}}, {3, {}}});
  const KeyframeImage out = *filter.Flush();
  EXPECT_EQ(out.id, 2);
  EXPECT_NEAR(out.depth.at<float>(60, 80), 1.0f, 1e-5);
}

TEST(DepthFilter, ForgetsRemovedFrames) {
  DepthFilter filter(SmallCamera(), 0.01);
  filter.Push(Wall(1, 2.0f));
  filter.Remove(1);
  EXPECT_FALSE(filter.Push(Wall(2, 2.0f)));
  filter.Remove(2);
  EXPECT_FALSE(filter.Flush());
}

TEST(DepthFilter, RefusesDepthOfAnotherSizeAndDoesNotStoreIt) {
  DepthFilter filter(SmallCamera(), 0.01);
  const KeyframeImage whole = Wall(1, 2.0f);
  const int width = whole.depth.cols, height = whole.depth.rows;
  for (const cv::Size& size :
       {cv::Size(80, 60), cv::Size(width, height - 1), cv::Size(width - 1, height)}) {
    KeyframeImage small = whole;
    small.depth = small.depth(cv::Rect({0, 0}, size));
    EXPECT_THROW(filter.Push(small), InvalidArgument) << size.width << " x " << size.height;
  }
  EXPECT_FALSE(filter.Push(Wall(2, 2.0f)));
}

TEST(DepthFilter, RefusesACameraWhoseNoiseNobodyKnows) {
  EXPECT_THROW(DepthFilter({SmallCamera().pinhole, nullptr}, 0.01), InvalidArgument);
}

}  // namespace
}  // namespace highwall::depth_filter_test
