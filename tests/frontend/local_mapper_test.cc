#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/factors/imu_preintegration.h>

#include "local/local_mapper.h"
#include "local_mapper_fixture.h"
#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::local_mapper_test {
namespace {

using testing::AngleError;
using testing::At;
using testing::IdealSensor;
using testing::LocalMapperTest;
using testing::Look;
using testing::PositionError;
using testing::SceneLine;
using testing::ScenePoint;
using testing::SyntheticView;
using testing::operator""_kf;

TEST_F(LocalMapperTest, FirstKeyFrameMakesALandmarkOfEveryFeatureWithDepth) {
  LocalMapper mapper(model, {});
  const Pose T_WC = Pose::FromTangent({0.1, 0.2, 0}, {0, 0.1, 0.2});
  SyntheticView view = Look(scene, IdealSensor(), T_WC);
  auto features = std::make_shared<FrameFeatures>(*view.features);
  features->points[3].depth = 0.0;
  features->lines[2].segment_C.reset();
  view.features = features;
  const auto report = Insert(mapper, view, T_WC);
  EXPECT_EQ(report.keyframe, 0_kf);
  EXPECT_EQ(report.new_points, static_cast<int>(view.points.size()) - 1);
  EXPECT_EQ(report.new_lines, static_cast<int>(view.lines.size()) - 1);
  EXPECT_EQ(map.num<MapPoint>(), view.points.size() - 1);
  EXPECT_EQ(map.num<MapLine>(), view.lines.size() - 1);
  EXPECT_FALSE(report.bundle.usable) << "one keyframe: nothing to adjust";
  const KeyFrame& keyframe = *map.keyframe(0_kf);
  EXPECT_EQ(keyframe.points[3], kNoId);
  EXPECT_EQ(keyframe.lines[2], kNoId);
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    if (i == 3) continue;
    const ScenePoint& truth = scene.points[static_cast<std::size_t>(view.points[i])];
    const MapPoint& point = *map.Find(keyframe.points[i]);
    EXPECT_LT((point.p_W - truth.p_W).norm(), 1e-13);  // to and from pixels: rounding
    EXPECT_EQ(point.descriptor, truth.descriptor);
    const double distance = (truth.p_W - T_WC.p()).norm();
    EXPECT_LE(point.min_distance, distance * (1 + 1e-12));
    EXPECT_GE(point.max_distance, distance * (1 - 1e-12));
  }
  for (std::size_t i = 0; i < view.lines.size(); ++i) {
    if (i == 2) continue;
    const SceneLine& truth = scene.lines[static_cast<std::size_t>(view.lines[i])];
    const MapLine& line = *map.Find(keyframe.lines[i]);
    const auto along = PluckerLine::FromPoints(truth.segment_W.p(), truth.segment_W.q());
    EXPECT_LT(along.Distance(line.segment_W.p()), 1e-6);  // float pixels at 5 m
    EXPECT_LT(along.Distance(line.segment_W.q()), 1e-6);
    EXPECT_TRUE(line.has_descriptor);
    EXPECT_EQ(line.descriptor, truth.descriptor);
  }
}

TEST_F(LocalMapperTest, CornersOfUncertainDepthMakeNoLandmark) {
  LocalMapper mapper(model, {});
  SyntheticView view = Look(scene, IdealSensor(), At(0));
  auto features = std::make_shared<FrameFeatures>(*view.features);
  features->points[4].depth_sigma = 0.029 * features->points[4].depth;
  features->points[5].depth_sigma = 0.031 * features->points[5].depth;
  view.features = features;
  Insert(mapper, view, At(0));
  EXPECT_NE(map.keyframe(0_kf)->points[4], kNoId);
  EXPECT_EQ(map.keyframe(0_kf)->points[5], kNoId);
}

TEST_F(LocalMapperTest, MasksDynamicObjectsInTheDepthOfAKeyFrame) {
  LocalMapper mapper(model, {});
  SyntheticView view = Look(scene, IdealSensor(), At(0));
  auto features = std::make_shared<FrameFeatures>(*view.features);
  features->depth_grid = cv::Mat(60, 80, CV_32FC1, cv::Scalar(2.0));
  view.features = features;
  TrackedFrame tracked = Tracked(view, At(0));
  tracked.moving = cv::Mat::zeros(60, 80, CV_8UC1);
  tracked.moving.at<std::uint8_t>(20, 30) = 255;
  const KeyFrame& keyframe = *map.keyframe(Insert(mapper, view, tracked).keyframe);
  EXPECT_EQ(keyframe.depth_grid.at<float>(19, 31), 0.0F) << "its border is of both sides";
  EXPECT_EQ(keyframe.depth_grid.at<float>(18, 30), 2.0F);
  EXPECT_EQ(cv::countNonZero(keyframe.depth_grid), 60 * 80 - 9);
  EXPECT_EQ(cv::countNonZero(keyframe.frame.features->depth_grid), 60 * 80) << "as it was measured";
}

TEST_F(LocalMapperTest, ShortSegmentsMakeNoLandmark) {
  LocalMapper mapper(model, {}, true, {.min_line_length = 0.5});
  const SyntheticView view = Look(scene, IdealSensor(), At(0));
  Insert(mapper, view, At(0));
  for (std::size_t i = 0; i < view.lines.size(); ++i) {
    const SegmentDepth& fit = *view.features->lines[i].segment_C;
    EXPECT_EQ(map.keyframe(0_kf)->lines[i] != kNoId, (fit.q_C - fit.p_C).norm() >= 0.5);
  }
}

TEST_F(LocalMapperTest, TrackedLandmarksAreSeenAgainAndNotMadeTwice) {
  LocalMapper mapper(model, {});
  InsertAt(mapper, 0.0);
  const std::size_t before = map.num<MapPoint>();
  const SyntheticView view = Look(scene, IdealSensor(), At(0.3));
  const TrackedFrame tracked = Tracked(view, At(0.3));
  const auto known = std::count_if(tracked.points.begin(), tracked.points.end(),
                                   [](PointId id) { return id != kNoId; });
  const auto report = Insert(mapper, view, tracked);
  EXPECT_GT(known, 60);
  EXPECT_EQ(report.new_points, static_cast<int>(view.points.size() - known));
  EXPECT_EQ(map.num<MapPoint>(), before + view.points.size() - static_cast<std::size_t>(known));
  EXPECT_TRUE(report.bundle.usable);
  EXPECT_EQ(report.bundle.outliers, 0);
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    if (tracked.points[i] == kNoId) continue;
    EXPECT_EQ(map.Find(tracked.points[i])->observations.size(), 2u);
  }
}

TEST_F(LocalMapperTest, LandmarksOfNeighboursThatWereNotTrackedAreFound) {
  LocalMapper mapper(model, {});
  InsertAt(mapper, 0.0);
  const SyntheticView view = Look(scene, IdealSensor(), At(0.1));
  const TrackedFrame full = Tracked(view, At(0.1));
  TrackedFrame half = full;
  for (std::size_t i = 0; i < half.points.size(); i += 2) half.points[i] = kNoId;
  for (std::size_t i = 0; i < half.lines.size(); i += 2) half.lines[i] = kNoId;
  Insert(mapper, view, half);
  EXPECT_EQ(map.keyframe(1_kf)->points.size(), full.points.size());
  for (std::size_t i = 0; i < full.points.size(); ++i) {
    if (full.points[i] == kNoId) continue;
    EXPECT_EQ(map.keyframe(1_kf)->points[i], full.points[i]) << i;
  }
  for (std::size_t i = 0; i < full.lines.size(); ++i) {
    if (full.lines[i] == kNoId) continue;
    EXPECT_EQ(map.keyframe(1_kf)->lines[i], full.lines[i]) << i;
  }
}

TEST_F(LocalMapperTest, LinesOfNeighboursPassTheOutlierRuleOfTheModel) {
  for (const bool strict : {false, true}) {
    const MeasurementModel rule = strict ? MeasurementModel(IdealSensor(), testing::kStrictRule,
                                                            Pose(), {}, testing::kStrictLines)
                                         : MeasurementModel(IdealSensor(), {});
    LocalMapper mapper(rule, {});
    map = Map();
    std::ranges::fill(point_ids, kNoId);
    std::ranges::fill(line_ids, kNoId);
    InsertAt(mapper, 0.0);
    const SyntheticView view = Look(scene, IdealSensor(), At(0.1));
    const TrackedFrame full = Tracked(view, At(0.1));
    TrackedFrame without = full;
    without.lines.assign(full.lines.size(), kNoId);
    Insert(mapper, view, without);
    int known = 0, found = 0;
    for (std::size_t i = 0; i < full.lines.size(); ++i) {
      if (full.lines[i] == kNoId) continue;
      ++known;
      found += map.keyframe(1_kf)->lines[i] == full.lines[i] ? 1 : 0;
    }
    ASSERT_GT(known, 10);
    EXPECT_LE(found, strict ? 2 : known);
    EXPECT_GE(found, strict ? 0 : known);
  }
}

TEST_F(LocalMapperTest, TwoLandmarksOfOnePlaceBecomeOne) {
  LocalMapper mapper(model, {});
  const SyntheticView first = Look(scene, IdealSensor(), At(0.0));
  Insert(mapper, first, At(0.0));
  // The second keyframe was not tracked to some of them and did not search for any.
  LocalMapper blind(model, {.fused_keyframes = 0});
  const SyntheticView second = Look(scene, IdealSensor(), At(0.1));
  TrackedFrame tracked = Tracked(second, At(0.1));
  std::vector<std::pair<PointId, PointId>> twins;
  for (std::size_t i = 0; i < 10; ++i) {
    if (tracked.points[i] != kNoId) twins.emplace_back(tracked.points[i], kNoId);
    tracked.points[i] = kNoId;
  }
  Insert(blind, second, tracked);
  const std::size_t with_twins = map.num<MapPoint>();
  // The third is tracked to the younger ones; the search in its neighbours finds the older ones.
  const auto report = InsertAt(mapper, 0.05);
  EXPECT_GE(twins.size(), 5u);
  EXPECT_EQ(report.fused_points, static_cast<int>(twins.size()));
  EXPECT_EQ(map.num<MapPoint>(),
            with_twins - twins.size() + static_cast<std::size_t>(report.new_points));
  for (const auto& [older, none] : twins) {
    // The remaining landmark has all three keyframes, in order.
    if (map.Find(older) == nullptr) continue;
    EXPECT_EQ(map.Find(older)->observations.size(), 3u);
  }
  for (const PointId id : map.ids<MapPoint>()) {
    const auto& o = map.Find(id)->observations;
    EXPECT_TRUE(std::is_sorted(
        o.begin(), o.end(), [](const auto& a, const auto& b) { return a.keyframe < b.keyframe; }));
  }
}

TEST_F(LocalMapperTest, AdjustmentCorrectsThePoseOfTheKeyFrame) {
  LocalMapper mapper(model, {});
  InsertAt(mapper, 0.0);
  InsertAt(mapper, 0.15);
  const SyntheticView view = Look(scene, IdealSensor(), At(0.3));
  Eigen::Matrix<double, 6, 1> error;
  error << 0.003, -0.002, 0.002, 0.001, 0.001, -0.001;
  const auto report = Insert(mapper, view, Tracked(view, At(0.3).Plus(error)));
  ASSERT_TRUE(report.bundle.usable);
  // New landmarks were created from the wrong pose, but the old ones constrain it: the few
  // iterations of a local adjustment remove all but a thousandth of the 4 mm.
  EXPECT_LT(PositionError(map.keyframe(2_kf)->T_WC, At(0.3)), 1e-5);
  EXPECT_LT(AngleError(map.keyframe(2_kf)->T_WC, At(0.3)), 1e-5);
}

TEST_F(LocalMapperTest, LandmarksRarelyFoundInViewAreDropped) {
  LocalMapper mapper(model, {});
  InsertAt(mapper, 0.0);
  const PointId good = map.keyframe(0_kf)->points[0], bad = map.keyframe(0_kf)->points[1];
  const LineId bad_line = map.keyframe(0_kf)->lines[0];
  map.Find(good)->visible = 8;
  map.Find(good)->found = 2;
  map.Find(bad)->visible = 9;
  map.Find(bad)->found = 2;
  map.Find(bad_line)->visible = 9;
  map.Find(bad_line)->found = 2;
  const auto report = InsertAt(mapper, 0.05);
  EXPECT_EQ(report.culled_points, 1);
  EXPECT_EQ(report.culled_lines, 1);
  EXPECT_NE(map.Find(good), nullptr);
  EXPECT_EQ(map.Find(bad), nullptr);
  EXPECT_EQ(map.Find(bad_line), nullptr);
}

TEST_F(LocalMapperTest, LandmarksSeenByTooFewKeyFramesFailTheirProbation) {
  LocalMapper mapper(model, {.min_observations = 2}, true, {.probation_keyframes = 2});
  // Two neighbouring places have little in common: what only the first one sees is not seen again.
  InsertAt(mapper, -0.6);
  EXPECT_EQ(InsertAt(mapper, 0.3).culled_points, 0) << "one keyframe later";
  std::vector<PointId> alone, shared;
  for (const PointId id : map.keyframe(0_kf)->points) {
    (map.Find(id)->observations.size() == 1 ? alone : shared).push_back(id);
  }
  ASSERT_GT(alone.size(), 10u);
  ASSERT_GT(shared.size(), 10u);
  const auto report = InsertAt(mapper, 0.35);
  EXPECT_GE(report.culled_points, static_cast<int>(alone.size()) / 2);
  for (const PointId id : shared) EXPECT_NE(map.Find(id), nullptr);
  // The points that the third keyframe sees have passed probation; all others are removed.
  for (const PointId id : alone) {
    const MapPoint* point = map.Find(id);
    EXPECT_TRUE(point == nullptr || point->observations.size() >= 2u);
  }
}

TEST_F(LocalMapperTest, RedundantKeyFramesGoButNotTheFirstNorTheNewest) {
  LocalMapper mapper(model, {});
  std::vector<KeyFrameId> culled;
  for (int i = 0; i < 8; ++i) {
    const auto report = InsertAt(mapper, 0.002 * i);
    for (const KeyFrameId id : report.culled_keyframes) {
      EXPECT_NE(id, 0_kf);
      EXPECT_LT(id, report.keyframe);
      EXPECT_EQ(map.keyframe(id), nullptr);
      culled.push_back(id);
    }
  }
  EXPECT_GE(culled.size(), 3u);
  EXPECT_NE(map.keyframe(0_kf), nullptr);
  EXPECT_NE(map.keyframe(7_kf), nullptr);
  for (const KeyFrameId id : culled) {
    EXPECT_LT(PositionError(map.ResolvePose(id), At(0.002 * id.value())), 1e-6);
  }
  EXPECT_EQ(map.num_keyframes() + culled.size(), 8u);
}

TEST_F(LocalMapperTest, CullsAKeyFrameWhosePointsEnoughOthersSee) {
  const int usual = LocalMapperParameters().redundant_observers;
  EXPECT_EQ(usual, 2) << "more, and a camera that stays makes the map grow";
  for (const int observers : {usual, 3, 4}) {
    map = Map();
    std::fill(point_ids.begin(), point_ids.end(), kNoId);
    std::fill(line_ids.begin(), line_ids.end(), kNoId);
    LocalMapper mapper(model, {}, true, {.redundant_observers = observers});
    // Neither the first nor the last keyframe is culled: for one between them, all others are
    // observers.
    for (int i = 0; i <= observers + 1; ++i) {
      const auto report = InsertAt(mapper, 0.002 * i);
      EXPECT_EQ(report.culled_keyframes.empty(), i <= observers) << observers << ' ' << i;
    }
  }
}

TEST_F(LocalMapperTest, TheSamePlaceOverAndOverMakesNoLargerMap) {
  LocalMapper mapper(model, {});
  // The maximum numbers, in the first laps and after.
  std::size_t keyframes[2] = {}, points[2] = {}, lines[2] = {};
  for (int lap = 0; lap < 15; ++lap) {
    const int late = lap < 3 ? 0 : 1;
    for (int i = 0; i < 8; ++i) {
      InsertAt(mapper, 0.15 * (i < 4 ? i : 8 - i) + 0.001 * lap);
      keyframes[late] = std::max(keyframes[late], map.num_keyframes());
      points[late] = std::max(points[late], map.num<MapPoint>());
      lines[late] = std::max(lines[late], map.num<MapLine>());
    }
  }
  EXPECT_GE(keyframes[0], 4u);
  // One additional keyframe may come before another is removed.
  EXPECT_LE(keyframes[1], keyframes[0] + 1);
  EXPECT_LE(points[1], points[0] + points[0] / 20);
  EXPECT_LE(lines[1], lines[0] + 1);
}

TEST_F(LocalMapperTest, LinesAloneMakeAKeyFrameRedundant) {
  LocalMapper mapper(model, {});
  std::size_t culled = 0;
  for (int i = 0; i < 8; ++i) {
    SyntheticView view = Look(scene, IdealSensor(), At(0.002 * i));
    auto features = std::make_shared<FrameFeatures>(*view.features);
    features->points.clear();
    features->point_descriptors = cv::Mat();
    view.features = features;
    view.points.clear();
    culled += Insert(mapper, view, At(0.002 * i)).culled_keyframes.size();
  }
  EXPECT_GE(culled, 3u);
  EXPECT_EQ(map.num<MapPoint>(), 0u);
}

TEST_F(LocalMapperTest, KeepsARedundantKeyFrameForAWhileWhereTheImuConstrainsItsNeighbours) {
  // The camera is stationary, with a keyframe every 0.6 s: without one of them there is a gap of
  // 1.2 s.
  LocalMapper mapper(model, {}, true, {.motion_span = 3.0});
  const auto stamp = [](int k) { return Stamp{k} * 600'000'000; };
  for (int k = 0; k < 20; ++k) {
    const SyntheticView view = Look(scene, IdealSensor(), At(0.001 * k));
    TrackedFrame tracked = Tracked(view, At(0.001 * k));
    tracked.frame.stamp = stamp(k);
    InertialState motion;
    motion.stamp = stamp(k);
    if (k > 0) {
      motion.previous = KeyFrameId(k - 1);
      const std::vector<ImuSample> readings{{stamp(k - 1), {0, 0, 0}, {0, 0, 9.81}},
                                            {stamp(k), {0, 0, 0}, {0, 0, 9.81}}};
      motion.from_previous = std::make_shared<const ImuPreintegration>(readings, ImuBias::Zero());
    }
    const auto report = Insert(mapper, view, tracked, motion);
    // The time is relative to the previous keyframe, around which the mapper culls.
    for (const KeyFrameId id : report.culled_keyframes)
      EXPECT_LT(stamp(id.value()) + 3'000'000'000, stamp(k));
    for (int i = std::max(1, k - 4); i <= k; ++i) {
      const KeyFrameId id(i), before(i - 1);
      ASSERT_NE(map.keyframe(id), nullptr) << id << " of " << k;
      EXPECT_EQ(map.keyframe(id)->motion->previous == before, map.keyframe(before) != nullptr);
    }
  }
  // No IMU factor spans the place of a removed keyframe.
  for (const KeyFrameId id : map.keyframe_ids()) {
    const InertialState& motion = *map.keyframe(id)->motion;
    EXPECT_EQ(motion.previous == kNoId, motion.from_previous == nullptr) << id;
    if (motion.from_previous == nullptr) continue;
    EXPECT_LE(motion.stamp - motion.from_previous->start(), 1'000'000'000) << id;
  }
  // The first keyframe remains, and those of the 3 s before the last but one.
  EXPECT_LE(map.num_keyframes(), 8u);
}

TEST_F(LocalMapperTest, KeepsALandmarkOfACulledKeyFrameThatTheNewOneSees) {
  LocalMapper mapper(model, {.min_observations = 3});
  for (int i = 0; i < 12; ++i) {
    const SyntheticView view = Look(scene, IdealSensor(), At(0.002 * i));
    const TrackedFrame tracked = Tracked(view, At(0.002 * i));
    Insert(mapper, view, tracked);
    for (const PointId id : tracked.points) {
      if (id == kNoId || map.Find(id) != nullptr) continue;
      ADD_FAILURE() << "point " << id << " of keyframe " << i;
    }
  }
}

TEST_F(LocalMapperTest, LandmarksThatTooFewSeeGoWithARedundantKeyFrame) {
  // Probation is over before any keyframe is redundant.
  LocalMapper mapper(model, {.min_observations = 2}, true, {.probation_keyframes = 1});
  int culled = 0;
  for (int i = 0; i < 8; ++i) {
    const auto report = InsertAt(mapper, 0.03 * i);
    culled += static_cast<int>(report.culled_keyframes.size());
    for (const PointId id : map.ids<MapPoint>()) {
      const auto& seen = map.Find(id)->observations;
      if (seen.size() < 2) {
        EXPECT_EQ(seen.front().keyframe, report.keyframe) << id;
      }
    }
    for (const LineId id : map.ids<MapLine>()) {
      const auto& seen = map.Find(id)->observations;
      if (seen.size() < 2) {
        EXPECT_EQ(seen.front().keyframe, report.keyframe) << id;
      }
    }
  }
  EXPECT_GE(culled, 2);
}

TEST_F(LocalMapperTest, KeyFramesThatSeeNewThingsStay) {
  LocalMapper mapper(model, {});
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(InsertAt(mapper, 0.5 * (i - 2)).culled_keyframes.empty());
  }
}

TEST_F(LocalMapperTest, InTheBackgroundTheMapEqualsThatOfSynchronousModeToTheBit) {
  finish_ = false;
  Eigen::Matrix<double, 6, 1> error;
  error << 0.003, -0.002, 0.002, 0.001, 0.001, -0.001;
  std::vector<Eigen::Matrix4d> poses[2];
  std::vector<Eigen::Vector3d> points[2];
  for (const bool background : {false, true}) {
    map = Map();
    std::fill(point_ids.begin(), point_ids.end(), kNoId);
    std::fill(line_ids.begin(), line_ids.end(), kNoId);
    LocalMapper mapper(model, {}, background);
    for (int i = 0; i < 5; ++i) {
      const SyntheticView view = Look(scene, IdealSensor(), At(0.1 * i), {.px = 0.5});
      Insert(mapper, view, Tracked(view, At(0.1 * i).Plus(error)));
    }
    EXPECT_EQ(mapper.Finish(&map).has_value(), background);
    for (const KeyFrameId id : map.keyframe_ids()) {
      poses[background].push_back(map.keyframe(id)->T_WC.Matrix());
    }
    for (const PointId id : map.ids<MapPoint>()) points[background].push_back(map.Find(id)->p_W);
  }
  EXPECT_EQ(poses[0], poses[1]);
  EXPECT_EQ(points[0], points[1]);
}

TEST_F(LocalMapperTest, InTheBackgroundNothingMovesBeforeTheResultIsApplied) {
  finish_ = false;
  LocalMapper mapper(model, {});
  InsertAt(mapper, 0.0);
  EXPECT_FALSE(mapper.Finish(&map)) << "one keyframe: nothing to adjust";
  Eigen::Matrix<double, 6, 1> error;
  error << 0.003, -0.002, 0.002, 0.001, 0.001, -0.001;
  const Pose wrong = At(0.1).Plus(error);
  const SyntheticView view = Look(scene, IdealSensor(), At(0.1));
  const auto report = Insert(mapper, view, Tracked(view, wrong));
  EXPECT_FALSE(report.bundle.usable);
  while (!mapper.HasResult()) std::this_thread::yield();
  EXPECT_EQ(map.keyframe(1_kf)->T_WC.Matrix(), wrong.Matrix());
  const auto adjusted = mapper.Update(&map);
  ASSERT_TRUE(adjusted);
  EXPECT_TRUE(adjusted->usable);
  EXPECT_LT(PositionError(map.keyframe(1_kf)->T_WC, At(0.1)), 1e-4);
  EXPECT_FALSE(mapper.HasResult());
  EXPECT_FALSE(mapper.Update(&map));
}

TEST_F(LocalMapperTest, DoesNotApplyCancelledWork) {
  LocalMapper mapper(model, {});
  const Pose wrong = InsertWrongly(mapper);
  mapper.Drop();
  EXPECT_FALSE(mapper.HasResult());
  EXPECT_FALSE(mapper.Finish(&map));
  EXPECT_EQ(map.keyframe(1_kf)->T_WC.Matrix(), wrong.Matrix());
}

TEST_F(LocalMapperTest, WithoutWaitingAnAdjustmentEndsEarlyAndIsApplied) {
  finish_ = false;
  const BundleAdjustmentOptions endless{.first_iterations = 100000, .second_iterations = 100000};
  LocalMapper mapper(model, {.wait = false}, true, {.bundle = endless});
  for (int i = 0; i < 4; ++i) {
    const SyntheticView view = Look(scene, IdealSensor(), At(0.1 * i), {.px = 0.5});
    Insert(mapper, view, Tracked(view, At(0.1 * i)));
  }
  EXPECT_TRUE(mapper.Finish(&map)->usable);
  for (const KeyFrameId id : map.keyframe_ids()) {
    EXPECT_LT(PositionError(map.keyframe(id)->T_WC, At(0.1 * id.value())), 0.01) << id;
  }
}

}  // namespace
}  // namespace highwall::local_mapper_test
