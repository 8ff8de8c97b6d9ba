#include "tracking/lost_frames.h"

#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/trajectory.h>

#include "tracker_fixture.h"

namespace highwall::lost_frames_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeFrame;
using testing::PoseOfFrame;
using testing::PositionError;
using testing::SyntheticView;
using testing::TrackerTest;

// Lines have float pixels, which move a pose by some micrometres.
constexpr double kExact = 2e-5;
constexpr double kReadout = 0.025;  // [s]

// Frames of a path in a mapped scene; those that are not lost have their true poses.
class LostFramesTest : public TrackerTest {
 protected:
  LostFramesTest() : keyframe_(scene_map.map.keyframe_ids().front()) {}

  static Stamp StampOf(int i, double rate = 30.0) { return static_cast<Stamp>(i * 1e9 / rate); }
  LostFrame Lost(const SyntheticView& view, Stamp stamp) const {
    Frame frame = MakeFrame(view, 0);
    frame.stamp = stamp;
    return {.frame = frame, .stamp = stamp, .usual_match_ratio = 1.0};
  }
  SyntheticView View(const Pose& T_WC) const { return Look(scene, IdealSensor(), T_WC); }
  LostFrames Make(std::size_t most = 10) const {
    return LostFrames(model, IdealSensor().camera, TrackerOptions(), most);
  }
  double Error(const PosedFrame& found, const Pose& truth) const {
    return PositionError(found.pose.T_WC(scene_map.map), truth);
  }
  PosedFrame Posed(Stamp stamp, const Pose& T_WC) const {
    PosedFrame posed;
    posed.stamp = stamp;
    posed.pose = AnchoredPose::At(scene_map.map, keyframe_, T_WC);
    return posed;
  }
  // A pose that its image does not state.
  PosedFrame Predicted(Stamp stamp, const Pose& T_WC) const {
    PosedFrame posed = Posed(stamp, T_WC);
    posed.information = ImageInformation::Zero();
    return posed;
  }
  // frames: those with a pose that their images state.
  std::vector<PosedFrame> Find(LostFrames& lost, const Trajectory& frames,
                               const ImageKnowledge& knowledge = {}) const {
    std::vector<PosedFrame> posed;
    for (const auto& [stamp, T_WC] : frames) posed.push_back(Posed(stamp, T_WC));
    return lost.Find(scene_map.map, knowledge, posed, 1.0);
  }

  const KeyFrameId keyframe_;
};

TEST_F(LostFramesTest, FoundFramesGetTheNoiseThatIsKnownByThen) {
  double information[2] = {};
  for (const bool known : {false, true}) {
    LostFrames lost = Make();
    lost.Add(Lost(View(PoseOfFrame(10)), StampOf(10)));
    ImageKnowledge knowledge;
    if (known) knowledge.noise = testing::TwiceTheNoise();
    const auto found =
        Find(lost, {{StampOf(9), PoseOfFrame(9)}, {StampOf(11), PoseOfFrame(11)}}, knowledge);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_LT(Error(found.front(), PoseOfFrame(10)), kExact);
    information[known ? 1 : 0] = found.front().information->trace();
  }
  EXPECT_NEAR(information[1] / information[0], 0.25, 0.01) << "up to a few more inliers";
}

TEST_F(LostFramesTest, FindsABlurredFrameAtThePoseBetweenItsNeighbours) {
  // Blur changes the descriptors by more than recognition of a place accepts, and less than
  // tracking does.
  SyntheticView view = View(PoseOfFrame(10));
  auto features = std::make_shared<FrameFeatures>(*view.features);
  features->point_descriptors = features->point_descriptors.clone();
  features->line_descriptors.release();
  const MaxHammingOptions& limits = model.options().max_hamming;
  ASSERT_LT(limits.relocalization + 8, limits.projection);
  for (int row = 0; row < features->point_descriptors.rows; ++row) {
    for (int bit = 0; bit < limits.relocalization + 8; ++bit) {
      features->point_descriptors.at<std::uint8_t>(row, bit / 8) ^=
          static_cast<std::uint8_t>(1 << bit % 8);
    }
  }
  view.features = features;
  const StampedPose before{StampOf(9), PoseOfFrame(9)};
  const StampedPose after{StampOf(11), PoseOfFrame(11)};
  LostFrames lost = Make();
  lost.Add(Lost(view, StampOf(10)));
  EXPECT_TRUE(Find(lost, {before}).empty());
  lost.Add(Lost(view, StampOf(10)));
  const auto found = Find(lost, {before, after});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT(Error(found[0], PoseOfFrame(10)), kExact);
}

TEST_F(LostFramesTest, FindsFramesByTheFramesAfterThemAlone) {
  // One image a second: nothing can be interpolated.
  LostFrames lost = Make();
  for (int i = 0; i < 3; ++i) lost.Add(Lost(View(PoseOfFrame(10 * i)), StampOf(i, 1.0)));
  const auto found = Find(lost, {{StampOf(3, 1.0), PoseOfFrame(30)}});
  ASSERT_EQ(found.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(found[static_cast<std::size_t>(i)].stamp, StampOf(i, 1.0));
    EXPECT_LT(Error(found[static_cast<std::size_t>(i)], PoseOfFrame(10 * i)), kExact);
    EXPECT_TRUE(found[static_cast<std::size_t>(i)].information);
  }
  EXPECT_TRUE(Find(lost, {}).empty()) << "they are forgotten";
}

TEST_F(LostFramesTest, DoesNotFindAFrameOfAnotherScene) {
  LostFrames lost = Make();
  lost.Add(Lost(Look(foreign, IdealSensor(), PoseOfFrame(10)), StampOf(10)));
  EXPECT_TRUE(Find(lost, {{StampOf(9), PoseOfFrame(9)}, {StampOf(11), PoseOfFrame(11)}}).empty());
}

TEST_F(LostFramesTest, RejectsAPoseThatTheCameraCannotHaveReached) {
  // The frame before was ten metres away a thirtieth of a second earlier.
  const Pose far = Pose::FromTangent({10, 0, 0}, {0, 0, 0});
  LostFrames lost = Make();
  lost.Add(Lost(View(PoseOfFrame(10)), StampOf(10)));
  EXPECT_TRUE(Find(lost, {{StampOf(9), far}}).empty());
  // Ten seconds earlier it can have been there.
  lost.Add(Lost(View(PoseOfFrame(10)), StampOf(400)));
  EXPECT_EQ(Find(lost, {{StampOf(100), far}}).size(), 1u);
}

TEST_F(LostFramesTest, KeepsTheNewestFramesUpToItsLimit) {
  LostFrames lost = Make(2);
  for (int i = 0; i < 4; ++i) lost.Add(Lost(View(PoseOfFrame(i)), StampOf(i)));
  EXPECT_GT(lost.MemoryBytes(), 0u);
  const auto found = Find(lost, {{StampOf(4), PoseOfFrame(4)}});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].stamp, StampOf(2));
  EXPECT_EQ(lost.MemoryBytes(), 0u);
}

TEST_F(LostFramesTest, CompensatesRowsByTheMotionOfItsNeighbours) {
  const Twist motion =
      Twist::Between(PoseOfFrame(9).Inverse() * PoseOfFrame(11), ToSeconds(StampOf(2)));
  SyntheticView view = View(PoseOfFrame(10));
  view.features = CompensatedToMiddleRow(*view.features, IdealSensor().camera, -kReadout, motion);
  const Trajectory frames{{StampOf(9), PoseOfFrame(9)}, {StampOf(11), PoseOfFrame(11)}};
  std::vector<double> errors;
  for (const bool knows_rows : {false, true}) {
    ImageKnowledge knowledge;
    if (knows_rows) knowledge.timing = FrameTiming{.colour_readout = kReadout};
    LostFrames lost = Make();
    lost.Add(Lost(view, StampOf(10)));
    const auto found = Find(lost, frames, knowledge);
    ASSERT_EQ(found.size(), 1u);
    errors.push_back(Error(found[0], PoseOfFrame(10)));
  }
  EXPECT_GT(errors[0], 1e-3);
  EXPECT_LT(errors[1], 0.15 * errors[0]);  // rows move by the first order of the motion
}

TEST_F(LostFramesTest, ALateImageIsFoundAtTheTimeOfItsColourAndPredictedToItsStamp) {
  LostFrame late = Lost(View(PoseOfFrame(10)), StampOf(10));
  late.stamp = StampOf(11);
  LostFrames lost = Make();
  lost.Add(late);
  const auto found = Find(lost, {{StampOf(9), PoseOfFrame(9)}, {StampOf(12), PoseOfFrame(12)}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].stamp, StampOf(11));
  EXPECT_EQ(found[0].measured_at(), StampOf(10));
  EXPECT_LT(PositionError(found[0].measured().T_WC(scene_map.map), PoseOfFrame(10)), kExact);
  // The motion is the mean of three frames, of a path with accelerations of millimetres a frame^2.
  EXPECT_GT(PositionError(PoseOfFrame(10), PoseOfFrame(11)), 0.01);
  EXPECT_LT(Error(found[0], PoseOfFrame(11)), 0.004);
}

TEST_F(LostFramesTest, PredictedPosesOfOtherFramesSayNothing) {
  const Pose far = Pose::FromTangent({10, 0, 0}, {0, 0, 0});
  LostFrames lost = Make();
  lost.Add(Lost(View(PoseOfFrame(10)), StampOf(10)));
  // Of the time of the image itself, as where a late image follows one that repeats another, and
  // beside it.
  const std::vector<PosedFrame> frames{
      Posed(StampOf(8), PoseOfFrame(8)), Predicted(StampOf(9), far), Predicted(StampOf(10), far),
      Predicted(StampOf(11), far), Posed(StampOf(12), PoseOfFrame(12))};
  const auto found = lost.Find(scene_map.map, {}, frames, 1.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT(Error(found[0], PoseOfFrame(10)), kExact);
}

TEST_F(LostFramesTest, AFrameFromBeforeTheUsualMatchRatioWasKnownIsJudgedByThatOfTheEnd) {
  for (const double usual : {1.0, 3.0}) {  // half of the latter is more than any frame has
    LostFrames lost = Make();
    LostFrame first = Lost(View(PoseOfFrame(10)), StampOf(10));
    first.usual_match_ratio = 0.0;
    lost.Add(first);
    EXPECT_EQ(lost.Find(scene_map.map, {}, {}, usual).size(), usual == 1.0 ? 1u : 0u);
  }
}

}  // namespace
}  // namespace highwall::lost_frames_test
