// Options shared by tracking, relocalization, local mapping and loop closing (which features may
// match, and their weights) are held once, by the measurement model. These tests change its fields
// from their defaults one by one: the result of every stage that uses a field must change, by at
// least one bit; the results of the other stages must not.
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "local/local_mapper.h"
#include "loops/loop_correction.h"
#include "loops/loop_detector.h"
#include "support/id_literals.h"
#include "support/loop_scene.h"
#include "support/synthetic_scene.h"
#include "tracking/relocalizer.h"
#include "tracking/tracker.h"

namespace highwall::shared_options_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::LoopScene;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;
using testing::SyntheticView;
using testing::operator""_kf;

struct Shared {
  MeasurementOptions measurement{.weighting = Weighting::kPaper};  // which uses the baseline
  PyramidOptions pyramid{};
  MatchingOptions matching{};
};

enum Stage { kTracking = 1, kRelocalization = 2, kMapping = 4, kLoops = 8 };
constexpr int kAll = kTracking | kRelocalization | kMapping | kLoops;
// Stages that match by projection. The descriptors of the walk never change.
constexpr int kProjecting = kTracking | kMapping | kLoops;
constexpr int kProjectingChanged = kTracking | kMapping;

struct Case {
  const char* field;
  int stages;
  std::function<void(Shared&)> set;
};

// map_ratio and min_deviation are missing, because the scene is too easy for them.
std::vector<Case> Cases() {
  return {
      {"weighting", kAll, [](Shared& s) { s.measurement.weighting = Weighting::kCovariance; }},
      {"baseline", kAll, [](Shared& s) { s.measurement.baseline = 0.2; }},
      {"point_sigma", kAll, [](Shared& s) { s.measurement.point_sigma = 1.4; }},
      {"line_sigma", kAll, [](Shared& s) { s.measurement.line_sigma = 3.0; }},
      {"levels", kProjecting, [](Shared& s) { s.pyramid.levels = 2; }},
      {"scale_factor", kAll, [](Shared& s) { s.pyramid.scale_factor = 1.5; }},
      {"motion_radius", kTracking, [](Shared& s) { s.measurement.motion_radius = 3.0; }},
      {"map_radius", kProjecting, [](Shared& s) { s.matching.map_radius = 0.5; }},
      {"min_view_cosine", kProjecting, [](Shared& s) { s.matching.min_view_cosine = 0.9999; }},
      {"min_line_pixels", kProjecting, [](Shared& s) { s.matching.min_line_pixels = 120.0F; }},
      {"max_hamming.projection", kProjectingChanged,
       [](Shared& s) { s.measurement.max_hamming.projection = 9; }},
      {"max_hamming.relocalization", kRelocalization,
       [](Shared& s) { s.measurement.max_hamming.relocalization = 9; }},
      {"motion_ratio", kTracking, [](Shared& s) { s.matching.motion_ratio = 0.01; }},
      {"max_angle_diff", kTracking, [](Shared& s) { s.matching.max_angle_diff = 2.0; }},
      {"small_motion", kProjecting,
       [](Shared& s) { s.matching.lines.small_motion.max_midpoint_distance = 0.5; }},
      {"large_motion", kRelocalization | kLoops,
       [](Shared& s) { s.matching.lines.large_motion.max_midpoint_distance = 1.0; }},
      {"max_distance", kTracking | kRelocalization | kMapping,
       [](Shared& s) { s.matching.lines.max_distance = 9; }},
      {"ratio", kRelocalization, [](Shared& s) { s.matching.lines.ratio = 0.01; }},
      {"mad_rule and mad_k", kAll,
       [](Shared& s) {
         s.measurement.mad_rule = MadRule::kPaper;
         s.matching.lines.mad_k = 1e-9;
       }},
  };
}

// All results of a stage, as numbers.
using Outcome = std::vector<double>;

void Append(const Pose& T, Outcome& outcome) {
  outcome.insert(outcome.end(), T.data(), T.data() + Pose::kSize);
}

void Append(const Map& map, Outcome& outcome) {
  for (const KeyFrameId id : map.keyframe_ids()) Append(map.keyframe(id)->T_WC, outcome);
  for (const PointId id : map.ids<MapPoint>()) {
    const MapPoint& point = *map.Find(id);
    outcome.insert(outcome.end(), {point.p_W.x(), point.min_distance,
                                   static_cast<double>(point.observations.size())});
  }
  for (const LineId id : map.ids<MapLine>()) {
    const MapLine& line = *map.Find(id);
    outcome.insert(outcome.end(),
                   {line.segment_W.p().x(), static_cast<double>(line.observations.size())});
  }
}

// Returns the view under changed conditions: up to every tenth bit of the descriptors is flipped,
// and corners are rotated by some degrees.
SyntheticView Changed(SyntheticView view) {
  std::mt19937 rng(3);
  auto features = std::make_shared<FrameFeatures>(*view.features);
  features->point_descriptors = features->point_descriptors.clone();
  features->line_descriptors = features->line_descriptors.clone();
  for (cv::Mat* const descriptors : {&features->point_descriptors, &features->line_descriptors}) {
    for (int i = 0; i < descriptors->rows; ++i) {
      for (int k = 0; k < 12; ++k) {
        descriptors->at<std::uint8_t>(i, static_cast<int>(rng() % 32)) ^=
            static_cast<std::uint8_t>(1U << rng() % 8);
      }
    }
  }
  for (PointFeature& point : features->points) {
    point.angle += static_cast<float>(testing::Uniform(rng, -10.0, 10.0));
  }
  view.features = features;
  return view;
}

class SharedOptions : public ::testing::Test {
 protected:
  SharedOptions() {
    for (const double x : {0.0, 0.1}) {
      const Pose T_WC = Pose::FromTangent({x, 0, 0}, {0, 0, 0});
      known_.Add(Look(scene_, IdealSensor(), T_WC, {.px = 0.5, .depth = true}), T_WC);
    }
    for (int i = 0; i < walk_.size(); ++i) last_ = walk_.Add(i);
  }

  Outcome Track(const MeasurementModel& model) const {
    Map map = known_.map.Clone();
    const SensorModel sensor(model, {});
    Tracker tracker(model, {}, sensor);
    TrackedFrame before;
    before.frame = map.keyframe(1_kf)->frame;
    tracker.Anchor(before, *map.keyframe(1_kf));
    const TrackedFrame tracked = tracker.Track(testing::MakeFrame(view_, 2), map).frame;
    Outcome outcome{static_cast<double>(tracked.num_points),
                    static_cast<double>(tracked.num_lines)};
    Append(tracked.T_WC, outcome);
    return outcome;
  }

  Outcome Relocalize(const MeasurementModel& model) const {
    const auto found = Relocalizer(model, {}).Relocalize(*view_.features, known_.map);
    if (!found) return {};
    Outcome outcome{static_cast<double>(found->matches.points.size()),
                    static_cast<double>(found->matches.lines.size())};
    Append(found->T_WC, outcome);
    return outcome;
  }

  // Only every other landmark of the keyframe was tracked: the others are found by projection.
  Outcome MapLocally(const MeasurementModel& model) const {
    Map map = known_.map.Clone();
    LocalMapper mapper(model, {}, false);
    TrackedFrame tracked;
    tracked.frame = testing::MakeFrame(view_, 2);
    tracked.state = TrackingState::kTracking;
    tracked.T_WC = kPose;
    const auto half = [](const std::vector<int>& seen, const auto& ids) {
      auto landmarks = ids;
      landmarks.assign(seen.size(), kNoId);
      for (std::size_t i = 0; i < seen.size(); i += 2) {
        landmarks[i] = ids[static_cast<std::size_t>(seen[i])];
      }
      return landmarks;
    };
    tracked.points = half(view_.points, known_.point_ids);
    tracked.lines = half(view_.lines, known_.line_ids);
    mapper.InsertKeyFrame(tracked, map, std::nullopt);
    Outcome outcome;
    Append(map, outcome);
    return outcome;
  }

  Outcome CloseLoop(const MeasurementModel& model) const {
    LoopDetector detector(model);
    const auto loop = detector.Verify(walk_.map, last_, kStart, {});
    if (!loop) return {};
    Outcome outcome;
    Append(loop->edge.Z, outcome);
    Map map = walk_.map.Clone();
    CorrectLoop({}, *loop, model, {}, {}, &map);
    Append(map, outcome);
    return outcome;
  }

  static constexpr KeyFrameId kStart{11};  // the walk ends there as well
  const Pose kPose = Pose::FromTangent({0.13, 0.02, 0.02}, {0.01, -0.02, 0.01});
  const Scene scene_ = MakeScene(31, 400, 60);
  SceneMap known_{scene_};
  const SyntheticView view_ =
      Changed(Look(scene_, IdealSensor(), kPose, {.px = 0.8, .depth = true, .seed = 7}));
  LoopScene walk_{{.drift = {0.005, 0.002, 0.0}}};
  KeyFrameId last_;
};

TEST_F(SharedOptions, EachFieldReachesEveryStageThatUsesIt) {
  const auto outcomes = [&](const Shared& shared) {
    const MeasurementModel model(IdealSensor(), shared.measurement, Pose(), shared.pyramid,
                                 shared.matching);
    return std::vector<Outcome>{Track(model), Relocalize(model), MapLocally(model),
                                CloseLoop(model)};
  };
  const std::vector<Outcome> usual = outcomes({});
  EXPECT_EQ(outcomes({}), usual) << "the same options, the same outcome";
  const char* const names[] = {"tracking", "relocalization", "local mapping", "loops"};
  for (std::size_t stage = 0; stage < usual.size(); ++stage) {
    EXPECT_FALSE(usual[stage].empty()) << names[stage];
  }
  for (const Case& each : Cases()) {
    Shared shared;
    each.set(shared);
    const std::vector<Outcome> other = outcomes(shared);
    for (std::size_t stage = 0; stage < usual.size(); ++stage) {
      const bool used = (each.stages >> stage & 1) != 0;
      EXPECT_EQ(other[stage] != usual[stage], used) << each.field << ", " << names[stage];
    }
  }
}

}  // namespace
}  // namespace highwall::shared_options_test
