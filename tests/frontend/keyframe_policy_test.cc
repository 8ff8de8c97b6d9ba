#include <gtest/gtest.h>

#include "support/id_literals.h"
#include "support/synthetic_scene.h"
#include "tracking/keyframe_policy.h"

namespace highwall::keyframe_policy_test {
namespace {

using testing::operator""_kf;

std::shared_ptr<FrameFeatures> Features(int points_with_depth, int points_without,
                                        int lines_with_depth = 0, int lines_without = 0) {
  auto features = std::make_shared<FrameFeatures>();
  features->points.resize(static_cast<std::size_t>(points_with_depth + points_without));
  for (int i = 0; i < points_with_depth; ++i)
    features->points[static_cast<std::size_t>(i)].depth = 1.0;
  features->lines.resize(static_cast<std::size_t>(lines_with_depth + lines_without));
  for (int i = 0; i < lines_with_depth; ++i) {
    features->lines[static_cast<std::size_t>(i)].segment_C.emplace();
  }
  return features;
}

TEST(KeyFramePolicy, StartsAMapWithEnoughDepth) {
  const KeyFramePolicy policy({.min_features = 50});
  EXPECT_TRUE(policy.CanStart(*Features(50, 0)));
  EXPECT_FALSE(policy.CanStart(*Features(49, 1000)));
  EXPECT_TRUE(policy.CanStart(*Features(42, 0, 2, 0))) << "a line counts for four points";
  EXPECT_FALSE(policy.CanStart(*Features(42, 0, 1, 100)));
  EXPECT_FALSE(policy.CanStart(FrameFeatures()));
}

TEST(KeyFramePolicy, CornersThatMayBeNoiseStartNoMap) {
  const KeyFramePolicy policy({.min_features = 50});
  const auto features = Features(1000, 0);
  for (std::size_t i = 49; i < features->points.size(); ++i)
    features->points[i].low_contrast = true;
  EXPECT_FALSE(policy.CanStart(*features));
  features->points[49].low_contrast = false;
  EXPECT_TRUE(policy.CanStart(*features));
}

// A map whose keyframes 0, 1, 2 all see the same hundred points and ten lines.
class KeyFramePolicyWants : public ::testing::Test {
 protected:
  KeyFramePolicyWants() {
    for (int k = 0; k < 3; ++k) {
      map.AddKeyFrame({.index = k, .stamp = k, .features = Features(100, 0, 10)}, Pose());
    }
    for (int i = 0; i < 100; ++i) {
      const PointId id = map.Add<MapPoint>({0, 0, 1}, 0).id;
      for (int k = 0; k < 3; ++k) map.Observe(KeyFrameId(k), i, id);
    }
    for (int i = 0; i < 10; ++i) {
      const LineId id = map.Add<MapLine>(Segment3(), 0).id;
      for (int k = 0; k < 3; ++k) map.Observe(KeyFrameId(k), i, id);
    }
  }

  // Returns a frame that tracks the first `points` and `lines` of them and sees `more` features
  // with depth that have no landmark yet.
  TrackedFrame Tracked(int points, int lines, int more, double seconds = 0.0) const {
    TrackedFrame tracked;
    tracked.frame = {
        .index = 1, .stamp = FromSeconds(seconds), .features = Features(points + more, 0, lines)};
    tracked.state = TrackingState::kTracking;
    tracked.reference = 2_kf;
    tracked.points.assign(static_cast<std::size_t>(points + more), kNoId);
    for (int i = 0; i < points; ++i) tracked.points[static_cast<std::size_t>(i)] = PointId(i);
    tracked.lines.assign(static_cast<std::size_t>(lines), kNoId);
    for (int i = 0; i < lines; ++i) tracked.lines[static_cast<std::size_t>(i)] = LineId(i);
    tracked.num_points = points;
    tracked.num_lines = lines;
    return tracked;
  }

  Map map;
};

TEST_F(KeyFramePolicyWants, WhenTooLittleOfTheReferenceIsSeen) {
  const KeyFramePolicy policy({.min_share = 0.5, .max_gap = 100.0, .wanted_tracked = 0});
  EXPECT_FALSE(policy.Wants(Tracked(50, 5, 0), map, 0)) << "55 of 110";
  EXPECT_TRUE(policy.Wants(Tracked(50, 4, 0), map, 0)) << "54 of 110";
}

TEST_F(KeyFramePolicyWants, WhenTheLastOneIsLongAgo) {
  const KeyFramePolicy policy({.min_share = 0.1, .max_gap = 1.0, .wanted_tracked = 0});
  EXPECT_FALSE(policy.Wants(Tracked(100, 10, 0, 1.29), map, FromSeconds(0.3), true));
  EXPECT_TRUE(policy.Wants(Tracked(100, 10, 0, 1.31), map, FromSeconds(0.3), true));
}

TEST_F(KeyFramePolicyWants, NoneWhereTheCameraStandsUnlessAnImuConstrainsThem) {
  const KeyFramePolicy policy({.min_share = 0.1, .max_gap = 1.0, .wanted_tracked = 0});
  const auto frame = [&](double shift, int points = 100) {
    TrackedFrame tracked = Tracked(points, 10, 0, 60.0);
    auto features = std::make_shared<FrameFeatures>(*tracked.frame.features);
    // Half of the shifts have the opposite sign: a rotation about the optical axis has no mean
    // shift.
    for (std::size_t i = 0; i < features->points.size(); ++i) {
      features->points[i].uv = {i % 2 == 0 ? shift : -shift, 0.0};
    }
    tracked.frame.features = features;
    return tracked;
  };
  EXPECT_FALSE(policy.Wants(frame(1.9), map, 0));
  EXPECT_TRUE(policy.Wants(frame(1.9), map, 0, true)) << "with an IMU";
  EXPECT_TRUE(policy.Wants(frame(2.1), map, 0));
  EXPECT_TRUE(policy.Wants(frame(0.0, 19), map, 0)) << "too few points to say that it stands";
}

TEST_F(KeyFramePolicyWants, NotOfAFrameThatSeesNoLandmarkUnlessItMust) {
  const KeyFramePolicy policy({.max_gap = 1.0});
  EXPECT_FALSE(policy.Wants(Tracked(0, 0, 300, 0.9), map, 0));
  EXPECT_TRUE(policy.Wants(Tracked(0, 0, 300, 1.1), map, 0));
}

TEST_F(KeyFramePolicyWants, WhenMuchIsWaitingToBeMapped) {
  const KeyFramePolicy policy(
      {.min_share = 0.1, .max_gap = 100.0, .wanted_tracked = 60, .wanted_new = 20});
  EXPECT_TRUE(policy.Wants(Tracked(59, 10, 21), map, 0));
  EXPECT_FALSE(policy.Wants(Tracked(60, 10, 21), map, 0)) << "enough tracked";
  EXPECT_FALSE(policy.Wants(Tracked(59, 10, 20), map, 0)) << "not enough new";
}

TEST_F(KeyFramePolicyWants, DoesNotCountLandmarksOnProbation) {
  const KeyFramePolicy policy({.min_share = 0.5, .max_gap = 100.0, .wanted_tracked = 0});
  // Keyframe 2 alone keeps sixty points: forty points and ten lines are left.
  for (PointId id(0); id < PointId(60); ++id) {
    map.Forget(0_kf, id);
    map.Forget(1_kf, id);
  }
  EXPECT_FALSE(policy.Wants(Tracked(25, 0, 0), map, 0));
  EXPECT_TRUE(policy.Wants(Tracked(24, 0, 0), map, 0));
  // In a map of two keyframes all landmarks count.
  map.RemoveKeyFrame(0_kf, 1_kf);
  EXPECT_TRUE(policy.Wants(Tracked(54, 0, 0), map, 0));
  EXPECT_FALSE(policy.Wants(Tracked(55, 0, 0), map, 0));
}

}  // namespace
}  // namespace highwall::keyframe_policy_test
