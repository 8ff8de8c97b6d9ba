#include <highwall/frontend/calibration/camera_calibration.h>

#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "support/synthetic_scene.h"

namespace highwall::camera_calibration_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeSurroundings;
using testing::Scene;
using testing::SceneMap;
using testing::UniformInBox;

// Returns the true camera; the one that the map was made with is off by 1 % of the focal lengths,
// and by 4 px.
RgbdSensor TrueSensor() {
  return IdealSensor();
}
RgbdSensor WrongSensor() {
  RgbdSensor sensor = TrueSensor();
  sensor.camera.fx *= 1.01;
  sensor.camera.fy *= 0.99;
  sensor.camera.cx += 4.0;
  sensor.camera.cy -= 4.0;
  return sensor;
}
Eigen::Vector4d IntrinsicsOf(const PinholeCamera& camera) {
  return {camera.fx, camera.fy, camera.cx, camera.cy};
}

// Measurement model of the adjustment; the observations are drawn with its noise as well.
const MeasurementModel kModel(WrongSensor(), {});

// Returns the map of a walk whose keyframes and points are off by a centimetre and half a degree.
// turns: [rad] about the camera's axes, from one end of the walk to the other. offset, pattern:
// [1/m] errors of the measured inverse depth. stored: the camera with its distortion, in whose
// pixels the pattern is given.
Map Walk(const Scene& scene, const Eigen::Vector3d& turns, unsigned seed, double offset = 0.0,
         const DepthPattern& pattern = {}, const PinholeCamera& stored = TrueSensor().camera) {
  std::mt19937 rng(seed);
  SceneMap scene_map(scene);
  constexpr int kKeyFrames = 24;
  for (int i = 0; i < kKeyFrames; ++i) {
    const double s = i / (kKeyFrames - 1.0) - 0.5;
    const Pose T_WC = Pose::FromTangent(
        {0.8 * std::sin(9.0 * s), 0.5 * std::cos(7.0 * s), 0.6 * std::sin(5.0 * s)},
        {turns.x() * std::sin(11.0 * s), turns.y() * std::sin(7.0 * s),
         turns.z() * std::cos(5.0 * s)});
    auto view =
        Look(scene, TrueSensor(), T_WC,
             {.px = kModel.PointSigma(0), .depth = true, .seed = seed + static_cast<unsigned>(i)});
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (PointFeature& feature : features->points) {
      const Eigen::Vector2d raw = stored.Project(TrueSensor().camera.Unproject(feature.uv, 1.0));
      const double here = pattern.At(raw.x(), raw.y(), stored.width, stored.height);
      feature.depth /= 1.0 + (offset + here) * feature.depth;
    }
    view.features = features;
    Eigen::Matrix<double, 6, 1> d;
    const Eigen::Vector3d p = UniformInBox(rng, {-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01});
    const Eigen::Vector3d q = UniformInBox(rng, {-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01});
    d << p, q;
    scene_map.Add(view, T_WC.Plus(d));
  }
  for (const PointId id : scene_map.map.ids<MapPoint>()) {
    scene_map.map.Find(id)->p_W += UniformInBox(rng, {-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02});
  }
  return std::move(scene_map.map);
}

TEST(CameraCalibration, OffByOnePercentAreFoundWithinTheirStandardDeviations) {
  const Scene scene = MakeSurroundings();
  double nees = 0.0;
  constexpr int kRuns = 5;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const CameraCalibration found =
        *CalibrateCamera(Walk(scene, {0.8, 0.8, 0.8}, 100 * seed), kModel);
    const Eigen::Vector4d error = found.intrinsics - IntrinsicsOf(TrueSensor().camera);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 1.0) << error.transpose();  // it was off by 4 and 5
    EXPECT_TRUE((error.cwiseAbs().array() < 4.0 * found.sigma.array()).all()) << error.transpose();
    EXPECT_LT(found.sigma.maxCoeff(), 0.5);
    EXPECT_EQ(found.keyframes, 24);
    EXPECT_NEAR(found.error, 1.0, 0.1);  // Huber's loss reduces it
    EXPECT_TRUE(found.advice.empty());
    nees += error.cwiseQuotient(found.sigma).squaredNorm() / (4.0 * kRuns);
  }
  // Chi-squared of 20 degrees of freedom, if they were not correlated: 1 +- 0.32.
  EXPECT_LT(nees, 1.0 + 4.0 * 0.32);
}

// Inverse depth offset of depth that reads 2 % too long at 3 m.
constexpr double kOffset = -0.02 / 1.02 / 3.0;

TEST(CameraCalibration, OffsetsOfDepthAreFoundWithinTheirStandardDeviations) {
  const Scene scene = MakeSurroundings();
  const MeasurementModel known(TrueSensor(), {});
  double nees = 0.0;
  constexpr int kRuns = 10;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    for (const double offset : {0.0, kOffset}) {
      const Map map = Walk(scene, {0.8, 0.8, 0.8}, 100 * seed, offset);
      const CameraCalibration found =
          *CalibrateCamera(map, known, kFirstSubmap, {.intrinsics = false});
      const double error = found.inverse_depth_offset - offset;
      EXPECT_LT(std::abs(error), 4.0 * found.inverse_depth_sigma) << seed;
      EXPECT_LT(found.inverse_depth_sigma, 0.1 * std::abs(kOffset));
      EXPECT_TRUE(found.inverse_depth_seen);
      EXPECT_TRUE(found.advice.empty());
      EXPECT_EQ(found.intrinsics, IntrinsicsOf(TrueSensor().camera));
      EXPECT_EQ(found.sigma, Eigen::Vector4d::Zero());
      EXPECT_EQ(found.seen, (std::array<bool, 4>{}));
      const double normalized = error / found.inverse_depth_sigma;
      nees += normalized * normalized / (2.0 * kRuns);
    }
  }
  // Chi-squared of 20 degrees of freedom: 1 +- 0.32.
  EXPECT_LT(nees, 1.0 + 4.0 * 0.32);
  EXPECT_GT(nees, 0.2);
}

TEST(CameraCalibration, SeparatesOffsetsOfDepthFromIntrinsics) {
  const Map map = Walk(MakeSurroundings(), {0.8, 0.8, 0.8}, 100, kOffset);
  const CameraCalibration found = *CalibrateCamera(map, kModel);
  EXPECT_LT(std::abs(found.inverse_depth_offset - kOffset), 4.0 * found.inverse_depth_sigma);
  EXPECT_LT(found.inverse_depth_sigma, 0.1 * std::abs(kOffset));
  const Eigen::Vector4d error = found.intrinsics - IntrinsicsOf(TrueSensor().camera);
  EXPECT_TRUE((error.cwiseAbs().array() < 4.0 * found.sigma.array()).all()) << error.transpose();
}

TEST(CameraCalibration, APatternOfDepthIsFoundWithinItsStandardDeviations) {
  const Scene scene = MakeSurroundings();
  const MeasurementModel known(TrueSensor(), {});
  std::mt19937 rng(5);
  double nees = 0.0;
  constexpr int kRuns = 5;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    // The pattern is as smooth as its prior assumes, has zero mean, and comes with an offset.
    DepthPattern truth;
    for (int node = 0; node < DepthPattern::kNodes; ++node) {
      const double left = node % DepthPattern::kColumns > 0 ? truth.nodes[node - 1] : 0.0;
      truth.nodes[node] = left + testing::Uniform(rng, -0.005, 0.005);
    }
    const Map map = Walk(scene, {0.8, 0.8, 0.8}, 100 * seed, kOffset, truth);
    const CameraCalibration found = *CalibrateCamera(
        map, known, kFirstSubmap, {.intrinsics = false, .pattern_of = TrueSensor().camera});
    // The constant part, which both the offset and the pattern can represent, is in one of them by
    // chance.
    const double shift = (found.depth_pattern.nodes - truth.nodes).mean();
    const DepthPattern::Vector error = (found.depth_pattern.nodes - truth.nodes).array() - shift;
    EXPECT_LT(std::sqrt(error.squaredNorm() / DepthPattern::kNodes), 0.25 * truth.Rms());
    EXPECT_LT(std::abs(found.inverse_depth_offset + shift - kOffset),
              4.0 * found.inverse_depth_sigma);
    EXPECT_TRUE(found.depth_pattern_seen);
    EXPECT_TRUE(found.advice.empty());
    nees += error.cwiseQuotient(found.depth_pattern_sigma.nodes).squaredNorm() /
            (DepthPattern::kNodes * kRuns);
  }
  // Chi-squared of 95 degrees of freedom, correlated between neighbours: 1 +- 0.15 and more.
  EXPECT_LT(nees, 1.8);
  EXPECT_GT(nees, 0.4);
}

TEST(CameraCalibration, APatternIsThatOfTheImageAsItIsStored) {
  PinholeCamera stored = TrueSensor().camera;
  stored.k1 = -0.25;
  DepthPattern truth;  // steep where pixels with and without distortion are far apart
  for (int node = 0; node < DepthPattern::kNodes; ++node) {
    const int column = node % DepthPattern::kColumns;
    truth.nodes[node] = column == 0 || column == DepthPattern::kColumns - 1 ? 0.02 : 0.0;
  }
  const Map map = Walk(MakeSurroundings(), {0.8, 0.8, 0.8}, 100, 0.0, truth, stored);
  const auto error = [&](const PinholeCamera& camera) {
    const CameraCalibration found =
        *CalibrateCamera(map, MeasurementModel(TrueSensor(), {}), kFirstSubmap,
                         {.intrinsics = false, .pattern_of = camera});
    DepthPattern left{found.depth_pattern.nodes - truth.nodes};
    left.nodes.array() -= left.nodes.mean();  // the mean belongs to the offset
    return left.Rms();
  };
  EXPECT_LT(error(stored), 0.5 * error(stored.WithoutDistortion()));
}

TEST(CameraCalibration, AGivenPatternIsNotLookedFor) {
  const Map map = Walk(MakeSurroundings(), {0.8, 0.8, 0.8}, 100);
  const CameraCalibration found = *CalibrateCamera(map, MeasurementModel(TrueSensor(), {}),
                                                   kFirstSubmap, {.intrinsics = false});
  EXPECT_TRUE(found.depth_pattern.IsZero());
  EXPECT_TRUE(found.depth_pattern_sigma.IsZero());
  EXPECT_FALSE(found.depth_pattern_seen);
}

TEST(CameraCalibration, NamesAHardlyObservablePattern) {
  // The camera hardly moves: points stay where they are in the image.
  Scene scene = MakeSurroundings();
  SceneMap scene_map(scene);
  for (int i = 0; i < 4; ++i) {
    const Pose T_WC = Pose::FromTangent({0.01 * i, 0.0, 0.0}, {0.0, 0.0, 0.0});
    scene_map.Add(Look(scene, TrueSensor(), T_WC,
                       {.px = kModel.PointSigma(0), .depth = true, .seed = 5U + i}),
                  T_WC);
  }
  const CameraCalibration found =
      *CalibrateCamera(scene_map.map, MeasurementModel(TrueSensor(), {}), kFirstSubmap,
                       {.intrinsics = false, .pattern_of = TrueSensor().camera});
  EXPECT_FALSE(found.depth_pattern_seen);
  ASSERT_FALSE(found.advice.empty());
  EXPECT_NE(found.advice.back().find("pattern of depth"), std::string::npos);
}

TEST(CameraCalibration, NamesUnobservableParameters) {
  const Scene scene = MakeSurroundings();
  // The camera always looks ahead: a shifted principal point and a rotation are indistinguishable.
  const Map map = Walk(scene, {0.0, 0.0, 0.0}, 7);
  const CameraCalibration found = *CalibrateCamera(map, kModel);
  const CameraCalibration turned = *CalibrateCamera(Walk(scene, {0.8, 0.8, 0.8}, 7), kModel);
  EXPECT_GT(found.sigma[2], 3.0 * turned.sigma[2]);
  EXPECT_GT(found.sigma[3], 3.0 * turned.sigma[3]);
  EXPECT_FALSE(found.advice.empty());
}

// Their distance is in no row: the normal equations would be singular.
TEST(CameraCalibration, PointsWithoutDepthAreLeftOutWhereTheyWereSeenWithoutParallax) {
  Map map = Walk(MakeSurroundings(), {0.8, 0.8, 0.8}, 7);
  // Two additional keyframes at one place have a last point that no other keyframe sees.
  const KeyFrame& model = *map.keyframe(map.keyframe_ids().front());
  const std::vector<PointId> points = model.points;
  const Pose T_WC = model.T_WC;
  auto features = std::make_shared<FrameFeatures>(*model.frame.features);
  const Eigen::Vector3d p_C(0.1, 0.2, 3.0);
  features->points.push_back({.uv = TrueSensor().camera.Project(p_C)});
  features->point_descriptors.push_back(cv::Mat::zeros(1, 32, CV_8U));
  std::vector<KeyFrameId> added;
  for (int i = 0; i < 2; ++i) {
    added.push_back(map.AddKeyFrame({.features = features}, T_WC).id);
    for (std::size_t f = 0; f < points.size(); ++f) {
      if (points[f] != kNoId) map.Observe(added.back(), static_cast<int>(f), points[f]);
    }
  }
  const CameraCalibration without = *CalibrateCamera(map, kModel);
  const PointId far = map.Add<MapPoint>(T_WC * p_C, 0).id;
  for (const KeyFrameId id : added) map.Observe(id, static_cast<int>(points.size()), far);
  const CameraCalibration with = *CalibrateCamera(map, kModel);
  EXPECT_EQ(with.points, without.points);
  EXPECT_EQ(with.intrinsics, without.intrinsics);

  // Other points keep their distance by parallax: every second point loses its depth everywhere.
  for (const KeyFrameId id : map.keyframe_ids()) {
    KeyFrame& keyframe = *map.keyframe(id);
    auto half = std::make_shared<FrameFeatures>(*keyframe.frame.features);
    for (std::size_t f = 0; f < half->points.size(); ++f) {
      if (keyframe.points[f].value() % 2 == 0) half->points[f].depth = 0.0;
    }
    keyframe.frame.features = half;
  }
  EXPECT_GT(CalibrateCamera(map, kModel)->points, 0.9 * without.points);
}

TEST(CameraCalibration, AMapThatDoesNotDetermineTheCameraGivesNoneAndAReason) {
  std::string reason;
  EXPECT_FALSE(CalibrateCamera(Map(), kModel, kFirstSubmap, {}, &reason));
  EXPECT_NE(reason.find("keyframes"), std::string::npos) << reason;
  EXPECT_FALSE(CalibrateCamera(Map(), kModel));
  const Map map = Walk(MakeSurroundings(), {0.8, 0.8, 0.8}, 1);
  EXPECT_TRUE(CalibrateCamera(map, kModel, kFirstSubmap, {}, &reason));
  EXPECT_EQ(reason, "");
}

TEST(CameraCalibration, RefusesBadOptions) {
  const Map map = Walk(MakeSurroundings(), {0.8, 0.8, 0.8}, 1);
  EXPECT_THROW(CalibrateCamera(map, kModel, kFirstSubmap, {.huber = 0.0}), InvalidArgument);
  EXPECT_THROW(CalibrateCamera(map, kModel, kFirstSubmap, {.inverse_depth = 0.0}), InvalidArgument);
  EXPECT_THROW(CalibrateCamera(map, kModel, kFirstSubmap, {.pattern_step = 0.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::camera_calibration_test
