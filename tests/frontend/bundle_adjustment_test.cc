#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/local/bundle_adjustment.h>

#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::bundle_adjustment_test {
namespace {

using testing::AngleError;
using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::PositionError;
using testing::Scene;
using testing::SceneMap;
using testing::ViewNoise;
using testing::operator""_kf;

const std::vector<Pose> kTruth{Pose::FromTangent({0, 0, 0}, {0, 0, 0}),
                               Pose::FromTangent({0.3, 0, 0}, {0, -0.05, 0.02}),
                               Pose::FromTangent({0.3, 0.3, 0.1}, {0.05, -0.05, 0}),
                               Pose::FromTangent({-0.2, 0.2, 0.1}, {0.02, 0.05, 0})};

class BundleAdjustment : public ::testing::Test {
 protected:
  explicit BundleAdjustment(int points = 120, int lines = 30)
      : scene(MakeScene(9, points, lines)), scene_map(scene) {
    for (const Pose& T_WC : kTruth) scene_map.Add(Look(scene, IdealSensor(), T_WC), T_WC);
  }

  // Perturbs all keyframes but the first by 2 cm and half a degree, and the landmarks by 2 cm.
  void Perturb() {
    std::mt19937 rng(6);
    const auto step = [&](double size) -> Eigen::Vector3d {
      return testing::UniformInBox(rng, {-size, -size, -size}, {size, size, size});
    };
    for (const KeyFrameId id : rest) {
      Eigen::Matrix<double, 6, 1> d;
      d << step(0.02), step(0.01);
      map.keyframe(id)->T_WC = map.keyframe(id)->T_WC.Plus(d);
    }
    for (const PointId id : map.ids<MapPoint>()) map.Find(id)->p_W += step(0.02);
    for (const LineId id : map.ids<MapLine>()) {
      const Segment3& s = map.Find(id)->segment_W;
      map.Find(id)->segment_W = Segment3(s.p() + step(0.01), s.q() + step(0.01));
    }
  }

  // Keyframe 3 has no landmarks, but its motion from keyframe 2.
  void LeaveOnlyTheWholeImageTo3() {
    KeyFrame& keyframe = *map.keyframe(3_kf);
    keyframe.image_motion = {.reference = 2_kf, .T_reference_C = kTruth[2].Inverse() * kTruth[3]};
    keyframe.image_motion->sqrt_information.setIdentity();
    ForEachKind([&]<class Landmark>() {
      const LandmarkIds<Landmark> ids = PartOf<Landmark>(keyframe);
      for (const Id<Landmark> id : ids) {
        if (id != kNoId) map.Forget(3_kf, id);
      }
    });
  }

  void ExpectPoses(double tolerance) const {
    for (std::size_t i = 0; i < kTruth.size(); ++i) {
      const Pose& T_WC = map.keyframe(static_cast<KeyFrameId>(i))->T_WC;
      EXPECT_LT(PositionError(T_WC, kTruth[i]), tolerance) << i;
      EXPECT_LT(AngleError(T_WC, kTruth[i]), tolerance) << i;
    }
  }

  const MeasurementModel model{IdealSensor(), {}};
  const MeasurementModel on_body{IdealSensor(), {}, Pose::FromTangent({0.1, -0.2, 0}, {0.3, 0, 1})};
  const Scene scene;
  SceneMap scene_map;
  Map& map = scene_map.map;
  // There is no noise: only corrupted observations are outliers, and the solver runs to
  // convergence.
  const BundleAdjustmentOptions thorough{.first_iterations = 20, .second_iterations = 20};
  const std::vector<KeyFrameId> first{0_kf}, rest{1_kf, 2_kf, 3_kf}, all{0_kf, 1_kf, 2_kf, 3_kf};
};

TEST_F(BundleAdjustment, BringsKeyFramesAndLandmarksBackToTheTruth) {
  Perturb();
  const auto report = AdjustBundle(map, model, rest, first, thorough);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.keyframes, 3);
  EXPECT_EQ(report.fixed_keyframes, 1);
  EXPECT_EQ(report.outliers, 0);
  EXPECT_LT(report.final_cost, 1e-6 * report.initial_cost);
  // The float pixels of segments, 3e-5 px, limit the accuracy: 1e-7 m at 3 m.
  ExpectPoses(1e-6);
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    const MapPoint* point = map.Find(scene_map.point_ids[i]);
    if (point == nullptr || point->observations.size() < 2) continue;
    EXPECT_LT((point->p_W - scene.points[i].p_W).norm(), 1e-5);
  }
  for (std::size_t i = 0; i < scene.lines.size(); ++i) {
    const MapLine* line = map.Find(scene_map.line_ids[i]);
    if (line == nullptr || line->observations.back().keyframe == 0_kf) continue;
    // The line is the true one, and its length is true up to the 2 cm by which its ends were moved.
    const Segment3& truth = scene.lines[i].segment_W;
    const PluckerLine true_line = PluckerLine::FromPoints(truth.p(), truth.q());
    EXPECT_LT(true_line.Distance(line->segment_W.p()), 1e-5);
    EXPECT_LT(true_line.Distance(line->segment_W.q()), 1e-5);
    EXPECT_NEAR(line->segment_W.Length(), truth.Length(), 0.05);
  }
}

TEST_F(BundleAdjustment, AKeyFrameWithoutLandmarksIsHeldByItsWholeImage) {
  LeaveOnlyTheWholeImageTo3();
  Perturb();
  ASSERT_TRUE(AdjustBundle(map, on_body, rest, first, thorough).usable);
  // As where landmarks hold all of them: the float pixels of segments.
  ExpectPoses(1e-6);
}

TEST_F(BundleAdjustment, AWholeImageHoldsAfterItsReferenceHasBeenRemoved) {
  LeaveOnlyTheWholeImageTo3();
  map.RemoveKeyFrame(2_kf, 1_kf);
  Eigen::Matrix<double, 6, 1> off;
  off << 0.02, -0.01, 0.02, 0.01, -0.01, 0.005;
  for (const KeyFrameId id : {1_kf, 3_kf}) {
    map.keyframe(id)->T_WC = map.keyframe(id)->T_WC.Plus(off);
  }
  const std::vector<KeyFrameId> left{1_kf, 3_kf};
  ASSERT_TRUE(AdjustBundle(map, on_body, left, first, thorough).usable);
  for (const std::size_t i : {1u, 3u}) {
    EXPECT_LT(PositionError(map.keyframe(KeyFrameId(i))->T_WC, kTruth[i]), 1e-6) << i;
  }
}

TEST_F(BundleAdjustment, APointOfOneKeyFrameMovesWithItAndHoldsNothing) {
  // The first points keep only their observation by keyframe 2.
  Perturb();
  std::vector<std::pair<PointId, Eigen::Vector3d>> points;
  const auto in_2 = [&] { return map.keyframe(2_kf)->T_WC.Inverse(); };
  for (std::size_t i = 0; i < 12; ++i) {
    const PointId id = map.keyframe(2_kf)->points[i];
    if (id == kNoId) continue;
    for (const KeyFrameId other : {0_kf, 1_kf, 3_kf}) map.Forget(other, id);
    points.emplace_back(id, in_2() * map.Find(id)->p_W);
  }
  ASSERT_GT(points.size(), 5u);
  ASSERT_TRUE(AdjustBundle(map, model, rest, first, thorough).usable);
  ExpectPoses(1e-6);
  // Rounding of one transform and its inverse.
  for (const auto& [id, p_C] : points) {
    EXPECT_LT((in_2() * map.Find(id)->p_W - p_C).norm(), 1e-13);
  }
}

TEST_F(BundleAdjustment, AKeyFrameThatSharesNoPointStaysWhereItIs) {
  Perturb();
  for (const KeyFrameId keyframe : {0_kf, 1_kf, 3_kf}) {
    for (const PointId id : map.ids<MapPoint>()) map.Forget(keyframe, id);
    for (const LineId id : map.ids<MapLine>()) map.Forget(keyframe, id);
  }
  for (const LineId id : map.ids<MapLine>()) map.Forget(2_kf, id);
  const Pose before = map.keyframe(2_kf)->T_WC;
  const std::vector<KeyFrameId> free{2_kf};
  const auto report = AdjustBundle(map, model, free, first, thorough);
  EXPECT_TRUE(report.usable) << report.message;
  EXPECT_FALSE(report.moved);
  EXPECT_EQ(map.keyframe(2_kf)->T_WC.Matrix(), before.Matrix());
}

TEST_F(BundleAdjustment, CountsVariablesAndObservations) {
  const auto report = AdjustBundle(map, model, rest, first, thorough);
  int points = 0, lines = 0;
  std::size_t observations = 0;
  for (const PointId id : map.ids<MapPoint>()) {
    if (map.Find(id)->observations.back().keyframe == 0_kf) continue;
    ++points;
    observations += map.Find(id)->observations.size();
  }
  for (const LineId id : map.ids<MapLine>()) {
    if (map.Find(id)->observations.back().keyframe == 0_kf) continue;
    ++lines;
    observations += map.Find(id)->observations.size();
  }
  EXPECT_EQ(report.points, points);
  EXPECT_EQ(report.lines, lines);
  EXPECT_EQ(report.observations, static_cast<int>(observations));
}

TEST_F(BundleAdjustment, HoldsTheOldestWhereNoneIsFixed) {
  Perturb();
  const std::vector<KeyFrameId> unordered{2_kf, 0_kf, 3_kf, 1_kf};
  const auto report = AdjustBundle(map, model, unordered, {}, thorough);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.keyframes, 3);
  EXPECT_EQ(report.fixed_keyframes, 1);
  EXPECT_EQ(map.keyframe(0_kf)->T_WC.Matrix(), kTruth[0].Matrix());
  ExpectPoses(1e-6);
}

TEST_F(BundleAdjustment, DoesNotMoveFixedKeyFramesNorLandmarksOfTheseAlone) {
  Perturb();
  // Two fixed keyframes that contradict each other would make a third of all observations outliers.
  const Pose T1 = map.keyframe(1_kf)->T_WC = kTruth[1];
  std::vector<std::pair<PointId, Eigen::Vector3d>> others;
  for (const PointId id : map.ids<MapPoint>()) {
    const auto& observations = map.Find(id)->observations;
    const bool seen = std::any_of(observations.begin(), observations.end(),
                                  [](const Observation& o) { return o.keyframe == 3_kf; });
    if (!seen) others.emplace_back(id, map.Find(id)->p_W);
  }
  ASSERT_FALSE(others.empty());
  const std::vector<KeyFrameId> free{3_kf}, fixed{0_kf, 1_kf};
  ASSERT_TRUE(AdjustBundle(map, model, free, fixed, thorough).usable);
  EXPECT_EQ(map.keyframe(1_kf)->T_WC.Matrix(), T1.Matrix());
  for (const auto& [id, p_W] : others) EXPECT_EQ(map.Find(id)->p_W, p_W);
}

TEST_F(BundleAdjustment, ForgetsOutlierObservations) {
  // Two features of keyframe 2 see points other than their own, at least 20 px off.
  auto features = std::make_shared<FrameFeatures>(*map.keyframe(2_kf)->frame.features);
  std::vector<PointId> broken;
  for (const std::size_t i : {4u, 9u}) {
    features->points[i].uv += Eigen::Vector2d(25, -30);
    broken.push_back(map.keyframe(2_kf)->points[i]);
    ASSERT_GT(map.Find(broken.back())->observations.size(), 1u);
  }
  // In addition, a line of keyframe 3 is a different edge.
  auto edges = std::make_shared<FrameFeatures>(*map.keyframe(3_kf)->frame.features);
  edges->lines[2].segment.s += Eigen::Vector2f(0, 40);
  edges->lines[2].segment.e += Eigen::Vector2f(40, 0);
  const LineId broken_line = map.keyframe(3_kf)->lines[2];
  ASSERT_GT(map.Find(broken_line)->observations.size(), 1u);
  map.keyframe(2_kf)->frame.features = features;
  map.keyframe(3_kf)->frame.features = edges;
  Perturb();
  const auto report = AdjustBundle(map, model, rest, first, thorough);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.outliers, 3);
  EXPECT_EQ(map.keyframe(2_kf)->points[4], kNoId);
  EXPECT_EQ(map.keyframe(2_kf)->points[9], kNoId);
  EXPECT_EQ(map.keyframe(3_kf)->lines[2], kNoId);
  for (const PointId id : broken) {
    ASSERT_NE(map.Find(id), nullptr);
    for (const Observation& o : map.Find(id)->observations) EXPECT_NE(o.keyframe, 2_kf);
  }
  ASSERT_NE(map.Find(broken_line), nullptr);
  ExpectPoses(1e-6);
}

// Keyframe 2 sees four displaced landmarks: a point and a line with depth, of 3 and 4 rows, and one
// of each without depth, of 2 rows.
class BundleAdjustmentBounds : public BundleAdjustment {
 protected:
  enum Row { kTwoOfPoint, kTwoOfLine, kThree, kFour };

  // Displaces the observations laterally by `sigmas` standard deviations.
  void Break(double sigmas) {
    auto features = std::make_shared<FrameFeatures>(*map.keyframe(2_kf)->frame.features);
    for (const std::size_t i : {kPoint, kPointWithoutDepth}) {
      features->points[i].uv.x() += sigmas * model.PointSigma(features->points[i].octave);
    }
    for (const std::size_t i : {kLine, kLineWithoutDepth}) {
      LineSegment& segment = features->lines[i].segment;
      const Eigen::Vector2f along = (segment.e - segment.s).normalized();
      const Eigen::Vector2f across(-along.y(), along.x());
      // Both ends are displaced equally: the squared error is that of two rows.
      const double each = sigmas / std::sqrt(2.0) * model.options().line_sigma;
      segment.s += static_cast<float>(each) * across;
      segment.e += static_cast<float>(each) * across;
    }
    features->points[kPointWithoutDepth].depth = 0.0;
    features->lines[kLineWithoutDepth].segment_C.reset();
    map.keyframe(2_kf)->frame.features = features;
  }
  // Returns whether keyframe 2 still observes them after the adjustment, in the order of Row.
  std::vector<bool> Kept(const BundleAdjustmentOptions& options) {
    const auto report = AdjustBundle(map, model, rest, first, options);
    EXPECT_TRUE(report.usable);
    const KeyFrame& keyframe = *map.keyframe(2_kf);
    const std::vector<bool> kept{keyframe.points[kPointWithoutDepth] != kNoId,
                                 keyframe.lines[kLineWithoutDepth] != kNoId,
                                 keyframe.points[kPoint] != kNoId, keyframe.lines[kLine] != kNoId};
    EXPECT_EQ(report.outliers, std::count(kept.begin(), kept.end(), false)) << "no other";
    return kept;
  }

  static constexpr std::size_t kPoint = 4, kPointWithoutDepth = 9, kLine = 2, kLineWithoutDepth = 5;
};

TEST_F(BundleAdjustmentBounds, EachIsJudgedByTheBoundOfItsRows) {
  const auto kept = [&](double chi2_2, double chi2_3, double chi2_4) {
    SceneMap copy(scene);
    for (const Pose& T_WC : kTruth) copy.Add(Look(scene, IdealSensor(), T_WC), T_WC);
    std::swap(copy.map, map);
    Break(20.0);
    BundleAdjustmentOptions options = thorough;
    options.inliers.chi2_2 = chi2_2;
    options.inliers.chi2_3 = chi2_3;
    options.inliers.chi2_4 = chi2_4;
    return Kept(options);
  };
  using Flags = std::vector<bool>;
  EXPECT_EQ(kept(10, 10, 10), Flags({false, false, false, false}));
  EXPECT_EQ(kept(1e6, 10, 10), Flags({true, true, false, false}));
  EXPECT_EQ(kept(10, 1e6, 10), Flags({false, false, true, false}));
  EXPECT_EQ(kept(10, 10, 1e6), Flags({false, false, false, true}));
}

TEST_F(BundleAdjustmentBounds, TwoSigmasAreKeptAndEightAreNot) {
  // The other three observations of a landmark leave at least half of the error to the corrupted
  // one: four sigmas, beyond every bound; the bounds of 95 % are 2.4 sigmas and more.
  Break(2.0);
  EXPECT_EQ(Kept(thorough), std::vector<bool>(4, true));
  Break(6.0);
  EXPECT_EQ(Kept(thorough), std::vector<bool>(4, false));
}

TEST_F(BundleAdjustmentBounds, TheErrorThatIsJudgedIsThatOfTheAdjustedMap) {
  Break(4.0);
  BundleAdjustmentOptions options = thorough;
  options.inliers = {.chi2_2 = 1e6, .chi2_3 = 1e6, .chi2_4 = 1e6};
  Kept(options);
  const KeyFrame& keyframe = *map.keyframe(2_kf);
  const PointFeature& feature = keyframe.frame.features->points[kPointWithoutDepth];
  const Eigen::Vector3d p_C =
      keyframe.T_WC.Inverse() * map.Find(keyframe.points[kPointWithoutDepth])->p_W;
  const Eigen::Vector2d error = IdealSensor().camera.Project(p_C) - feature.uv;
  const double squared = error.squaredNorm() / std::pow(model.PointSigma(feature.octave), 2);
  ASSERT_GT(squared, 1.0);
  // The adjustment has converged to a millionth of the cost, and so has the error.
  options.inliers.chi2_2 = 1.001 * squared;
  EXPECT_TRUE(Kept(options)[kTwoOfPoint]);
  options.inliers.chi2_2 = 0.999 * squared;
  EXPECT_FALSE(Kept(options)[kTwoOfPoint]);
}

TEST_F(BundleAdjustment, OfGoodObservationsAboutOneInAHundredIsAnOutlier) {
  const MeasurementModel as_noisy(IdealSensor(), {.point_sigma = 1.0, .line_sigma = 1.0});
  int observations = 0, outliers = 0;
  for (unsigned run = 0; run < 10; ++run) {
    SceneMap noisy(scene);
    for (unsigned i = 0; i < 4; ++i) {
      const ViewNoise noise{.px = 1.0, .depth = true, .seed = 4 * run + i};
      noisy.Add(Look(scene, IdealSensor(), kTruth[i], noise), kTruth[i]);
    }
    const auto report = AdjustBundle(noisy.map, as_noisy, rest, first);
    ASSERT_TRUE(report.usable);
    observations += report.observations;
    outliers += report.outliers;
  }
  ASSERT_GT(observations, 3000);
  const double share = static_cast<double>(outliers) / observations;
  // At the truth 5 % lie beyond the bounds; after the fit, whose landmarks have only four
  // observations, it is one in a hundred. The standard deviation of that share is 0.2 %.
  EXPECT_GT(share, 0.003);
  EXPECT_LT(share, 0.02);
}

TEST_F(BundleAdjustment, ALandmarkBehindTheCameraIsNoInlier) {
  // Outside their domain the factors of the point are inactive: nothing pulls the point back, and
  // no error is reported.
  const PointId behind = map.keyframe(1_kf)->points.front();
  ASSERT_NE(behind, kNoId);
  map.Find(behind)->p_W = Eigen::Vector3d(0, 0, -3);
  ASSERT_TRUE(AdjustBundle(map, model, rest, first, thorough).usable);
  const MapPoint* point = map.Find(behind);
  for (const KeyFrameId id : rest) {
    EXPECT_TRUE(point == nullptr ||
                std::none_of(point->observations.begin(), point->observations.end(),
                             [&](const Observation& o) { return o.keyframe == id; }))
        << id;
  }
}

TEST_F(BundleAdjustment, ALineWithoutLengthLeavesTheMap) {
  const auto seen = [](LineId id) { return id != kNoId; };
  const auto& lines = map.keyframe(1_kf)->lines;
  const LineId id = *std::find_if(lines.begin(), lines.end(), seen);
  const Segment3 whole = map.Find(id)->segment_W;
  map.Find(id)->segment_W = Segment3(whole.p(), whole.p() + 1e-4 * (whole.q() - whole.p()));
  const std::size_t before = map.num<MapLine>();
  ASSERT_TRUE(AdjustBundle(map, model, rest, first, thorough).usable);
  EXPECT_EQ(map.Find(id), nullptr);
  EXPECT_EQ(map.num<MapLine>(), before - 1);
}

TEST_F(BundleAdjustment, FailureLeavesTheMapAlone) {
  Perturb();
  // u = fx x / z overflows: the residual is infinite and the solver fails at the start.
  map.Find(map.keyframe(1_kf)->points[0])->p_W =
      map.keyframe(1_kf)->T_WC * Eigen::Vector3d(1e307, 0, 1e307);
  std::vector<Eigen::Matrix4d> poses;
  for (const KeyFrameId id : all) poses.push_back(map.keyframe(id)->T_WC.Matrix());
  std::vector<Eigen::Vector3d> points;
  for (const PointId id : map.ids<MapPoint>()) points.push_back(map.Find(id)->p_W);
  const auto report = AdjustBundle(map, model, rest, first, thorough);
  EXPECT_FALSE(report.usable);
  std::vector<Eigen::Matrix4d> poses_after;
  for (const KeyFrameId id : all) poses_after.push_back(map.keyframe(id)->T_WC.Matrix());
  std::vector<Eigen::Vector3d> points_after;
  for (const PointId id : map.ids<MapPoint>()) points_after.push_back(map.Find(id)->p_W);
  EXPECT_EQ(poses, poses_after);
  EXPECT_EQ(points, points_after);
}

TEST_F(BundleAdjustment, NothingToMoveIsNothingDone) {
  EXPECT_FALSE(AdjustBundle(map, model, {}, first, thorough).usable);
}

TEST_F(BundleAdjustment, RepeatsBitForBit) {
  Perturb();
  std::vector<Eigen::Matrix4d> poses[2];
  for (auto& result : poses) {
    SceneMap copy(scene);
    for (std::size_t i = 0; i < kTruth.size(); ++i) {
      copy.Add(Look(scene, IdealSensor(), kTruth[i], {.px = 1.0, .depth = true}), kTruth[i]);
    }
    ASSERT_TRUE(AdjustBundle(copy.map, model, all, {}).usable);
    for (const KeyFrameId id : all) result.push_back(copy.map.keyframe(id)->T_WC.Matrix());
  }
  EXPECT_EQ(poses[0], poses[1]);
}

TEST_F(BundleAdjustment, SkipsWhatHasLeftTheMapMeanwhile) {
  Perturb();
  BundleAdjuster adjuster(map, model, rest, first, thorough);
  const PointId point = map.keyframe(1_kf)->points[0];
  const LineId line = map.keyframe(1_kf)->lines[0];
  map.Remove(point);
  map.Remove(line);
  map.RemoveKeyFrame(2_kf, 1_kf);
  const auto gone = map.ids<MapPoint>().size();
  adjuster.Solve();
  const auto report = adjuster.Write(&map);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.keyframes, 3);
  EXPECT_EQ(map.ids<MapPoint>().size(), gone);
  EXPECT_EQ(map.Find(point), nullptr);
  EXPECT_EQ(map.Find(line), nullptr);
  EXPECT_EQ(map.keyframe(2_kf), nullptr);
  for (const KeyFrameId id : {1_kf, 3_kf}) {
    EXPECT_LT(PositionError(map.keyframe(id)->T_WC, kTruth[id.index()]), 1e-6);
  }
}

class BundleAdjustmentWithoutDepth : public BundleAdjustment {
 protected:
  BundleAdjustmentWithoutDepth() : BundleAdjustment(150, 0) {
    for (const KeyFrameId id : all) {
      auto features = std::make_shared<FrameFeatures>(*map.keyframe(id)->frame.features);
      for (PointFeature& feature : features->points) feature.depth = 0.0;
      map.keyframe(id)->frame.features = features;
    }
    // The points are moved along their rays, so far that a Gauss-Newton step leads behind the
    // camera.
    for (const PointId id : map.ids<MapPoint>()) map.Find(id)->p_W *= 2.5;
  }
  int NumObservations() const {
    int count = 0;
    for (const PointId id : map.ids<MapPoint>()) {
      count += static_cast<int>(map.Find(id)->observations.size());
    }
    return count;
  }
};

TEST_F(BundleAdjustmentWithoutDepth, AStepThatLeadsPointsBehindTheCameraIsNoPerfectFit) {
  BundleAdjustmentOptions careless = thorough;
  careless.trust_region = 1e8;
  careless.first_iterations = 50;
  const int observations = NumObservations();
  ASSERT_GT(observations, 300);
  const std::vector<KeyFrameId> held{0_kf, 1_kf}, free{2_kf, 3_kf};
  const auto report = AdjustBundle(map, model, free, held, careless);
  ASSERT_TRUE(report.usable) << report.message;
  // No step need be rejected: the landmarks that it would lead there take a shorter one.
  EXPECT_TRUE(report.moved);
  EXPECT_EQ(report.outliers, 0);
  EXPECT_EQ(NumObservations(), observations);
  for (const KeyFrameId id : free) {
    EXPECT_LT(PositionError(map.keyframe(id)->T_WC, kTruth[id.index()]), 1e-3);
  }
}

TEST_F(BundleAdjustment, OneThatWouldForgetMoreThanAThirdIsRefused) {
  const auto before = map.keyframe(2_kf)->T_WC.Matrix();
  const std::size_t seen = map.Find(map.keyframe(1_kf)->points[0])->observations.size();
  for (const KeyFrameId id : rest) {
    auto features = std::make_shared<FrameFeatures>(*map.keyframe(id)->frame.features);
    for (std::size_t i = 0; i < features->points.size(); ++i) {
      if (i % 2 == 0) features->points[i].uv += Eigen::Vector2d(i % 4 == 0 ? 60.0 : -60.0, 30.0);
    }
    for (LineFeature& line : features->lines)
      line.segment.s.y() += 40.0F, line.segment.e.x() += 40.0F;
    map.keyframe(id)->frame.features = features;
  }
  const auto report = AdjustBundle(map, model, rest, first, thorough);
  EXPECT_FALSE(report.usable);
  EXPECT_TRUE(report.refused);
  EXPECT_NE(report.message.find("more than a third"), std::string::npos) << report.message;
  EXPECT_EQ(map.keyframe(2_kf)->T_WC.Matrix(), before);
  EXPECT_EQ(map.Find(map.keyframe(1_kf)->points[0])->observations.size(), seen);
}

TEST_F(BundleAdjustment, SolvingAloneMovesNothing) {
  Perturb();
  const Eigen::Matrix4d before = map.keyframe(1_kf)->T_WC.Matrix();
  BundleAdjuster adjuster(map, model, rest, first, thorough);
  adjuster.Solve();
  EXPECT_EQ(map.keyframe(1_kf)->T_WC.Matrix(), before);
  EXPECT_TRUE(adjuster.Write(&map).usable);
  EXPECT_NE(map.keyframe(1_kf)->T_WC.Matrix(), before);
}

TEST_F(BundleAdjustment, StopsOnRequestWithTheStateReached) {
  Perturb();
  std::stop_source stop;
  stop.request_stop();
  const auto report = AdjustBundle(map, model, rest, first, thorough, stop.get_token());
  ASSERT_TRUE(report.usable);
  EXPECT_GT(report.final_cost, 1e-3 * report.initial_cost) << "to the end it falls a millionfold";
}

TEST_F(BundleAdjustment, StoppedAtTheStartItThrowsNoObservationOut) {
  // A displacement of 1 cm along each axis is 2.5 px at 3 m: far more than the corners' noise, and
  // none of it is an outlier.
  for (const KeyFrameId id : rest) {
    Eigen::Matrix<double, 6, 1> d = Eigen::Matrix<double, 6, 1>::Zero();
    d[0] = d[1] = id.value() % 2 == 0 ? 0.01 : -0.01;
    map.keyframe(id)->T_WC = map.keyframe(id)->T_WC.Plus(d);
  }
  std::stop_source stop;
  stop.request_stop();
  BundleAdjuster adjuster(map, model, rest, first, thorough);
  adjuster.Solve(stop.get_token());
  EXPECT_TRUE(adjuster.outliers().points.empty());
  EXPECT_TRUE(adjuster.outliers().lines.empty());
  const auto report = adjuster.Write(&map);
  EXPECT_TRUE(report.usable);
  EXPECT_FALSE(report.moved);
  EXPECT_EQ(report.outliers, 0);
  EXPECT_GT(report.observations, 300);
}

class BundleAdjustmentOfLines : public BundleAdjustment {
 protected:
  BundleAdjustmentOfLines() : BundleAdjustment(0, 60) {}
};

TEST_F(BundleAdjustmentOfLines, NeedsNoPoints) {
  Perturb();
  const auto report = AdjustBundle(map, model, rest, first, thorough);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.points, 0);
  EXPECT_EQ(report.outliers, 0);
  ExpectPoses(1e-6);
}

}  // namespace
}  // namespace highwall::bundle_adjustment_test
