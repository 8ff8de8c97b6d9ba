#include <highwall/frontend/tracking/standard_keyframe_policy.h>

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/stamp.h>
#include <highwall/frontend/system/slam_system.h>

#include "support/id_literals.h"
#include "support/moving_wall.h"

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
  StandardKeyFramePolicy policy({.min_features = 50});
  EXPECT_TRUE(policy.CanStart(*Features(50, 0)));
  EXPECT_FALSE(policy.CanStart(*Features(49, 1000)));
  EXPECT_TRUE(policy.CanStart(*Features(42, 0, 2, 0))) << "a line counts for four points";
  EXPECT_FALSE(policy.CanStart(*Features(42, 0, 1, 100)));
  EXPECT_FALSE(policy.CanStart(FrameFeatures()));
}

TEST(KeyFramePolicy, CornersThatMayBeNoiseStartNoMap) {
  StandardKeyFramePolicy policy({.min_features = 50});
  const auto features = Features(1000, 0);
  for (std::size_t i = 49; i < features->points.size(); ++i)
    features->points[i].low_contrast = true;
  EXPECT_FALSE(policy.CanStart(*features));
  features->points[49].low_contrast = false;
  EXPECT_TRUE(policy.CanStart(*features));
}

// What a candidate refers to.
struct Tracked {
  Frame frame;
  std::vector<PointId> points;
  std::vector<LineId> lines;
  int num_points = 0, num_lines = 0;

  KeyFrameCandidate Candidate(Stamp last_keyframe, bool with_imu) const {
    return {.frame = frame,
            .reference = 2_kf,
            .points = points,
            .lines = lines,
            .num_points = num_points,
            .num_lines = num_lines,
            .since_keyframe = ToSeconds(frame.stamp - last_keyframe),
            .with_imu = with_imu};
  }
};

bool Wants(StandardKeyFramePolicy policy, const Tracked& tracked, const Map& map,
           Stamp last_keyframe, bool with_imu = false) {
  return policy.Wants(tracked.Candidate(last_keyframe, with_imu), map);
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
  Tracked Seeing(int points, int lines, int more, double seconds = 0.0) const {
    Tracked tracked;
    tracked.frame = {
        .index = 1, .stamp = FromSeconds(seconds), .features = Features(points + more, 0, lines)};
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
  StandardKeyFramePolicy policy({.min_share = 0.5, .max_gap = 100.0, .wanted_tracked = 0});
  EXPECT_FALSE(Wants(policy, Seeing(50, 5, 0), map, 0)) << "55 of 110";
  EXPECT_TRUE(Wants(policy, Seeing(50, 4, 0), map, 0)) << "54 of 110";
}

TEST_F(KeyFramePolicyWants, WhenTheLastOneIsLongAgo) {
  StandardKeyFramePolicy policy({.min_share = 0.1, .max_gap = 1.0, .wanted_tracked = 0});
  EXPECT_FALSE(Wants(policy, Seeing(100, 10, 0, 1.29), map, FromSeconds(0.3), true));
  EXPECT_TRUE(Wants(policy, Seeing(100, 10, 0, 1.31), map, FromSeconds(0.3), true));
}

TEST_F(KeyFramePolicyWants, NoneWhereTheCameraStandsUnlessAnImuConstrainsThem) {
  StandardKeyFramePolicy policy({.min_share = 0.1, .max_gap = 1.0, .wanted_tracked = 0});
  const auto frame = [&](double shift, int points = 100) {
    Tracked tracked = Seeing(points, 10, 0, 60.0);
    auto features = std::make_shared<FrameFeatures>(*tracked.frame.features);
    // Half of the shifts have the opposite sign: a rotation about the optical axis has no mean
    // shift.
    for (std::size_t i = 0; i < features->points.size(); ++i) {
      features->points[i].uv = {i % 2 == 0 ? shift : -shift, 0.0};
    }
    tracked.frame.features = features;
    return tracked;
  };
  EXPECT_FALSE(Wants(policy, frame(1.9), map, 0));
  EXPECT_TRUE(Wants(policy, frame(1.9), map, 0, true)) << "with an IMU";
  EXPECT_TRUE(Wants(policy, frame(2.1), map, 0));
  EXPECT_TRUE(Wants(policy, frame(0.0, 19), map, 0)) << "too few points to say that it stands";
}

TEST_F(KeyFramePolicyWants, NotOfAFrameThatSeesNoLandmarkUnlessItMust) {
  StandardKeyFramePolicy policy({.max_gap = 1.0});
  EXPECT_FALSE(Wants(policy, Seeing(0, 0, 300, 0.9), map, 0));
  EXPECT_TRUE(Wants(policy, Seeing(0, 0, 300, 1.1), map, 0));
}

TEST_F(KeyFramePolicyWants, WhenMuchIsWaitingToBeMapped) {
  StandardKeyFramePolicy policy(
      {.min_share = 0.1, .max_gap = 100.0, .wanted_tracked = 60, .wanted_new = 20});
  EXPECT_TRUE(Wants(policy, Seeing(59, 10, 21), map, 0));
  EXPECT_FALSE(Wants(policy, Seeing(60, 10, 21), map, 0)) << "enough tracked";
  EXPECT_FALSE(Wants(policy, Seeing(59, 10, 20), map, 0)) << "not enough new";
}

TEST_F(KeyFramePolicyWants, NotForCornersThatAreNotFoundAgainWhileEnoughLandmarksAre) {
  StandardKeyFramePolicy policy(
      {.min_share = 0.1, .max_gap = 100.0, .wanted_tracked = 60, .wanted_new = 20});
  const auto wants = [&](const Tracked& tracked, double last_keyframe) {
    return policy.Wants(tracked.Candidate(FromSeconds(last_keyframe), false), map);
  };
  wants(Seeing(100, 10, 0, 0.9), 0.0);
  // The keyframe at 1.0 has mapped all corners; of the next image 80 match none of them.
  EXPECT_FALSE(wants(Seeing(55, 5, 80, 1.1), 1.0));
  EXPECT_FALSE(wants(Seeing(55, 5, 100, 1.2), 1.0)) << "20 more";
  EXPECT_TRUE(wants(Seeing(55, 5, 101, 1.3), 1.0)) << "21 more";
  EXPECT_TRUE(wants(Seeing(55, 4, 21, 1.2), 1.0)) << "only 59 landmarks in all";
}

TEST_F(KeyFramePolicyWants, DoesNotCountLandmarksOnProbation) {
  StandardKeyFramePolicy policy({.min_share = 0.5, .max_gap = 100.0, .wanted_tracked = 0});
  // Keyframe 2 alone keeps sixty points: forty points and ten lines are left.
  for (PointId id(0); id < PointId(60); ++id) {
    map.Forget(0_kf, id);
    map.Forget(1_kf, id);
  }
  EXPECT_FALSE(Wants(policy, Seeing(25, 0, 0), map, 0));
  EXPECT_TRUE(Wants(policy, Seeing(24, 0, 0), map, 0));
  // In a map of two keyframes all landmarks count.
  map.RemoveKeyFrame(0_kf, 1_kf);
  EXPECT_TRUE(Wants(policy, Seeing(54, 0, 0), map, 0));
  EXPECT_FALSE(Wants(policy, Seeing(55, 0, 0), map, 0));
}

TEST_F(KeyFramePolicyWants, AFrameByTheImuAloneWhenImagesHaveGivenNoPoseForLong) {
  StandardKeyFramePolicy policy({.min_features = 50});
  const auto wants = [&](double since_image, int more) {
    const Tracked tracked = Seeing(0, 0, more, 60.0);
    KeyFrameCandidate candidate = tracked.Candidate(0, /*with_imu=*/true);
    candidate.state = TrackingState::kInertial;
    candidate.since_image = since_image;
    return policy.Wants(candidate, map);
  };
  EXPECT_TRUE(wants(0.5, 50));
  EXPECT_FALSE(wants(0.4, 50)) << "the image before may be found again";
  EXPECT_FALSE(wants(0.5, 49)) << "too few features for a map";
}

// Wants every third frame, and starts a map at the second.
class EveryThird final : public KeyFramePolicy {
 public:
  int asked_to_start = 0;
  std::vector<double> gaps;

  bool CanStart(const FrameFeatures& features) override {
    return ++asked_to_start == 2 && !features.points.empty();
  }
  bool Wants(const KeyFrameCandidate& candidate, const Map& map) override {
    EXPECT_EQ(candidate.state, TrackingState::kTracking);
    EXPECT_EQ(candidate.points.size(), candidate.frame.features->points.size());
    EXPECT_EQ(candidate.lines.size(), candidate.frame.features->lines.size());
    EXPECT_GT(candidate.num_points + candidate.num_lines, 0);
    EXPECT_NE(map.keyframe(candidate.reference), nullptr);
    EXPECT_EQ(candidate.since_image, 0.0);
    EXPECT_FALSE(candidate.with_imu);
    gaps.push_back(candidate.since_keyframe);
    return gaps.size() % 3 == 0;
  }
};

TEST(KeyFramePolicy, OfTheUserDecidesInSlamSystem) {
  const auto policy = std::make_shared<EveryThird>();
  SlamSystem slam(testing::MovingWall::Sensor(), Deterministic({}), {.keyframe_policy = policy});
  const testing::MovingWall wall;
  std::vector<bool> keyframes;
  for (int frame = 0; frame < 11; ++frame) {
    const FrameResult result = slam.Track(wall.View(frame));
    keyframes.push_back(result.mapping.has_value());
    EXPECT_EQ(result.state, frame == 0 ? TrackingState::kInitializing : TrackingState::kTracking);
  }
  EXPECT_EQ(policy->asked_to_start, 2);
  EXPECT_EQ(policy->gaps.size(), 9U) << "the first frame of a map is not asked for";
  const std::vector<bool> expected = {false, true, false, false, true, false,
                                      false, true, false, false, true};
  EXPECT_EQ(keyframes, expected);
  EXPECT_NEAR(policy->gaps[2], 0.1, 1e-6);
  EXPECT_NEAR(policy->gaps[3], 0.0333, 1e-4);
}

}  // namespace
}  // namespace highwall::keyframe_policy_test
