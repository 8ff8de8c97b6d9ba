#include "calibration/depth_distortion_estimator.h"

#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/local/bundle_adjustment.h>

#include "features/corrected_depth.h"
#include "support/synthetic_scene.h"

namespace highwall::depth_distortion_estimator_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::Scene;
using testing::SceneMap;
using testing::UniformInBox;

const BundleAdjustmentOptions kBundle{};
constexpr int kSynchronous = 0;

// Returns a pattern by which depth reads too short on the left of the image, and too long on the
// right.
DepthPattern Tilted() {
  DepthPattern pattern;
  for (int node = 0; node < DepthPattern::kNodes; ++node) {
    pattern.nodes[node] = 0.005 * (2 - node % DepthPattern::kColumns);
  }
  return pattern;
}

// A walk among points on all sides whose depth is off by `pattern`, as keyframes of a map: the
// camera is off by at most 5 mm and 1 mrad along each axis.
class Walk {
 public:
  explicit Walk(const DepthPattern& pattern, int keyframes = 16)
      : scene_(testing::MakeSurroundings()) {
    std::mt19937 rng(3);
    SceneMap scene_map(scene_);
    for (int i = 0; i < keyframes; ++i) {
      const double s = i / 15.0 - 0.5;
      const Pose T_WC = Pose::FromTangent(
          {0.8 * std::sin(9.0 * s), 0.5 * std::cos(7.0 * s), 0.6 * std::sin(5.0 * s)},
          {0.8 * std::sin(11.0 * s), 0.8 * std::sin(7.0 * s), 0.8 * std::cos(5.0 * s)});
      auto view = Look(scene_, IdealSensor(), T_WC,
                       {.px = model.PointSigma(0), .depth = true, .seed = 7U + i});
      auto features = std::make_shared<FrameFeatures>(*view.features);
      for (PointFeature& feature : features->points) {
        const double here = pattern.At(feature.uv.x(), feature.uv.y(), camera.width, camera.height);
        feature.depth /= 1.0 + here * feature.depth;
      }
      view.features = features;
      Eigen::Matrix<double, 6, 1> d;
      const Eigen::Vector3d p = UniformInBox(rng, {-5e-3, -5e-3, -5e-3}, {5e-3, 5e-3, 5e-3});
      const Eigen::Vector3d q = UniformInBox(rng, {-1e-3, -1e-3, -1e-3}, {1e-3, 1e-3, 1e-3});
      d << p, q;
      truth_.push_back(T_WC);
      scene_map.Add(view, i == 0 ? T_WC : T_WC.Plus(d));
    }
    map = std::move(scene_map.map);
  }

  // Returns the RMS position error of the keyframes [m].
  double Error() const {
    double sum = 0.0;
    std::size_t i = 0;
    for (const KeyFrameId id : map.keyframe_ids()) {
      sum += (map.keyframe(id)->T_WC.p() - truth_[i++].p()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(truth_.size()));
  }

  const PinholeCamera camera = IdealSensor().camera;
  const MeasurementModel model{IdealSensor(), {}};
  Map map;

 private:
  Scene scene_;
  std::vector<Pose> truth_;
};

TEST(CorrectedDepth, TakesThePatternOffDepthAndEndsAtTheirPixelsOfTheImageAsItIsStored) {
  PinholeCamera camera = IdealSensor().camera;
  camera.k1 = -0.2;  // at the edge distortion moves a pixel far
  const PinholeCamera undistorted = camera.WithoutDistortion();
  const DepthPattern pattern = Tilted();
  const auto off = [&](const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d raw = camera.Project(p_C);
    return pattern.At(raw.x(), raw.y(), camera.width, camera.height);
  };
  const Eigen::Vector3d p(0.9, 0.4, 2.0), q(-0.8, 0.1, 3.0);
  EXPECT_GT((camera.Project(p) - undistorted.Project(p)).norm(), 5.0);
  FrameFeatures features;
  features.points.resize(2);
  features.points[0].uv = undistorted.Project(p);
  features.points[0].depth = 1.0 / (1.0 / p.z() + off(p));
  features.points[1].uv = undistorted.Project(q);  // without depth
  features.lines.resize(2);
  features.lines[0].segment_C.emplace();
  features.lines[0].segment_C->p_C = p / (1.0 + p.z() * off(p));
  features.lines[0].segment_C->q_C = q / (1.0 + q.z() * off(q));
  const auto corrected = CorrectedDepth(features, camera, pattern);
  EXPECT_NEAR(corrected->points[0].depth, p.z(), 1e-12);
  EXPECT_EQ(corrected->points[1].depth, 0.0);
  EXPECT_LT((corrected->lines[0].segment_C->p_C - p).norm(), 1e-12);
  EXPECT_LT((corrected->lines[0].segment_C->q_C - q).norm(), 1e-12);
  EXPECT_FALSE(corrected->lines[1].segment_C);
}

TEST(DepthDistortionEstimator, FindsThePatternAndCorrectsTheMap) {
  const DepthPattern truth = Tilted();
  // Reports of an adjustment where depth is correct, and where it is distorted.
  Walk right(DepthPattern{}), bent(truth);
  for (Walk* walk : {&right, &bent}) {
    AdjustBundle(walk->map, walk->model, walk->map.KeyFramesOf(kFirstSubmap), {}, kBundle);
  }
  EXPECT_GT(bent.Error(), 2.0 * right.Error());
  for (const bool background : {false, true}) {
    SCOPED_TRACE(background);
    Walk walk(truth);
    const KeyFrameId fourth = walk.map.keyframe_ids()[3];
    const double before = walk.map.keyframe(fourth)->frame.features->points[0].depth;
    DepthDistortionEstimator finder(walk.camera, {}, kBundle, background ? 1 : kSynchronous);
    EXPECT_TRUE(finder.pattern().IsZero());
    finder.Begin(walk.map, walk.model, kFirstSubmap, kNoId);
    ASSERT_TRUE(finder.Finish(&walk.map));
    EXPECT_FALSE(finder.HasResult());
    EXPECT_LT(DepthPattern{finder.pattern().nodes - truth.nodes}.Rms(), 0.2 * truth.Rms());
    EXPECT_LT(walk.Error(), 1.2 * right.Error());
    const PointFeature& feature = walk.map.keyframe(fourth)->frame.features->points[0];
    const double here =
        finder.pattern().At(feature.uv.x(), feature.uv.y(), walk.camera.width, walk.camera.height);
    EXPECT_NEAR(1.0 / feature.depth, 1.0 / before - here, 1e-9);
  }
}

TEST(DepthDistortionEstimator, LeavesAMapWhoseDepthIsRightAsItIs) {
  Walk walk(DepthPattern{});
  const double error = walk.Error();
  DepthDistortionEstimator finder(walk.camera, {}, kBundle, kSynchronous);
  finder.Begin(walk.map, walk.model, kFirstSubmap, kNoId);
  EXPECT_FALSE(finder.HasResult());
  EXPECT_FALSE(finder.Finish(&walk.map));
  EXPECT_TRUE(finder.pattern().IsZero());
  EXPECT_EQ(walk.Error(), error);
}

TEST(DepthDistortionEstimator, WaitsForKeyframesOfItsOwnRunAndForMoreOfThemTheNextTime) {
  Walk walk(Tilted());
  DepthDistortionEstimator finder(walk.camera, {}, kBundle, kSynchronous);
  const KeyFrameId fifth = walk.map.keyframe_ids()[4];
  finder.Begin(walk.map, walk.model, kFirstSubmap, fifth);  // eleven keyframes remain
  EXPECT_FALSE(finder.HasResult());
  finder.Begin(walk.map, walk.model, kFirstSubmap, kNoId);
  EXPECT_TRUE(finder.Finish(&walk.map));
  finder.Begin(walk.map, walk.model, kFirstSubmap, kNoId);  // no more keyframes than before
  EXPECT_FALSE(finder.HasResult());

  DepthDistortionEstimator off(walk.camera, {.enabled = false}, kBundle, kSynchronous);
  off.Begin(walk.map, walk.model, kFirstSubmap, kNoId);
  EXPECT_FALSE(off.HasResult());
}

TEST(DepthDistortionEstimator, MoreKeyframesReduceTheUncertaintyOfThePattern) {
  const DepthPattern truth = Tilted();
  Walk first(truth, 12);
  DepthDistortionEstimator finder(first.camera, {}, kBundle, kSynchronous);
  finder.Begin(first.map, first.model, kFirstSubmap, kNoId);
  ASSERT_TRUE(finder.Finish(&first.map));
  const DepthPattern left{truth.nodes - finder.pattern().nodes};

  // This walk alone could show a pattern by chance.
  Walk longer(left, 30);
  DepthDistortionEstimator unaware(longer.camera, {}, kBundle, kSynchronous);
  unaware.Begin(longer.map, longer.model, kFirstSubmap, kNoId);
  EXPECT_FALSE(unaware.Finish(&longer.map));

  finder.Begin(longer.map, longer.model, kFirstSubmap, kNoId);
  ASSERT_TRUE(finder.Finish(&longer.map));
  EXPECT_LT(DepthPattern{truth.nodes - finder.pattern().nodes}.Rms(), 0.8 * left.Rms());
}

TEST(DepthDistortionEstimator, APatternIsNotReplacedByOneThatIsKnownLessWell) {
  Walk first(Tilted(), 30);
  DepthDistortionEstimator finder(first.camera, {}, kBundle, kSynchronous);
  finder.Begin(first.map, first.model, kFirstSubmap, kNoId);
  ASSERT_TRUE(finder.Finish(&first.map));
  const DepthPattern known = finder.pattern();

  Walk sparse(Tilted(), 60);  // twice as many keyframes, a fifth of the depth
  for (const KeyFrameId id : sparse.map.keyframe_ids()) {
    auto features = std::make_shared<FrameFeatures>(*sparse.map.keyframe(id)->frame.features);
    for (std::size_t i = 0; i < features->points.size(); ++i) {
      if (i % 5 != 0) features->points[i].depth = 0.0;
    }
    sparse.map.keyframe(id)->frame.features = features;
  }
  finder.Begin(sparse.map, sparse.model, kFirstSubmap, kNoId);
  EXPECT_FALSE(finder.Finish(&sparse.map));
  EXPECT_EQ(finder.pattern().nodes, known.nodes);
  // A finder without a known pattern estimates one.
  DepthDistortionEstimator unaware(sparse.camera, {}, kBundle, kSynchronous);
  unaware.Begin(sparse.map, sparse.model, kFirstSubmap, kNoId);
  EXPECT_TRUE(unaware.Finish(&sparse.map));
}

TEST(DepthDistortionEstimator, KeyframesThatWereGivenStayAsTheyAre) {
  Walk walk(Tilted());
  const KeyFrameId second = walk.map.keyframe_ids()[1];
  const auto given = walk.map.keyframe(second)->frame.features;
  DepthDistortionEstimator finder(walk.camera, {}, kBundle, kSynchronous);
  finder.Begin(walk.map, walk.model, kFirstSubmap, second);
  ASSERT_TRUE(finder.Finish(&walk.map));
  EXPECT_EQ(walk.map.keyframe(second)->frame.features, given);
  EXPECT_NE(walk.map.keyframe(walk.map.keyframe_ids()[2])->frame.features, given);
}

TEST(DepthDistortionEstimator, DoesNotApplyACancelledResult) {
  Walk walk(Tilted());
  const double error = walk.Error();
  DepthDistortionEstimator finder(walk.camera, {}, kBundle);
  finder.Begin(walk.map, walk.model, kFirstSubmap, kNoId);
  finder.Drop();
  EXPECT_FALSE(finder.HasResult());
  EXPECT_FALSE(finder.Finish(&walk.map));
  EXPECT_TRUE(finder.pattern().IsZero());
  EXPECT_EQ(walk.Error(), error);
}

TEST(DepthDistortionEstimator, AMapWithoutDepthGivesNoPattern) {
  Walk walk(Tilted());
  for (const KeyFrameId id : walk.map.keyframe_ids()) {
    auto features = std::make_shared<FrameFeatures>(*walk.map.keyframe(id)->frame.features);
    for (PointFeature& feature : features->points) feature.depth = 0.0;
    walk.map.keyframe(id)->frame.features = features;
  }
  DepthDistortionEstimator finder(walk.camera, {}, kBundle, kSynchronous);
  finder.Begin(walk.map, walk.model, kFirstSubmap, kNoId);
  EXPECT_FALSE(finder.Finish(&walk.map));
}

}  // namespace
}  // namespace highwall::depth_distortion_estimator_test
