// The search for the pose of a frame: which hypotheses are tried, and which result is kept.
#include "tracking/pose_hypothesis.h"

#include <optional>

#include <gtest/gtest.h>

#include "features/depth_grid.h"
#include "support/synthetic_scene.h"
#include "tracking/last_frame_source.h"
#include "tracking/recognition_sources.h"
#include "tracking/whole_image_source.h"

namespace highwall::pose_hypothesis_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeFrame;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;

LocalMatch MatchOf(int points, int lines = 0) {
  LocalMatch match{TrackedFrame()};
  match.frame.num_points = points;
  match.frame.num_lines = lines;
  return match;
}

TEST(PoseSearch, KeepsThePoseWithMostSupportAndTheEarlierOfEqualOnes) {
  PoseSearch search;
  EXPECT_FALSE(search.Take(std::nullopt));
  EXPECT_FALSE(search.best.has_value());
  EXPECT_TRUE(search.Take(MatchOf(20)));
  EXPECT_FALSE(search.Take(MatchOf(10, 5)));
  EXPECT_EQ(search.best->frame.num_lines, 0);
  EXPECT_TRUE(search.Take(MatchOf(10, 6)));
  EXPECT_FALSE(search.Take(std::nullopt));
  EXPECT_EQ(search.best->Support(), 22);
}

TEST(PoseSearch, RemembersWhetherTheLastVerificationWasAmbiguous) {
  PoseSearch search;
  search.Add({.match = MatchOf(20), .is_ambiguous = true});
  EXPECT_TRUE(search.is_ambiguous);
  EXPECT_TRUE(search.best.has_value());
  search.Add({});
  EXPECT_FALSE(search.is_ambiguous);
  EXPECT_TRUE(search.best.has_value());
}

TEST(TrackingDiagnostics, TakesTheMostMatchesAndTheLatestMask) {
  TrackingDiagnostics diagnostics;
  diagnostics.Add({.tried = 40, .agreed = 5, .masked_share = 0.7, .shift = 12.0});
  diagnostics.Add({.tried = 30, .agreed = 10, .masked_share = 0.2, .shift = {}});
  diagnostics.Add({});
  EXPECT_EQ(diagnostics.tried, 40);
  EXPECT_EQ(diagnostics.agreed, 10);
  EXPECT_EQ(diagnostics.masked_share, 0.2);
  EXPECT_EQ(diagnostics.shift, 12.0);
}

TEST(TrackerState, ACameraReachesWhatItsSpeedAllows) {
  TrackerState state;
  state.last.emplace().frame.stamp = FromSeconds(1.0);
  const auto reaches = [&](double seconds, const Eigen::Vector3d& p, const Eigen::Vector3d& turn) {
    TrackedFrame tracked;
    tracked.frame.stamp = FromSeconds(1.0 + seconds);
    tracked.T_WC = Pose::FromTangent(p, turn);
    return state.IsReachable(tracked);
  };
  EXPECT_TRUE(reaches(0.5, {1.4, 0.0, 0.0}, {0.0, 0.0, 0.0}));
  EXPECT_FALSE(reaches(0.5, {1.6, 0.0, 0.0}, {0.0, 0.0, 0.0})) << "3.2 m/s";
  EXPECT_TRUE(reaches(0.1, {0.0, 0.0, 0.0}, {0.0, 0.59, 0.0}));
  EXPECT_FALSE(reaches(0.1, {0.0, 0.0, 0.0}, {0.0, 0.61, 0.0})) << "6.1 rad/s";
  EXPECT_FALSE(reaches(0.0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}));
}

// The sources of a camera that has mapped its first frame.
class PoseSources : public ::testing::Test {
 protected:
  PoseSources() : scene_map_(scene_) {
    const KeyFrameId id = scene_map_.Add(view_, Pose());
    const KeyFrame& keyframe = *scene_map_.map.keyframe(id);
    TrackedFrame last;
    last.frame = MakeFrame(view_, 0);
    last.points = keyframe.points;
    last.lines = keyframe.lines;
    last.reference = id;
    state_.last = last;
    frame_ = MakeFrame(view_, 1);
  }

  TrackingQuery Query(const PoseConstraint* prediction = nullptr) const {
    return {frame_, scene_map_.map, prediction};
  }

  const MeasurementModel model_{IdealSensor(), {}};
  const Scene scene_ = MakeScene(15, 500, 40);
  const testing::SyntheticView view_ = Look(scene_, IdealSensor(), Pose());
  SceneMap scene_map_;
  Frame frame_;
  TrackerOptions options_;
  const TrackerParameters parameters_{};
  TrackerState state_;
  const PoseConstraint predicted_{Pose::FromTangent({0.01, 0, 0}, {0, 0, 0})};
  const DepthGrid grid_{IdealSensor().camera};
  const MapMatcher matcher_{model_};
  const Relocalizer relocalizer_{model_, {}};
  const FrameSolver solver_{model_, options_, grid_, state_};
  const LastFrameSource last_frame_{matcher_, options_, parameters_, solver_, state_};
  const ReferenceKeyframeSource reference_{relocalizer_, state_};
  const PlaceIndexSource place_{relocalizer_};
  const SurfaceSource surfaces_{matcher_, options_, parameters_, solver_, state_};
  const WholeImageSource image_{matcher_, options_, parameters_, grid_, solver_, state_};
};

TEST_F(PoseSources, WhereNothingIsFoundAllButTheReferenceAreTriedUnlessAnImuPredicts) {
  const PoseSearch nothing;
  for (const PoseConstraint* prediction :
       {static_cast<const PoseConstraint*>(nullptr), &predicted_}) {
    const TrackingQuery query = Query(prediction);
    EXPECT_TRUE(last_frame_.IsDue(query, nothing));
    EXPECT_FALSE(reference_.IsDue(query, nothing));
    EXPECT_TRUE(place_.IsDue(query, nothing));
    EXPECT_EQ(surfaces_.IsDue(query, nothing), prediction == nullptr);
    EXPECT_EQ(image_.IsDue(query, nothing), prediction == nullptr);
  }
}

TEST_F(PoseSources, AnAmbiguousPoseIsComparedWithTheReferenceAlone) {
  PoseSearch ambiguous;
  ambiguous.Add({.match = MatchOf(200), .is_ambiguous = true});
  EXPECT_TRUE(reference_.IsDue(Query(), ambiguous));
  EXPECT_FALSE(place_.IsDue(Query(), ambiguous));
  EXPECT_FALSE(surfaces_.IsDue(Query(), ambiguous));
  EXPECT_FALSE(image_.IsDue(Query(), ambiguous));
}

TEST_F(PoseSources, FewLandmarksCallForTheWholeImage) {
  PoseSearch few, many;
  few.Add({.match = MatchOf(129)});
  many.Add({.match = MatchOf(130)});
  EXPECT_TRUE(image_.IsDue(Query(), few));
  EXPECT_FALSE(surfaces_.IsDue(Query(), few));
  EXPECT_FALSE(image_.IsDue(Query(), many));
  EXPECT_FALSE(image_.IsDue(Query(&predicted_), few)) << "an IMU predicts";
}

TEST_F(PoseSources, ALostCameraHasThePlaceIndexAlone) {
  state_.last.reset();
  const PoseSearch nothing;
  EXPECT_FALSE(last_frame_.IsDue(Query(), nothing));
  EXPECT_TRUE(place_.IsDue(Query(), nothing));
  EXPECT_FALSE(surfaces_.IsDue(Query(), nothing));
  EXPECT_FALSE(image_.IsDue(Query(), nothing));
}

TEST_F(PoseSources, FallbacksFollowTheirOptionsAndTheMask) {
  PoseSearch masked;
  masked.diagnostics.masked_share = 0.5;
  EXPECT_TRUE(surfaces_.IsDue(Query(), masked));
  EXPECT_FALSE(image_.IsDue(Query(), masked)) << "most of the image moves";
  options_.surfaces.enabled = options_.direct.enabled = false;
  EXPECT_FALSE(surfaces_.IsDue(Query(), {}));
  EXPECT_FALSE(image_.IsDue(Query(), {}));
}

TEST_F(PoseSources, TheLastFrameTakesThePredictionAsAPrior) {
  const PoseHypothesis predicted = last_frame_.Propose(Query(&predicted_));
  ASSERT_TRUE(predicted.prior.has_value());
  EXPECT_EQ(predicted.prior->T_WC.p(), predicted_.T_WC.p());
  EXPECT_FALSE(predicted.diagnostics.shift.has_value());
  const PoseHypothesis unaided = last_frame_.Propose(Query());
  EXPECT_EQ(unaided.origin, PoseOrigin::kMotion);
  EXPECT_FALSE(unaided.prior.has_value());
  EXPECT_NEAR(unaided.diagnostics.shift.value(), 0.0, 1e-9);
  ASSERT_TRUE(unaided.rough.has_value());
  EXPECT_LT(testing::PositionError(unaided.rough->T_WC, Pose()), 1e-6);
  EXPECT_FALSE(unaided.is_inconsistent);
  EXPECT_EQ(unaided.diagnostics.agreed, MatchedSupport(*unaided.rough));
}

TEST_F(PoseSources, OnlyThePlaceIndexRelocalizes) {
  const PoseHypothesis reference = reference_.Propose(Query(&predicted_));
  const PoseHypothesis place = place_.Propose(Query(&predicted_));
  EXPECT_EQ(reference.origin, PoseOrigin::kReference);
  EXPECT_EQ(place.origin, PoseOrigin::kPlace);
  for (const PoseHypothesis* recognized : {&reference, &place}) {
    EXPECT_FALSE(recognized->prior.has_value()) << "a place does not depend on the motion";
    ASSERT_TRUE(recognized->rough.has_value());
    EXPECT_EQ(recognized->rough->relocalized, recognized == &place);
  }
}

TEST_F(PoseSources, AReferenceThatIsGoneProposesNothing) {
  state_.last->reference = kNoId;
  EXPECT_FALSE(reference_.Propose(Query()).rough.has_value());
  EXPECT_FALSE(image_.Propose(Query()).without_landmarks.has_value());
}

}  // namespace
}  // namespace highwall::pose_hypothesis_test
