#include <memory>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "box_world.h"
#include "tracking/dynamic_objects.h"

namespace highwall::dynamic_objects_test {
namespace {

using testing::AddNoise;
using testing::Box;
using testing::BoxWorld;
using testing::DepthOf;

constexpr int kReferences = 8;
constexpr Stamp kStep = 500'000'000;  // [ns] from reference to reference

PinholeCamera Camera() {
  return {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
}

const Box kPole{{0.6, -1.0, 1.5}, {0.64, 1.0, 1.54}};  // stands
const Box kChest{{-1.3, 0.4, 2.0}, {-0.7, 1.0, 2.5}};  // stands
const Box kPerson{{-0.25, -0.6, 2.2}, {0.25, 1.0, 2.5}};

class FindDynamicTest : public ::testing::Test {
 protected:
  // Returns the room at instant i = 0 .. kReferences, the last one being that of the view.
  PosedDepth See(int i, const Eigen::Vector3d& velocity, const Pose& T_WC) {
    BoxWorld world;
    world.boxes = {kPole, kChest, kPerson.MovedBy(0.5 * (i - kReferences) * velocity)};
    cv::Mat depth = DepthOf(world, Camera(), T_WC);
    AddNoise(noise, rng, depth);
    return {i * kStep, grid.Sample(depth, 0.3, 8.0), T_WC};
  }
  // velocity: of the person [m/s]; step: of the camera between two instants.
  cv::Mat Find(const Eigen::Vector3d& velocity, const Pose& step = Pose()) {
    std::vector<PosedDepth> references;
    Pose T_WC;
    for (int i = 0; i < kReferences; ++i) {
      references.push_back(See(i, velocity, T_WC));
      T_WC = T_WC * step;
    }
    last = T_WC;
    return FindDynamic(See(kReferences, velocity, T_WC), references, grid, noise, {});
  }
  // Returns the cells that show the person at its last position.
  cv::Mat PersonCells() const {
    BoxWorld with, without;
    with.boxes = {kPerson};
    const cv::Mat a = grid.Sample(DepthOf(with, Camera(), last), 0.3, 8.0);
    const cv::Mat b = grid.Sample(DepthOf(without, Camera(), last), 0.3, 8.0);
    return a < b - 0.01;
  }
  // Returns the share of the person, or of everything else, that a mask covers.
  double Covered(const cv::Mat& mask, bool person) const {
    const cv::Mat cells = person ? PersonCells() : cv::Mat(~PersonCells());
    return static_cast<double>(cv::countNonZero(mask & cells)) / cv::countNonZero(cells);
  }

  const DepthGrid grid{Camera()};
  const DepthNoise noise{};
  std::mt19937 rng{5};
  Pose last;
};

TEST(PosedDepth, HoldsWhatIsNearestAndFarthestAroundACellButAtTheBorder) {
  cv::Mat depth(4, 5, CV_32FC1, cv::Scalar(2.0));
  depth.at<float>(1, 1) = 1.5F;
  depth.at<float>(2, 3) = 2.5F;
  const PosedDepth posed(0, depth, Pose());
  const cv::Mat nearest = (cv::Mat_<float>(4, 5) << 0, 0, 0, 0, 0,  //
                           0, 1.5, 1.5, 2, 0,                       //
                           0, 1.5, 1.5, 2, 0,                       //
                           0, 0, 0, 0, 0);
  const cv::Mat farthest = (cv::Mat_<float>(4, 5) << 0, 0, 0, 0, 0,  //
                            0, 2, 2.5, 2.5, 0,                       //
                            0, 2, 2.5, 2.5, 0,                       //
                            0, 0, 0, 0, 0);
  EXPECT_EQ(cv::norm(posed.nearest, nearest, cv::NORM_INF), 0.0) << posed.nearest;
  EXPECT_EQ(cv::norm(posed.farthest, farthest, cv::NORM_INF), 0.0) << posed.farthest;
}

TEST_F(FindDynamicTest, NothingMovesInAStillRoomWithNoise) {
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(Find(Eigen::Vector3d::Zero()).empty()) << i;
}

TEST_F(FindDynamicTest, FindsNothingWhereOnlyTheCameraMoves) {
  for (const Pose& step :
       {Pose::FromTangent({0.1, 0, 0}, {0, 0, 0}), Pose::FromTangent({0, 0, 0.15}, {0, 0, 0}),
        Pose::FromTangent({-0.05, 0.02, 0}, {0.01, 0.08, 0.02})}) {
    EXPECT_TRUE(Find(Eigen::Vector3d::Zero(), step).empty());
  }
}

TEST_F(FindDynamicTest, NothingMovesWhereThePoseIsALittleWrong) {
  // The error is a third of a cell at the edges of pole, chest and person.
  std::vector<PosedDepth> references;
  for (int i = 0; i < kReferences; ++i) references.push_back(See(i, {0, 0, 0}, Pose()));
  PosedDepth view = See(kReferences, {0, 0, 0}, Pose());
  view.T_WC = Pose::FromTangent({0.01, 0.0, 0.01}, {0.0, 0.005, 0.0});
  EXPECT_TRUE(FindDynamic(view, references, grid, noise, {}).empty());
}

TEST_F(FindDynamicTest, APersonWhoCrossesIsMasked) {
  const cv::Mat mask = Find({0.6, 0, 0});
  ASSERT_FALSE(mask.empty());
  EXPECT_GT(Covered(mask, true), 0.9);
  EXPECT_LT(Covered(mask, false), 0.05);  // the border is one cell wide
}

TEST_F(FindDynamicTest, APersonWhoCrossesBeforeAMovingCameraIsMasked) {
  const cv::Mat mask = Find({0.6, 0, 0}, Pose::FromTangent({0, 0, 0.05}, {0, 0.01, 0}));
  ASSERT_FALSE(mask.empty());
  EXPECT_GT(Covered(mask, true), 0.9);
  EXPECT_LT(Covered(mask, false), 0.08);
}

TEST_F(FindDynamicTest, APersonWhoComesNearerIsMasked) {
  const cv::Mat mask = Find({0, 0, -0.3});
  ASSERT_FALSE(mask.empty());
  EXPECT_GT(Covered(mask, true), 0.9);
}

TEST_F(FindDynamicTest, APersonWhoWalksAheadOfTheCameraIsMasked) {
  // The person is hidden behind its former position, which the view sees through.
  const cv::Mat mask = Find({0, 0, 0.3}, Pose::FromTangent({0, 0, 0.15}, {0, 0, 0}));
  ASSERT_FALSE(mask.empty());
  EXPECT_GT(Covered(mask, true), 0.8);
}

TEST_F(FindDynamicTest, MasksAnObjectThatLaterImagesShowToHaveLeft) {
  std::vector<PosedDepth> later;
  for (int i = 1; i <= kReferences; ++i) {
    later.push_back(See(kReferences + i, {0.6, 0, 0}, Pose()));
  }
  const cv::Mat mask = FindDynamic(See(kReferences, {0.6, 0, 0}, Pose()), later, grid, noise, {});
  ASSERT_FALSE(mask.empty());
  EXPECT_GT(Covered(mask, true), 0.9);
}

TEST_F(FindDynamicTest, AnObjectThatMovedAMomentAgoIsStillDynamic) {
  // The person is too slow to leave its own place between the references, but was marked as moving.
  std::vector<PosedDepth> references;
  for (int i = 0; i < 3; ++i) {
    references.push_back(See(kReferences, {0, 0, 0}, Pose()));
    references.back().stamp = (kReferences - 3 + i) * kStep;
    references.back().moving = PersonCells();  // 255 each
  }
  const PosedDepth view = See(kReferences, {0, 0, 0}, Pose());
  const cv::Mat mask = FindDynamic(view, references, grid, noise, {.settled = 1.6});
  ASSERT_FALSE(mask.empty());
  EXPECT_GT(Covered(mask, true), 0.9);
  // This ends when it has been in place for long enough.
  EXPECT_TRUE(FindDynamic(view, references, grid, noise, {.settled = 0.4}).empty());
}

TEST_F(FindDynamicTest, AnObjectThatHasComeToRestIsStatic) {
  std::vector<PosedDepth> references;
  for (int i = 0; i < kReferences; ++i) {
    const bool walks = i < 3;
    references.push_back(See(walks ? i : kReferences, {0.6, 0, 0}, Pose()));
    references.back().stamp = i * kStep;
  }
  EXPECT_TRUE(
      FindDynamic(See(kReferences, {0.6, 0, 0}, Pose()), references, grid, noise, {}).empty());
}

TEST_F(FindDynamicTest, AWrongPoseIsNotTakenForAMovingWorld) {
  std::vector<PosedDepth> references;
  for (int i = 0; i < kReferences; ++i) references.push_back(See(i, {0, 0, 0}, Pose()));
  PosedDepth view = See(kReferences, {0, 0, 0}, Pose());
  view.T_WC = Pose::FromTangent({0, -0.25, -0.5}, {0, 0, 0});  // everything is nearer than it was
  EXPECT_TRUE(FindDynamic(view, references, grid, noise, {}).empty());
  EXPECT_FALSE(FindDynamic(view, references, grid, noise, {}, {}, 1.0).empty());
}

TEST_F(FindDynamicTest, NothingIsKnownWithoutReferencesOrDepth) {
  EXPECT_TRUE(FindDynamic(See(0, {0, 0, 0}, Pose()), {}, grid, noise, {}).empty());
  const PosedDepth dark(0, cv::Mat::zeros(60, 80, CV_32FC1), Pose());
  const std::vector<PosedDepth> references(3, See(0, {0, 0, 0}, Pose()));
  EXPECT_TRUE(FindDynamic(dark, references, grid, noise, {}).empty());
  const std::vector<PosedDepth> none(3, dark);
  EXPECT_TRUE(FindDynamic(See(0, {0, 0, 0}, Pose()), none, grid, noise, {}).empty());
}

TEST_F(FindDynamicTest, DoesNotMarkUncoveredBackgroundAsDynamic) {
  // A person stood in front of the wall in all references and has left. The wall behind could be a
  // person who walks away as well, but must not be marked as moving because it did so before.
  std::vector<PosedDepth> references;
  for (int i = 0; i < kReferences; ++i) references.push_back(See(i, {0, 0, 0}, Pose()));
  BoxWorld empty;
  empty.boxes = {kPole, kChest};
  const cv::Mat depth = grid.Sample(DepthOf(empty, Camera(), Pose()), 0.3, 8.0);
  const cv::Mat mask =
      FindDynamic({kReferences * kStep, depth, Pose()}, references, grid, noise, {});
  ASSERT_FALSE(mask.empty());
  EXPECT_EQ(cv::countNonZero(mask == 255), 0);
}

// A panel hangs in front of the wall; no reference is old enough to show that it is static.
class FindDynamicSurfaces : public FindDynamicTest {
 protected:
  FindDynamicSurfaces() : view(SeePanel(0.0, 3 * kStep)) {
    for (int i = 0; i < 3; ++i) references.push_back(SeePanel(0.0, i * kStep));
    const PosedDepth wall(0, grid.Sample(DepthOf({}, Camera(), Pose()), 0.3, 8.0), Pose());
    panel = view.depth < wall.depth - 0.1;
  }
  PosedDepth SeePanel(double x, Stamp stamp) const {
    BoxWorld world;
    world.boxes = {Box{{-0.3, -0.5, 1.5}, {0.3, 0.3, 1.6}}.MovedBy({x, 0, 0})};
    return {stamp, grid.Sample(DepthOf(world, Camera(), Pose()), 0.3, 8.0), Pose()};
  }
  cv::Mat Find(const SurfaceHistory& history,
               const DynamicObjectParameters& parameters = {.settled = 2.0}) {
    return FindDynamic(view, references, grid, noise, parameters, history);
  }
  // Returns a test that accepts the surface with the middle of the panel, and no other.
  SurfaceTest PanelMoved() {
    return [this](const DepthSurfaces& surfaces, int surface, const cv::Mat&) {
      ++asked;
      return surfaces.labels.at<int>(25, 40) == surface;
    };
  }

  std::vector<PosedDepth> references;
  PosedDepth view;
  cv::Mat panel;
  int asked = 0;
};

TEST_F(FindDynamicSurfaces, MoveWhereTheirLandmarksDo) {
  EXPECT_TRUE(Find({}).empty());
  const cv::Mat mask = Find({.moved = PanelMoved()});
  ASSERT_FALSE(mask.empty());
  EXPECT_EQ(cv::countNonZero((mask == 254) != panel), 0) << "the panel and nothing else";
  EXPECT_GE(asked, 1);
  EXPECT_TRUE(Find({.moved = PanelMoved()}, {.settled = 2.0, .min_surface = 2000}).empty());
  EXPECT_TRUE(Find({.moved = PanelMoved()}, {.settled = 2.0, .max_surface = 0.05}).empty());
}

TEST_F(FindDynamicSurfaces, StandWhereTheyHaveBeenForLong) {
  EXPECT_TRUE(Find({.moved = PanelMoved()}, {.settled = 1.0}).empty());
}

TEST_F(FindDynamicSurfaces, MoveOnAfterTheFrameBefore) {
  const PosedDepth before = SeePanel(-0.05, 0);
  SurfaceHistory history{.depth = before.depth, .moving = (before.depth < 2.0) - 1};  // 254
  EXPECT_EQ(cv::countNonZero((Find(history) == 254) != panel), 0);
  EXPECT_TRUE(Find(history, {.settled = 1.0}).empty()) << "until it has been in place for long";
  history.moving = before.depth < 2.0;  // by references alone, which mark it again
  EXPECT_TRUE(Find(history).empty());
  history.moving = (SeePanel(-0.45, 0).depth < 2.0) - 1;  // of something else next to it
  EXPECT_TRUE(Find(history).empty());
  history.moving = (before.depth < 2.0) - 1;
  history.depth = history.depth * 0.8;  // of something in front of it
  EXPECT_TRUE(Find(history).empty());
}

class DynamicObjectsTest : public ::testing::Test {
 protected:
  DynamicObjectsTest() {
    Frame frame;
    frame.features = std::make_shared<const FrameFeatures>();
    keyframe = map.AddKeyFrame(frame, Pose()).id;
  }

  cv::Mat See(double x, const Pose& T_WC = Pose()) const {
    BoxWorld world;
    world.boxes = {kPerson.MovedBy({x, 0, 0})};
    return moving.grid().Sample(DepthOf(world, Camera(), T_WC), 0.3, 8.0);
  }

  Map map;
  KeyFrameId keyframe = kNoId;
  DynamicObjects moving{Camera(), DepthNoise(), {}};
};

TEST_F(DynamicObjectsTest, FindsObjectsThatMovedInTheLastSeconds) {
  for (int i = 0; i < 16; ++i) {
    moving.Remember(i * Stamp{250'000'000}, See(0.125 * i - 1.2), Pose(), {}, keyframe, map);
  }
  EXPECT_FALSE(moving.Find(4'000'000'000, See(0.8), Pose(), map, kFirstSubmap).empty());
  EXPECT_TRUE(moving.Find(4'000'000'000, cv::Mat(), Pose(), map, kFirstSubmap).empty())
      << "of a loaded map";
}

TEST_F(DynamicObjectsTest, DropsOldReferences) {
  moving.Remember(0, See(0.0), Pose(), {}, keyframe, map);
  moving.Remember(600'000'000, See(0.0), Pose(), {}, keyframe, map);
  EXPECT_FALSE(moving.Find(700'000'000, See(0.8), Pose(), map, kFirstSubmap).empty());
  moving.Remember(20'000'000'000, See(0.8), Pose(), {}, keyframe, map);
  EXPECT_TRUE(moving.Find(20'100'000'000, See(0.8), Pose(), map, kFirstSubmap).empty());
}

TEST_F(DynamicObjectsTest, FollowsTheKeyframesOfTheMap) {
  for (const Stamp stamp : {0L, 600'000'000L, 1'200'000'000L}) {
    moving.Remember(stamp, See(0.0), Pose(), {}, keyframe, map);
  }
  const Pose T_new_old = Pose::FromTangent({5.0, 2.0, -1.0}, {0.1, 0.2, 0.3});
  map.Transform(T_new_old);
  EXPECT_TRUE(moving.Find(1'300'000'000, See(0.0), T_new_old, map, kFirstSubmap).empty());
  EXPECT_FALSE(moving.Find(1'300'000'000, See(0.8), T_new_old, map, kFirstSubmap).empty());
}

TEST_F(DynamicObjectsTest, IgnoresReferencesOfAnotherWorld) {
  for (const Stamp stamp : {0L, 600'000'000L}) {
    moving.Remember(stamp, See(0.0), Pose(), {}, keyframe, map);
  }
  const SubmapId other = map.AddSubmap();
  ASSERT_FALSE(moving.Find(1'300'000'000, See(0.8), Pose(), map, kFirstSubmap).empty());
  EXPECT_TRUE(moving.Find(1'300'000'000, See(0.8), Pose(), map, other).empty());
  map.Join(kFirstSubmap, other);
  EXPECT_FALSE(moving.Find(1'300'000'000, See(0.8), Pose(), map, other).empty());
  map.RemoveSubmap(other);
  EXPECT_TRUE(moving.Find(1'300'000'000, See(0.8), Pose(), map, kFirstSubmap).empty())
      << "it is no more";
}

TEST_F(DynamicObjectsTest, FollowsObjectsThatMovedInTheFrameBefore) {
  // kPerson stands on the floor, and both form one surface with the wall; this box hangs.
  BoxWorld world;
  world.boxes = {Box{{-0.3, -0.5, 1.5}, {0.3, 0.3, 1.6}}};
  const cv::Mat depth = moving.grid().Sample(DepthOf(world, Camera(), Pose()), 0.3, 8.0);
  const cv::Mat surface = (depth < 2.0) - 1;  // 254
  moving.Remember(100'000'000, depth, Pose(), surface, keyframe, map);
  const cv::Mat mask = moving.Find(200'000'000, depth, Pose(), map, kFirstSubmap);
  ASSERT_FALSE(mask.empty());
  EXPECT_EQ(cv::countNonZero((mask == 254) != (depth < 2.0)), 0);
  EXPECT_TRUE(moving.Find(700'000'000, depth, Pose(), map, kFirstSubmap).empty()) << "too long ago";
  EXPECT_TRUE(moving.Find(50'000'000, depth, Pose(), map, kFirstSubmap).empty())
      << "from the later images";
}

TEST_F(DynamicObjectsTest, FindsNothingWhenTurnedOff) {
  DynamicObjects off(Camera(), DepthNoise(), {.enabled = false});
  for (const Stamp stamp : {0L, 600'000'000L})
    off.Remember(stamp, See(0.0), Pose(), {}, keyframe, map);
  EXPECT_TRUE(off.Find(700'000'000, See(0.8), Pose(), map, kFirstSubmap).empty());
}

}  // namespace
}  // namespace highwall::dynamic_objects_test
