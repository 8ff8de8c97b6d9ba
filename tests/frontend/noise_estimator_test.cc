#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/pose/pose_observations.h>
#include <highwall/frontend/pose/pose_solver.h>

#include "sensor/noise_estimator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::noise_estimator_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::PositionError;
using testing::Scene;
using testing::SceneMap;
using testing::SyntheticView;
using testing::operator""_kf;

constexpr double kTrue = 1.0;  // [px] of corners at level 0 and of segments

enum class OtherCorners { kNone, kRefined, kLowContrast };

// Eight keyframes that see one scene.
class NoiseOfAMap {
 public:
  // depth: ratio of the specified depth noise to the true one. others: kind of every other corner.
  explicit NoiseOfAMap(const MeasurementOptions& options, double depth = 1.0, int lines = 80,
                       OtherCorners others = OtherCorners::kNone)
      : scene_(MakeScene(4, 400, lines)),
        map_(scene_),
        model_(Sensor(depth), options),
        others_(others) {
    for (unsigned i = 0; i < 8; ++i) {
      const double x = 0.1 * i - 0.4;
      const Pose T_WC = Pose::FromTangent({x, 0.4 * x * x, 0.2 * x}, {0.05 * x, -0.1 * x, 0.1 * x});
      keyframes_.push_back(map_.Add(See(T_WC, i), T_WC));
    }
  }

  // Simulates the insertion of keyframes: each round adjusts with the current estimate.
  void Teach(NoiseEstimator* estimator) {
    BundleAdjustmentOptions adjustment;
    // All observations are kept: only the noise is wrong.
    adjustment.inliers = {1e9, 1e9, 1e9, 1e9};
    for (int round = 0; round < 4; ++round) {
      for (const KeyFrameId id : keyframes_) {
        Frame& frame = map_.map.keyframe(id)->frame;
        auto features = std::make_shared<FrameFeatures>(*estimator->Apply(*frame.features));
        for (PointFeature& point : features->points) {
          if (point.refined) point.noise.px = point.refined_noise_px;
        }
        frame.features = std::move(features);
      }
      AdjustBundle(map_.map, model_, keyframes_, {}, adjustment);
      estimator->Add(map_.map, keyframes_);
    }
  }
  const MeasurementModel& model() const { return model_; }

  // Position error [m] of one view, from its points, its lines or both.
  struct Errors {
    double points, lines, both;
  };
  Errors ErrorsOf(unsigned seed, const NoiseEstimator* learnt) const {
    const Pose T_WC = Pose::FromTangent({0.05, 0.1, -0.1}, {0.02, 0.03, 0.0});
    const SyntheticView view = See(T_WC, 100 + seed);
    const auto features = learnt != nullptr ? learnt->Apply(*view.features) : view.features;
    PerKind<PoseObservations> seen;
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      MapPoint point;
      point.p_W = scene_.points[static_cast<std::size_t>(view.points[i])].p_W;
      seen.points.push_back(MakePoseObservation(model_, point, features->points[i]));
    }
    for (std::size_t i = 0; i < view.lines.size(); ++i) {
      MapLine line;
      line.segment_W = scene_.lines[static_cast<std::size_t>(view.lines[i])].segment_W;
      seen.lines.push_back(MakePoseObservation(model_, line, features->lines[i], T_WC).value());
    }
    PoseSolverOptions options;
    options.inliers = {1e9, 1e9, 1e9, 1e9};
    options.point_huber = options.line_huber = 1e9;
    const auto error = [&](const PerKind<PoseObservations>& used) {
      return PositionError(SolvePose(T_WC, model_.projection(), used, options).value().T_WC, T_WC);
    };
    PerKind<PoseObservations> points, lines;
    points.points = seen.points;
    lines.lines = seen.lines;
    return {error(points), error(lines), error(seen)};
  }

  // Returns the root mean square over 200 views.
  Errors Rms(const NoiseEstimator* learnt) const {
    constexpr int kViews = 200;
    Errors sum{};
    for (unsigned seed = 0; seed < kViews; ++seed) {
      const Errors errors = ErrorsOf(seed, learnt);
      sum.points += errors.points * errors.points / kViews;
      sum.lines += errors.lines * errors.lines / kViews;
      sum.both += errors.both * errors.both / kViews;
    }
    return {std::sqrt(sum.points), std::sqrt(sum.lines), std::sqrt(sum.both)};
  }

 private:
  static RgbdSensor Sensor(double depth) {
    RgbdSensor sensor = IdealSensor();
    sensor.depth_noise.offset *= depth;
    sensor.depth_noise.quadratic *= depth;
    return sensor;
  }
  // The true noise is given. Every other corner may be a refined one with half of the noise, or one
  // of low contrast with twice the noise.
  SyntheticView See(const Pose& T_WC, unsigned seed) const {
    const auto look = [&](double px) {
      return Look(scene_, IdealSensor(), T_WC, {.px = px, .depth = true, .seed = seed});
    };
    SyntheticView view = look(kTrue);
    const SyntheticView other = look(others_ == OtherCorners::kRefined ? 0.5 * kTrue : 2.0 * kTrue);
    auto marked = std::make_shared<FrameFeatures>(*view.features);
    for (std::size_t i = 0; i < marked->points.size(); ++i) {
      PointFeature& point = marked->points[i];
      if (others_ != OtherCorners::kNone && i % 2 == 1) {
        point = other.features->points[i];
        point.refined = others_ == OtherCorners::kRefined;
        point.low_contrast = others_ == OtherCorners::kLowContrast;
      }
      point.depth_sigma = model_.depth_noise().Sigma(point.depth);
    }
    view.features = marked;
    return view;
  }

  const Scene scene_;
  SceneMap map_;
  const MeasurementModel model_;
  const OtherCorners others_;
  std::vector<KeyFrameId> keyframes_;
};

TEST(NoiseEstimator, FindsTheNoiseOfEachKindOfRow) {
  NoiseOfAMap map({.point_sigma = 0.5 * kTrue, .line_sigma = 2.0 * kTrue}, 2.0);
  NoiseEstimator estimator(map.model());
  map.Teach(&estimator);
  const NoiseEstimate& found = estimator.estimate();
  // A term for errors not visible in residuals is added (docs/noise.md). A median of n squared rows
  // of two degrees of freedom has a deviation of 0.72 / sqrt(n) of the standard deviation, some 2 %
  // for 700 rows here; the rest is due to the landmarks, which follow rows of too high weight.
  for (int level = 0; level < 8; ++level) {
    const auto i = static_cast<std::size_t>(level);
    EXPECT_NEAR(found.point_px[i], std::hypot(2.0, 0.4 / map.model().PointSigma(level)), 0.2) << i;
  }
  EXPECT_NEAR(found.line_px[1], std::hypot(0.5, 0.2), 0.06);
  EXPECT_NEAR(found.point_depth[2], std::hypot(0.5, 0.7), 0.03);
  EXPECT_NEAR(found.line_depth[2], std::hypot(0.5, 0.7), 0.03);
}

TEST(NoiseEstimator, KindsThatWereNotSeenFollowThoseThatWere) {
  NoiseOfAMap map({.point_sigma = 0.5 * kTrue, .line_sigma = kTrue}, 2.0);
  NoiseEstimator estimator(map.model());
  const NoiseEstimate before = estimator.estimate();
  map.Teach(&estimator);
  // No landmark is nearer than a metre: the estimate for the farther ones is used there.
  EXPECT_LT(estimator.estimate().point_depth[2], 0.8 * before.point_depth[2]);
  EXPECT_NEAR(estimator.estimate().point_depth[0], estimator.estimate().point_depth[2], 0.05);
}

// Of every other corner, whose noise is `factor` times that of the rest.
void ExpectFactors(const NoiseEstimate& found, const NoiseEstimate::Levels& others, double factor,
                   double tolerance, const MeasurementModel& model) {
  for (int level = 0; level < 8; ++level) {
    const auto i = static_cast<std::size_t>(level);
    const double shared = 0.4 / model.PointSigma(level);
    // There are half as many rows of each as in FindsTheNoiseOfEachKindOfRow. A landmark follows
    // its more accurate views, so that their residuals show less of their noise.
    EXPECT_NEAR(found.point_px[i], std::hypot(1.0, shared), 0.15) << i;
    EXPECT_NEAR(others[i], std::hypot(factor, shared), tolerance) << i;
  }
}

TEST(NoiseEstimator, EstimatesRefinedAndDetectedCornersSeparately) {
  NoiseOfAMap map({.point_sigma = kTrue, .line_sigma = kTrue}, 1.0, 80, OtherCorners::kRefined);
  NoiseEstimator estimator(map.model());
  map.Teach(&estimator);
  const NoiseEstimate& found = estimator.estimate();
  ExpectFactors(found, found.refined_px, 0.5, 0.1, map.model());
  FrameFeatures frame;
  frame.points.push_back({.octave = 2});
  const PointFeature applied = estimator.Apply(frame)->points[0];
  EXPECT_EQ(applied.noise.px, static_cast<float>(found.point_px[2])) << "frames are as detected";
  EXPECT_EQ(applied.refined_noise_px, static_cast<float>(found.refined_px[2]));
}

TEST(NoiseEstimator, EstimatesCornersOfLowContrastSeparately) {
  NoiseOfAMap map({.point_sigma = kTrue, .line_sigma = kTrue}, 1.0, 80, OtherCorners::kLowContrast);
  NoiseEstimator estimator(map.model());
  EXPECT_EQ(estimator.estimate().low_contrast_px, estimator.estimate().point_px) << "a priori";
  map.Teach(&estimator);
  const NoiseEstimate& found = estimator.estimate();
  ExpectFactors(found, found.low_contrast_px, 2.0, 0.2, map.model());
  FrameFeatures frame;
  frame.points = {{.octave = 2}, {.octave = 2, .low_contrast = true}};
  const auto applied = estimator.Apply(frame);
  EXPECT_EQ(applied->points[0].noise.px, static_cast<float>(found.point_px[2]));
  EXPECT_EQ(applied->points[1].noise.px, static_cast<float>(found.low_contrast_px[2]));
}

TEST(NoiseEstimator, WithWrongNoiseKnownBeforehandBothAreNoWorseThanTheBetterOfPointsAndLines) {
  // Corners are more accurate than specified, segments less.
  NoiseOfAMap map({.point_sigma = 8.0 * kTrue, .line_sigma = 0.25 * kTrue}, 4.0, 25);
  NoiseEstimator estimator(map.model());
  map.Teach(&estimator);
  const auto known = map.Rms(nullptr), learnt = map.Rms(&estimator);
  EXPECT_GT(known.both, 1.03 * std::min(known.points, known.lines));  // it is wrong enough
  EXPECT_LT(learnt.both, 1.03 * std::min(learnt.points, learnt.lines));
  EXPECT_LT(learnt.both, 1.03 * std::min(known.points, known.lines));
}

TEST(NoiseEstimator, TheCalibrationErrorOfASmallerImageIsTheSameAngle) {
  const auto line_px = [](double scale) {
    RgbdSensor sensor = IdealSensor();
    sensor.camera.width = static_cast<int>(640.0 * scale);
    sensor.camera.height = static_cast<int>(480.0 * scale);
    sensor.camera.fx = sensor.camera.fy = 525.0 * scale;
    sensor.camera.cx = 320.0 * scale - 0.5;
    sensor.camera.cy = 240.0 * scale - 0.5;
    const MeasurementModel model(sensor, {});
    return NoiseEstimator(model).estimate().line_px[0];
  };
  EXPECT_EQ(line_px(0.5), std::hypot(1.0, 0.2));
  EXPECT_EQ(line_px(1.0), std::hypot(1.0, 0.4));
  EXPECT_EQ(line_px(2.0), std::hypot(1.0, 0.4)) << "never larger";
}

TEST(NoiseEstimator, WithoutResidualsTheNoiseIsThatOfTheModelAndTheSharedPart) {
  NoiseOfAMap map({});
  NoiseEstimator estimator(map.model());
  const auto check = [&] {
    const NoiseEstimate& estimate = estimator.estimate();
    for (const double factor : estimate.line_px) EXPECT_EQ(factor, std::hypot(1.0, 0.4 / 1.0));
    for (const double factor : estimate.point_depth) EXPECT_EQ(factor, std::hypot(1.0, 0.7));
  };
  check();
  estimator.Add(Map(), {});
  check();
}

}  // namespace
}  // namespace highwall::noise_estimator_test
