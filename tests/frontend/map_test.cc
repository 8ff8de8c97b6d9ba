#include <highwall/frontend/map/map.h>

#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/error.h>
#include <highwall/factors/imu_preintegration.h>

#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::map_test {
namespace {

using testing::operator""_kf;

BinaryDescriptor256 FirstBits(int count) {
  BinaryDescriptor256 descriptor{};
  for (int i = 0; i < count; ++i) {
    descriptor[static_cast<std::size_t>(i / 8)] |= static_cast<std::uint8_t>(1 << (i % 8));
  }
  return descriptor;
}

// Returns a frame with the given descriptors and octaves of its points and a number of plain lines.
Frame MakeFrame(const std::vector<BinaryDescriptor256>& descriptors, int lines = 0,
                const std::vector<int>& octaves = {}) {
  auto features = std::make_shared<FrameFeatures>();
  features->points.resize(descriptors.size());
  for (std::size_t i = 0; i < octaves.size(); ++i) features->points[i].octave = octaves[i];
  for (const auto& d : descriptors) testing::AppendDescriptor(features->point_descriptors, d);
  features->lines.resize(static_cast<std::size_t>(lines));
  return {.index = 0, .stamp = 0, .features = features};
}

Frame FrameOf(int points, int lines = 0) {
  return MakeFrame(std::vector<BinaryDescriptor256>(static_cast<std::size_t>(points)), lines);
}

Pose At(double x, double y, double z) {
  return Pose(Eigen::Quaterniond::Identity(), {x, y, z});
}

TEST(Map, GivesAscendingIdsThatAreNeverUsedAgain) {
  Map map;
  const KeyFrameId k0 = map.AddKeyFrame(FrameOf(1, 1), Pose()).id;
  const KeyFrameId k1 = map.AddKeyFrame(FrameOf(1, 1), Pose()).id;
  const PointId p0 = map.Add<MapPoint>({0, 0, 1}, 7).id;
  const LineId l0 = map.Add<MapLine>(Segment3(), 7).id;
  map.Remove(p0);
  map.Remove(l0);
  map.RemoveKeyFrame(k0, k1);
  EXPECT_GT(map.AddKeyFrame(FrameOf(1), Pose()).id, k1);
  EXPECT_GT(map.Add<MapPoint>({0, 0, 1}, 8).id, p0);
  EXPECT_GT(map.Add<MapLine>(Segment3(), 8).id, l0);
  EXPECT_EQ(map.Find(p0), nullptr);
  EXPECT_EQ(map.Find(l0), nullptr);
  EXPECT_EQ(map.keyframe(k0), nullptr);
  EXPECT_EQ(map.num_keyframes(), 2u);
  EXPECT_EQ(map.num<MapPoint>(), 1u);
  EXPECT_EQ(map.num<MapLine>(), 1u);
  EXPECT_EQ(map.keyframe_ids(), (std::vector<KeyFrameId>{1_kf, 2_kf}));
  EXPECT_EQ(map.ids<MapPoint>(), std::vector<PointId>{PointId(1)});
  EXPECT_EQ(map.ids<MapLine>(), std::vector<LineId>{LineId(1)});
}

TEST(Map, AnswersNothingForIdsItNeverGave) {
  const Map map;
  for (const int id : {-1, 0, 5}) {
    EXPECT_EQ(map.keyframe(KeyFrameId(id)), nullptr);
    EXPECT_EQ(map.Find(PointId(id)), nullptr);
    EXPECT_EQ(map.Find(LineId(id)), nullptr);
  }
  EXPECT_THROW(map.ResolvePose(0_kf), InvalidArgument);
  EXPECT_THROW(map.ResolvePose(kNoId), InvalidArgument);
}

TEST(Map, KeepsAnObservationOnBothSides) {
  Map map;
  const KeyFrameId k = map.AddKeyFrame(FrameOf(3, 2), Pose()).id;
  const PointId p = map.Add<MapPoint>({0, 0, 1}, 0).id;
  const LineId l = map.Add<MapLine>(Segment3(), 0).id;
  EXPECT_TRUE(map.Observe(k, 2, p));
  EXPECT_TRUE(map.Observe(k, 1, l));
  EXPECT_EQ(map.keyframe(k)->points, (std::vector<PointId>{kNoId, kNoId, p}));
  EXPECT_EQ(map.keyframe(k)->lines, (std::vector<LineId>{kNoId, l}));
  ASSERT_EQ(map.Find(p)->observations.size(), 1u);
  EXPECT_EQ(map.Find(p)->observations[0].keyframe, k);
  EXPECT_EQ(map.Find(p)->observations[0].index, 2);
  ASSERT_EQ(map.Find(l)->observations.size(), 1u);
  EXPECT_EQ(map.Find(l)->observations[0].index, 1);
}

TEST(Map, RefusesASecondObservationAndATakenFeature) {
  Map map;
  const KeyFrameId k = map.AddKeyFrame(FrameOf(2), Pose()).id;
  const PointId p = map.Add<MapPoint>({0, 0, 1}, 0).id, q = map.Add<MapPoint>({0, 0, 2}, 0).id;
  EXPECT_TRUE(map.Observe(k, 0, p));
  EXPECT_FALSE(map.Observe(k, 1, p)) << "seen already";
  EXPECT_FALSE(map.Observe(k, 0, q)) << "taken";
  EXPECT_FALSE(map.Observe(k, 1, PointId(kNoId)));
  EXPECT_FALSE(map.Observe(9_kf, 1, q));
  EXPECT_EQ(map.keyframe(k)->points, (std::vector<PointId>{p, kNoId}));
  EXPECT_TRUE(map.Find(q)->observations.empty());
}

TEST(Map, RemovesALandmarkWithItsLastObservation) {
  Map map;
  const KeyFrameId k0 = map.AddKeyFrame(FrameOf(1, 1), Pose()).id;
  const KeyFrameId k1 = map.AddKeyFrame(FrameOf(1, 1), Pose()).id;
  const PointId p = map.Add<MapPoint>({0, 0, 1}, 0).id;
  const LineId l = map.Add<MapLine>(Segment3(), 0).id;
  for (const KeyFrameId k : {k0, k1}) {
    map.Observe(k, 0, p);
    map.Observe(k, 0, l);
  }
  map.Forget(k0, p);
  map.Forget(k0, l);
  EXPECT_NE(map.Find(p), nullptr);
  EXPECT_EQ(map.keyframe(k0)->points[0], kNoId);
  EXPECT_EQ(map.keyframe(k1)->points[0], p);
  map.Forget(k0, p);  // not observed there: nothing to forget
  EXPECT_NE(map.Find(p), nullptr);
  map.Forget(9_kf, p);  // no such keyframe, no such landmark
  map.Forget(9_kf, l);
  map.Forget(k1, PointId(9));
  map.Forget(k1, LineId(9));
  EXPECT_EQ(map.Find(l)->observations.size(), 1u);
  map.Forget(k1, p);
  map.Forget(k1, l);
  EXPECT_EQ(map.Find(p), nullptr);
  EXPECT_EQ(map.Find(l), nullptr);
  EXPECT_EQ(map.keyframe(k1)->points[0], kNoId);
  EXPECT_EQ(map.keyframe(k1)->lines[0], kNoId);
  EXPECT_EQ(map.num<MapPoint>(), 0u);
  EXPECT_EQ(map.num<MapLine>(), 0u);
}

TEST(Map, MergesObservationsAndCountsInTheOrderOfKeyFrames) {
  Map map;
  for (int i = 0; i < 4; ++i) map.AddKeyFrame(FrameOf(2), Pose());
  const PointId from = map.Add<MapPoint>({0, 0, 1}, 0).id,
                into = map.Add<MapPoint>({0, 0, 1.01}, 0).id;
  map.Observe(0_kf, 0, from);
  map.Observe(1_kf, 0, from);
  map.Observe(2_kf, 0, from);
  map.Observe(1_kf, 1, into);
  map.Observe(3_kf, 1, into);
  map.Find(from)->visible = 5;
  map.Find(from)->found = 3;
  map.Merge(from, into);
  EXPECT_EQ(map.Find(from), nullptr);
  const MapPoint& point = *map.Find(into);
  EXPECT_EQ(point.visible, 6);
  EXPECT_EQ(point.found, 4);
  ASSERT_EQ(point.observations.size(), 4u);
  const int features[4] = {0, 1, 0, 1};  // keyframe 1 keeps its own observation of `into`
  for (int i = 0; i < 4; ++i) {
    const Observation& o = point.observations[static_cast<std::size_t>(i)];
    EXPECT_EQ(o.keyframe, KeyFrameId(i));
    EXPECT_EQ(o.index, features[i]);
    EXPECT_EQ(map.keyframe(o.keyframe)->points[static_cast<std::size_t>(o.index)], into);
  }
  EXPECT_EQ(map.keyframe(1_kf)->points[0], kNoId);
}

TEST(Map, MergesLinesAsItDoesPoints) {
  Map map;
  for (int i = 0; i < 3; ++i) map.AddKeyFrame(FrameOf(0, 2), Pose());
  const Segment3 segment({0, 0, 1}, {1, 0, 1});
  const LineId from = map.Add<MapLine>(segment, 0).id, into = map.Add<MapLine>(segment, 0).id;
  map.Observe(0_kf, 0, from);
  map.Observe(1_kf, 0, from);
  map.Observe(1_kf, 1, into);
  map.Observe(2_kf, 1, into);
  map.Merge(from, into);
  map.Merge(from, into);
  map.Merge(into, into);
  EXPECT_EQ(map.Find(from), nullptr);
  ASSERT_NE(map.Find(into), nullptr);
  EXPECT_EQ(map.Find(into)->observations.size(), 3u);
  EXPECT_EQ(map.Find(into)->found, 2);
  EXPECT_EQ(map.keyframe(0_kf)->lines[0], into);
  EXPECT_EQ(map.keyframe(1_kf)->lines[0], kNoId) << "it has its own observation of `into`";
}

TEST(Map, MergingWithItselfOrNothingChangesNothing) {
  Map map;
  map.AddKeyFrame(FrameOf(1), Pose());
  const PointId p = map.Add<MapPoint>({0, 0, 1}, 0).id;
  map.Observe(0_kf, 0, p);
  map.Merge(p, p);
  map.Merge(p, PointId(17));
  map.Merge(PointId(17), p);
  ASSERT_NE(map.Find(p), nullptr);
  EXPECT_EQ(map.Find(p)->observations.size(), 1u);
  EXPECT_EQ(map.Find(p)->visible, 1);
}

TEST(Map, RemovedKeyFrameTakesItsObservationsAlong) {
  Map map;
  map.AddKeyFrame(FrameOf(2, 1), Pose());
  map.AddKeyFrame(FrameOf(2, 1), Pose());
  const PointId shared = map.Add<MapPoint>({0, 0, 1}, 0).id,
                alone = map.Add<MapPoint>({0, 0, 1}, 0).id;
  const LineId line = map.Add<MapLine>(Segment3(), 0).id;
  map.Observe(0_kf, 0, shared);
  map.Observe(1_kf, 0, shared);
  map.Observe(0_kf, 1, alone);
  map.Observe(0_kf, 0, line);
  map.RemoveKeyFrame(0_kf, 1_kf);
  ASSERT_NE(map.Find(shared), nullptr);
  EXPECT_EQ(map.Find(shared)->observations.size(), 1u);
  EXPECT_EQ(map.Find(alone), nullptr);
  EXPECT_EQ(map.Find(line), nullptr);
}

TEST(Map, KeyFrameIsRemovedOnlyForAnotherLiveOne) {
  Map map;
  for (int i = 0; i < 3; ++i) map.AddKeyFrame(FrameOf(0), Pose());
  map.RemoveKeyFrame(0_kf, 1_kf);
  EXPECT_THROW(map.RemoveKeyFrame(1_kf, 1_kf), InvalidArgument);
  EXPECT_THROW(map.RemoveKeyFrame(1_kf, 0_kf), InvalidArgument);
  EXPECT_THROW(map.RemoveKeyFrame(1_kf, kNoId), InvalidArgument);
  map.RemoveKeyFrame(0_kf, 2_kf);  // already removed
  EXPECT_EQ(map.num_keyframes(), 2u);
}

TEST(Map, ResolvesThePoseThroughAChainOfRemovals) {
  Map map;
  const Pose T0 = Pose::FromTangent({0, 0, 0}, {0.1, 0.2, 0.3});
  const Pose T1 = Pose::FromTangent({1, 0, 0}, {-0.3, 0.1, 0.2});
  const Pose T2 = Pose::FromTangent({2, 1, 0}, {0.2, -0.5, 0.4});
  for (const Pose& T : {T0, T1, T2}) map.AddKeyFrame(FrameOf(0), T);
  map.RemoveKeyFrame(0_kf, 1_kf);
  // Its parent moves before it is removed itself, and so does the last one of the chain.
  const Pose M1 = Pose::FromTangent({0.1, 0.3, -0.2}, {0.4, 0, 0.1});
  map.keyframe(1_kf)->T_WC = M1;
  map.RemoveKeyFrame(1_kf, 2_kf);
  const Pose M2 = Pose::FromTangent({5, 0, 1}, {0, 0.3, 0});
  map.keyframe(2_kf)->T_WC = M2;
  const Pose expected1 = M2 * (T2.Inverse() * M1);
  const Pose expected0 = expected1 * (T1.Inverse() * T0);
  // A few products of rigid transforms.
  EXPECT_TRUE(map.ResolvePose(2_kf).Matrix().isApprox(M2.Matrix(), 1e-15));
  EXPECT_TRUE(map.ResolvePose(1_kf).Matrix().isApprox(expected1.Matrix(), 1e-14));
  EXPECT_TRUE(map.ResolvePose(0_kf).Matrix().isApprox(expected0.Matrix(), 1e-14));
}

TEST(Map, RefreshTakesTheMostCentralDescriptor) {
  Map map;
  const int bits[3] = {0, 10, 100};  // median distances, own one included: 10, 10, 90
  for (const int b : bits) map.AddKeyFrame(MakeFrame({FirstBits(b)}), Pose());
  const PointId p = map.Add<MapPoint>({0, 0, 2}, 0).id;
  map.Observe(1_kf, 0, p);
  map.RefreshPoint(p, {});
  EXPECT_EQ(map.Find(p)->descriptor, FirstBits(10)) << "the only one";
  map.Observe(0_kf, 0, p);
  map.Observe(2_kf, 0, p);
  map.AddKeyFrame(MakeFrame({FirstBits(12)}), Pose());
  map.Observe(3_kf, 0, p);
  map.RefreshPoint(p, {});
  // {0, 10, 100, 12}: lower medians 10 (0), 2 (10), 88 (100), 2 (12); the first of equals.
  EXPECT_EQ(map.Find(p)->descriptor, FirstBits(10));
}

TEST(Map, RefreshTakesNormalAndScaleRange) {
  Map map;
  map.AddKeyFrame(MakeFrame({FirstBits(0)}, 0, {0}), At(-2, 0, 0));
  map.AddKeyFrame(MakeFrame({FirstBits(0)}, 0, {3}), At(2, 0, 0));
  const PointId p = map.Add<MapPoint>({0, 0, 2}, 0).id;
  // The newest keyframe comes first: it remains the relevant one.
  map.Observe(1_kf, 0, p);
  map.Observe(0_kf, 0, p);
  map.RefreshPoint(p, {});
  const MapPoint& point = *map.Find(p);
  EXPECT_TRUE(point.normal_W.isApprox(Eigen::Vector3d::UnitZ(), 1e-15));
  const double distance = 2.0 * std::numbers::sqrt2;
  EXPECT_DOUBLE_EQ(point.max_distance, distance * 1.2 * 1.2 * 1.2);
  EXPECT_NEAR(point.min_distance, distance / std::pow(1.2, 4), 1e-14);
}

// Keyframes one second apart, each with an IMU factor to the previous one by the readings in
// between.
std::vector<ImuSample> MapReadings(int begin, int end) {
  std::vector<ImuSample> samples;
  for (int i = 10 * begin; i <= 10 * end; ++i) {
    samples.push_back({Stamp{i} * 100'000'000, {0.1 * i, 0, 0}, {0, 0, 9.81 + i}});
  }
  return samples;
}

Map ImuConstrainedMap(int keyframes) {
  Map map;
  for (int k = 0; k < keyframes; ++k) {
    KeyFrame& keyframe = map.AddKeyFrame(FrameOf(1), At(k, 0, 0));
    InertialState motion;
    motion.stamp = Stamp{k} * 1'000'000'000;
    motion.v_WB = {1, 0.1 * k, 0};
    if (k > 0) {
      motion.previous = KeyFrameId(k - 1);
      motion.from_previous =
          std::make_shared<const ImuPreintegration>(MapReadings(k - 1, k), ImuBias::Zero());
    }
    keyframe.motion = motion;
  }
  return map;
}

TEST(Map, SuccessorIsTheKeyFrameWhoseMotionFollows) {
  Map map = ImuConstrainedMap(3);
  ASSERT_NE(map.Successor(0_kf), nullptr);
  EXPECT_EQ(map.Successor(0_kf)->id, 1_kf);
  EXPECT_EQ(map.Successor(1_kf)->id, 2_kf);
  EXPECT_EQ(map.Successor(2_kf), nullptr) << "the last one";
  EXPECT_EQ(map.Successor(kNoId), nullptr);
  map.keyframe(1_kf)->motion->previous = kNoId;
  map.keyframe(1_kf)->motion->from_previous = nullptr;
  EXPECT_EQ(map.Successor(0_kf), nullptr) << "readings were missing";
  map.keyframe(2_kf)->motion.reset();
  EXPECT_EQ(map.Successor(1_kf), nullptr) << "without an IMU";
}

TEST(Map, RemovingAKeyFrameJoinsTheReadingsOnBothSides) {
  Map map = ImuConstrainedMap(4);
  map.keyframe(1_kf)->motion->weight = 0.3;
  map.keyframe(2_kf)->motion->weight = 0.5;
  map.RemoveKeyFrame(1_kf, 0_kf);
  map.RemoveKeyFrame(2_kf, 3_kf);
  const InertialState& motion = *map.keyframe(3_kf)->motion;
  EXPECT_EQ(motion.previous, 0_kf);
  EXPECT_EQ(map.Successor(0_kf)->id, 3_kf);
  EXPECT_NEAR(motion.weight, (0.3 + 0.5 + 1.0) / 3.0, 1e-12) << "a second each";
  ASSERT_NE(motion.from_previous, nullptr);
  const ImuPreintegration whole(MapReadings(0, 3), ImuBias::Zero());
  EXPECT_EQ(motion.from_previous->start(), whole.start());
  EXPECT_EQ(motion.from_previous->end(), motion.stamp);
  EXPECT_EQ(motion.from_previous->samples().size(), whole.samples().size());
  EXPECT_TRUE(motion.from_previous->delta().p.isApprox(whole.delta().p, 1e-13));
  EXPECT_TRUE(motion.from_previous->covariance().isApprox(whole.covariance(), 1e-13));
}

TEST(Map, RemovingTheFirstOfAChainUnties) {
  Map map = ImuConstrainedMap(3);
  map.RemoveKeyFrame(0_kf, 1_kf);
  EXPECT_EQ(map.keyframe(1_kf)->motion->previous, kNoId);
  EXPECT_EQ(map.keyframe(1_kf)->motion->from_previous, nullptr);
  EXPECT_EQ(map.Successor(1_kf)->id, 2_kf) << "the others stay";
  map.RemoveKeyFrame(2_kf, 1_kf);
  EXPECT_EQ(map.Successor(1_kf), nullptr);
}

TEST(Map, TransformMovesEverything) {
  Map map = ImuConstrainedMap(3);
  map.RemoveKeyFrame(1_kf, 0_kf);
  const PointId p = map.Add<MapPoint>({1, 2, 3}, 0).id;
  map.Find(p)->normal_W = {0, 0.6, 0.8};
  const Segment3 segment({1, 0, 0}, {0, 1, 2});
  const LineId l = map.Add<MapLine>(segment, 0).id;
  map.SetGravity(Eigen::Vector3d(0.1, 0, -9.8));
  const InertialState before = *map.keyframe(2_kf)->motion;
  const Pose T = Pose::FromTangent({0.5, -1, 2}, {0.3, -0.7, 1.1});
  map.Transform(T);
  // Each pose is a few products.
  const auto is_at = [&](KeyFrameId id, const Pose& before_T) {
    return map.ResolvePose(id).Matrix().isApprox((T * before_T).Matrix(), 1e-14);
  };
  EXPECT_TRUE(is_at(0_kf, At(0, 0, 0)));
  EXPECT_TRUE(is_at(1_kf, At(1, 0, 0))) << "one that was removed, through its parent";
  EXPECT_TRUE(is_at(2_kf, At(2, 0, 0)));
  EXPECT_TRUE(map.Find(p)->p_W.isApprox(T * Eigen::Vector3d(1, 2, 3), 1e-14));
  EXPECT_TRUE(map.Find(p)->normal_W.isApprox(T.q() * Eigen::Vector3d(0, 0.6, 0.8), 1e-14));
  EXPECT_TRUE(map.Find(l)->segment_W.p().isApprox(T * segment.p(), 1e-14));
  EXPECT_TRUE(map.Find(l)->segment_W.q().isApprox(T * segment.q(), 1e-14));
  EXPECT_TRUE(map.gravity_W()->isApprox(T.q() * Eigen::Vector3d(0.1, 0, -9.8), 1e-14));
  const InertialState& after = *map.keyframe(2_kf)->motion;
  EXPECT_TRUE(after.v_WB.isApprox(T.q() * before.v_WB, 1e-14));
  EXPECT_EQ(after.from_previous, before.from_previous) << "of the body's own frame";
  EXPECT_EQ(after.bias, before.bias);
}

TEST(Map, OrdersObserversByCountThenId) {
  Map map;
  for (int i = 0; i < 4; ++i) map.AddKeyFrame(FrameOf(3, 1), Pose());
  std::vector<PointId> points;
  for (int i = 0; i < 3; ++i) points.push_back(map.Add<MapPoint>({0, 0, 1}, 0).id);
  const LineId line = map.Add<MapLine>(Segment3(), 0).id;
  for (int i = 0; i < 3; ++i) map.Observe(2_kf, i, points[static_cast<std::size_t>(i)]);
  map.Observe(1_kf, 0, points[0]);
  map.Observe(0_kf, 1, points[1]);
  map.Observe(0_kf, 0, line);
  map.Observe(1_kf, 0, line);
  using Counts = std::vector<std::pair<KeyFrameId, int>>;
  EXPECT_EQ(map.Observers(PerKind<LandmarkIds>{points, {}}),
            (Counts{{2_kf, 3}, {0_kf, 1}, {1_kf, 1}}));
  const std::vector<LineId> lines = {line, kNoId};
  EXPECT_EQ(map.Observers(PerKind<LandmarkIds>{points, lines}),
            (Counts{{2_kf, 3}, {0_kf, 2}, {1_kf, 2}}));
  EXPECT_EQ(map.Covisible(0_kf, 1), (Counts{{1_kf, 1}, {2_kf, 1}}));
  EXPECT_EQ(map.Covisible(0_kf, 2), Counts{});
  EXPECT_EQ(map.Covisible(3_kf, 1), Counts{});
  EXPECT_EQ(map.Covisible(9_kf, 1), Counts{});
}

}  // namespace
}  // namespace highwall::map_test
