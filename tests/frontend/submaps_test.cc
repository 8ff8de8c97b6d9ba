#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/map/map.h>

namespace highwall {
namespace {

using Ids = std::vector<KeyFrameId>;

Pose At(double x) {
  return Pose(Eigen::Quaterniond::Identity(), {x, 0, 0});
}

Frame FrameOfOnePoint() {
  Frame frame;
  auto features = std::make_shared<FrameFeatures>();
  features->points.resize(1);
  features->point_descriptors = cv::Mat::zeros(1, 32, CV_8U);
  frame.features = features;
  return frame;
}

// Two submaps of two keyframes, each pair with a point of its own, and a third submap of one.
class SubmapsTest : public ::testing::Test {
 protected:
  SubmapsTest() {
    for (const double x : {0.0, 1.0}) Add(x, 0);
    second = map.AddSubmap();
    for (const double x : {10.0, 11.0}) Add(x, second);
    third = map.AddSubmap();
    Add(20.0, third);
  }
  void Add(double x, SubmapId submap) {
    const KeyFrameId id = map.AddKeyFrame(FrameOfOnePoint(), At(x), submap).id;
    const PointId point = map.AddPoint({x, 0, 2}, 0).id;
    points.push_back(point);
    map.ObservePoint(id, 0, point);
  }
  double X(KeyFrameId id) const { return map.ResolvePose(id).p().x(); }

  Map map;
  std::vector<PointId> points;
  SubmapId second = kNoId, third = kNoId;
};

TEST_F(SubmapsTest, AreWorldsOfTheirOwnUntilTheyAreJoined) {
  EXPECT_EQ(map.roots(), (std::vector<SubmapId>{0, second, third}));
  EXPECT_EQ(map.KeyFramesOf(second), (Ids{2, 3}));
  EXPECT_EQ(map.RootOf(3), second);
  map.Join(third, second);
  EXPECT_EQ(map.roots(), (std::vector<SubmapId>{0, second})) << "named by the older";
  EXPECT_EQ(map.Root(third), second);
  EXPECT_EQ(map.KeyFramesOf(third), (Ids{2, 3, 4}));
  EXPECT_EQ(map.NumKeyFramesOf(second), 3U);
  map.Join(0, third);
  EXPECT_EQ(map.roots(), std::vector<SubmapId>{0}) << "with all that was joined before";
  EXPECT_EQ(map.NumKeyFramesOf(third), 5U);
}

TEST_F(SubmapsTest, OneIsMovedWithoutTheOthers) {
  map.Join(second, third);
  map.Transform(At(100.0), second);
  EXPECT_DOUBLE_EQ(X(0), 0.0);
  EXPECT_DOUBLE_EQ(X(2), 110.0);
  EXPECT_DOUBLE_EQ(X(4), 120.0) << "joined with it";
  EXPECT_DOUBLE_EQ(map.point(points[1])->p_W.x(), 1.0);
  EXPECT_DOUBLE_EQ(map.point(points[3])->p_W.x(), 111.0);
}

TEST_F(SubmapsTest, EachHasAnOriginUntilItIsJoined) {
  const auto origins = [&] {
    Ids ids;
    for (const KeyFrameId id : map.keyframe_ids()) {
      if (map.IsOrigin(id)) ids.push_back(id);
    }
    return ids;
  };
  EXPECT_EQ(origins(), (Ids{0, 2, 4}));
  map.Join(0, second);
  EXPECT_EQ(origins(), (Ids{0, 4}));
}

TEST_F(SubmapsTest, ARemovedKeyFrameStaysInItsWorld) {
  map.RemoveKeyFrame(3, 2);
  EXPECT_EQ(map.RootOf(3), second);
  EXPECT_DOUBLE_EQ(X(3), 11.0);
  map.Join(0, second);
  EXPECT_EQ(map.RootOf(3), 0);
}

TEST_F(SubmapsTest, OneThatIsRemovedTakesEverythingAlong) {
  map.RemoveKeyFrame(3, 2);
  map.Join(second, third);
  map.RemoveSubmap(third);
  EXPECT_EQ(map.roots(), std::vector<SubmapId>{0});
  EXPECT_EQ(map.keyframe_ids(), (Ids{0, 1}));
  EXPECT_EQ(map.num_points(), 2U);
  EXPECT_EQ(map.index().size(), 2U);
  EXPECT_FALSE(map.RootOf(2));
  EXPECT_FALSE(map.RootOf(3)) << "hung on one that is no more";
  EXPECT_THROW(map.ResolvePose(3), InvalidArgument);
  EXPECT_EQ(map.AddSubmap(), third + 1) << "ids are never used again";
}

TEST_F(SubmapsTest, GravityIsThatOfTheRootOrOfWhoeverKnowsIt) {
  const Eigen::Vector3d down(0, 0, -9.8), other(0.1, 0, -9.8);
  map.SetGravity(down, second);
  EXPECT_FALSE(map.gravity_W());
  map.Join(0, second);
  EXPECT_EQ(map.gravity_W(), down);
  map.SetGravity(other, third);
  map.Join(0, third);
  EXPECT_EQ(map.gravity_W(third), down);
}

TEST_F(SubmapsTest, RefusesOnesThatAreNot) {
  EXPECT_THROW(map.Root(third + 1), InvalidArgument);
  EXPECT_THROW(map.KeyFramesOf(-1), InvalidArgument);
  EXPECT_THROW(map.AddKeyFrame(FrameOfOnePoint(), Pose(), third + 1), InvalidArgument);
}

}  // namespace
}  // namespace highwall
