#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/map/keyframe_index.h>
#include <highwall/frontend/map/map.h>

#include "support/id_literals.h"

namespace highwall::submaps_test {
namespace {

using testing::operator""_kf;

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
    for (const double x : {0.0, 1.0}) Add(x, kFirstSubmap);
    second = map.AddSubmap();
    for (const double x : {10.0, 11.0}) Add(x, second);
    third = map.AddSubmap();
    Add(20.0, third);
  }
  void Add(double x, SubmapId submap) {
    const KeyFrameId id = map.AddKeyFrame(FrameOfOnePoint(), At(x), submap).id;
    const PointId point = map.Add<MapPoint>({x, 0, 2}, 0).id;
    points.push_back(point);
    map.Observe(id, 0, point);
  }
  double X(KeyFrameId id) const { return map.ResolvePose(id).p().x(); }

  Map map;
  std::vector<PointId> points;
  SubmapId second, third;
};

TEST_F(SubmapsTest, AreWorldsOfTheirOwnUntilTheyAreJoined) {
  EXPECT_EQ(map.roots(), (std::vector<SubmapId>{kFirstSubmap, second, third}));
  EXPECT_EQ(map.KeyFramesOf(second), (Ids{2_kf, 3_kf}));
  EXPECT_EQ(map.RootOf(3_kf), second);
  map.Join(third, second);
  EXPECT_EQ(map.roots(), (std::vector<SubmapId>{kFirstSubmap, second})) << "named by the older";
  EXPECT_EQ(map.Root(third), second);
  EXPECT_EQ(map.KeyFramesOf(third), (Ids{2_kf, 3_kf, 4_kf}));
  EXPECT_EQ(map.NumKeyFramesOf(second), 3U);
  map.Join(kFirstSubmap, third);
  EXPECT_EQ(map.roots(), std::vector<SubmapId>{kFirstSubmap}) << "with all that was joined before";
  EXPECT_EQ(map.NumKeyFramesOf(third), 5U);
}

TEST_F(SubmapsTest, OneIsMovedWithoutTheOthers) {
  map.Join(second, third);
  map.Transform(At(100.0), second);
  EXPECT_DOUBLE_EQ(X(0_kf), 0.0);
  EXPECT_DOUBLE_EQ(X(2_kf), 110.0);
  EXPECT_DOUBLE_EQ(X(4_kf), 120.0) << "joined with it";
  EXPECT_DOUBLE_EQ(map.Find(points[1])->p_W.x(), 1.0);
  EXPECT_DOUBLE_EQ(map.Find(points[3])->p_W.x(), 111.0);
}

TEST_F(SubmapsTest, EachHasAnOriginUntilItIsJoined) {
  const auto origins = [&] {
    Ids ids;
    for (const KeyFrameId id : map.keyframe_ids()) {
      if (map.IsOrigin(id)) ids.push_back(id);
    }
    return ids;
  };
  EXPECT_EQ(origins(), (Ids{0_kf, 2_kf, 4_kf}));
  map.Join(kFirstSubmap, second);
  EXPECT_EQ(origins(), (Ids{0_kf, 4_kf}));
}

TEST_F(SubmapsTest, ARemovedKeyFrameStaysInItsWorld) {
  map.RemoveKeyFrame(3_kf, 2_kf);
  EXPECT_EQ(map.RootOf(3_kf), second);
  EXPECT_DOUBLE_EQ(X(3_kf), 11.0);
  map.Join(kFirstSubmap, second);
  EXPECT_EQ(map.RootOf(3_kf), kFirstSubmap);
}

TEST_F(SubmapsTest, OneThatIsRemovedTakesEverythingAlong) {
  map.RemoveKeyFrame(3_kf, 2_kf);
  map.Join(second, third);
  map.RemoveSubmap(third);
  EXPECT_EQ(map.roots(), std::vector<SubmapId>{kFirstSubmap});
  EXPECT_EQ(map.keyframe_ids(), (Ids{0_kf, 1_kf}));
  EXPECT_EQ(map.num<MapPoint>(), 2U);
  EXPECT_EQ(map.index().size(), 2U);
  EXPECT_FALSE(map.RootOf(2_kf));
  EXPECT_FALSE(map.RootOf(3_kf)) << "hung on one that is no more";
  EXPECT_THROW(map.ResolvePose(3_kf), InvalidArgument);
  EXPECT_GT(map.AddSubmap(), third) << "ids are never used again";
}

TEST_F(SubmapsTest, GravityIsThatOfTheRootOrOfWhoeverKnowsIt) {
  const Eigen::Vector3d down(0, 0, -9.8), other(0.1, 0, -9.8);
  map.SetGravity(down, second);
  EXPECT_FALSE(map.gravity_W());
  map.Join(kFirstSubmap, second);
  EXPECT_EQ(map.gravity_W(), down);
  map.SetGravity(other, third);
  map.Join(kFirstSubmap, third);
  EXPECT_EQ(map.gravity_W(third), down);
}

TEST_F(SubmapsTest, RefusesOnesThatAreNot) {
  SubmapId none = third;
  ++none;
  EXPECT_THROW(map.Root(none), InvalidArgument);
  EXPECT_THROW(map.KeyFramesOf(kNoId), InvalidArgument);
  EXPECT_THROW(map.AddKeyFrame(FrameOfOnePoint(), Pose(), none), InvalidArgument);
}

}  // namespace
}  // namespace highwall::submaps_test
