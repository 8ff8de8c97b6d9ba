#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "simulate/camera/exposure.h"
#include "simulate/camera/haze.h"
#include "simulate/camera/motion_blur.h"
#include "simulate/camera/sensor.h"
#include "simulate/camera/simulation.h"
#include "simulate/camera/stretch.h"

namespace highwall::simulate::camera_effects_test {
namespace {

PinholeCamera SmallCamera() {
  return {.width = 160, .height = 120, .fx = 153.75, .fy = 153.75, .cx = 79.5, .cy = 59.5};
}

// A wall at `depth` [m], dark on the left, bright from column 80 on.
Rendering MakeEdge(float depth) {
  Rendering edge{cv::Mat(120, 160, CV_32FC3, cv::Scalar::all(40)),
                 cv::Mat(120, 160, CV_32FC1, depth), cv::Mat(120, 160, CV_32FC1, 1.0f)};
  edge.bgr.colRange(80, 160).setTo(cv::Scalar::all(140));
  return edge;
}

// Grey levels that leave no block without contrast.
Rendering MakeChecker(float depth) {
  Rendering checker = MakeEdge(depth);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      checker.bgr.at<cv::Vec3f>(v, u) = cv::Vec3f::all((u + v) % 2 == 0 ? 80.0f : 120.0f);
    }
  }
  return checker;
}

Simulation SimulateWall(const SimulationOptions& options,
                        const std::vector<Stretch>& stretches = {}, MovingScene moving = {}) {
  Scene scene;
  const int texture = scene.AddTexture(
      std::make_unique<NoiseTexture>(Rgb(0.6, 0.5, 0.4), 0.5f, ValueNoise{.wavelength = 0.2f}));
  scene.AddRectangle({-5, -5, 2}, {10, 0, 0}, {0, 10, 0}, texture);
  std::vector<Pose> control;
  for (int i = 0; i < 40; ++i) {
    control.push_back(
        Pose::FromTangent({0.2 * std::sin(std::numbers::pi * i / 20), 0, 0}, {0, 0, 0}));
  }
  return Simulation(std::move(scene), SplineTrajectory(control, 4.0), options, {}, stretches,
                    std::move(moving));
}

SimulationOptions SmallOptions() {
  SimulationOptions options = FieldTestOptions();
  options.camera = SmallCamera();
  options.imu.enabled = false;
  return options;
}

TEST(MotionBlur, WidensAnEdgeToThePathThatItMoves) {
  const Rendering edge = MakeEdge(2.0f);
  const MotionBlur blur(SmallCamera());
  // The camera moves sideways by x: the wall moves by f x / z = 8 px.
  const double x = 8.0 * 2.0 / 153.75;
  const cv::Mat blurred = blur.Apply(edge.bgr, edge.depth,
                                     ExposureMotion{Pose::FromTangent({-0.5 * x, 0, 0}, {0, 0, 0}),
                                                    Pose::FromTangent({0.5 * x, 0, 0}, {0, 0, 0})});
  const auto column = [&](float level) {  // where the ramp reaches it, with subpixel accuracy
    for (int u = 1; u < 160; ++u) {
      const float here = blurred.at<cv::Vec3f>(60, u)[0],
                  before = blurred.at<cv::Vec3f>(60, u - 1)[0];
      if (here >= level) return static_cast<float>(u) - (here - level) / (here - before);
    }
    return -1.0f;
  };
  // From 10 to 90 % of the step: 0.8 of the path; interpolation rounds the ends of the ramp.
  EXPECT_NEAR(column(130.0f) - column(50.0f), 0.8f * 8.0f, 0.3f);
  EXPECT_NEAR(0.5f * (column(130.0f) + column(50.0f)), 79.5f, 0.05f);  // about the central instant
}

TEST(MotionBlur, LeavesAStillImageAloneAndTheFarUnmovedBySteps) {
  const Rendering edge = MakeEdge(2.0f);
  const MotionBlur blur(SmallCamera());
  EXPECT_EQ(cv::norm(blur.Apply(edge.bgr, edge.depth, ExposureMotion()), edge.bgr, cv::NORM_INF),
            0.0);
  const cv::Mat sky(120, 160, CV_32FC1, 0.0f);
  const Pose aside = Pose::FromTangent({0.3, 0, 0}, {0, 0, 0});
  EXPECT_EQ(
      cv::norm(blur.Apply(edge.bgr, sky, ExposureMotion{Pose(), aside}), edge.bgr, cv::NORM_INF),
      0.0);
}

TEST(Exposure, TakesTimeFirstAndGainThen) {
  ExposureOptions options{.mode = ExposureMode::kAuto,
                          .time = 0.008,
                          .max_time = 0.02,
                          .max_gain = 8.0,
                          .target = 100.0};
  const auto choose = [&](double level) {
    return ChooseExposure(options, cv::Mat(48, 64, CV_32FC3, cv::Scalar::all(level)));
  };
  EXPECT_NEAR(choose(200.0).time, 0.004, 1e-9);
  EXPECT_NEAR(choose(50.0).time, 0.016, 1e-9);
  EXPECT_EQ(choose(50.0).gain, 1.0);
  EXPECT_NEAR(choose(10.0).time, 0.02, 1e-12);
  EXPECT_NEAR(choose(10.0).gain, 4.0, 1e-6);
  EXPECT_NEAR(choose(10.0).scale * 10.0, 100.0, 1e-4);
  EXPECT_EQ(choose(1.0).gain, 8.0);  // the image remains dark
  options.mode = ExposureMode::kFixed;
  EXPECT_EQ(choose(10.0).time, 0.008);
  EXPECT_EQ(choose(10.0).scale, 1.0);
  options.mode = ExposureMode::kIdeal;
  EXPECT_EQ(choose(10.0).time, 0.0);
}

TEST(Exposure, DarkensCornersByTheVignetting) {
  const ExposureOptions options{.mode = ExposureMode::kFixed, .vignetting = 0.3};
  cv::Mat bgr(121, 161, CV_32FC3, cv::Scalar::all(100));
  Expose(options, {.scale = 2.0}, &bgr);
  EXPECT_NEAR(bgr.at<cv::Vec3f>(60, 80)[1], 200.0f, 1e-3f);
  EXPECT_NEAR(bgr.at<cv::Vec3f>(0, 0)[1], 140.0f, 1e-3f);
}

TEST(Haze, ContrastFallsExponentiallyWithDepth) {
  const auto contrast = [](float depth) {
    Rendering edge = MakeEdge(depth);
    AddHaze({.density = 0.4, .seed = 1}, 0.0, &edge);
    return static_cast<double>(edge.bgr.at<cv::Vec3f>(60, 80)[1] -
                               edge.bgr.at<cv::Vec3f>(60, 79)[1]);
  };
  // The haze along this pixel's ray has its own density, which is the same at all depths.
  const double density = -std::log(contrast(1.0f) / 100.0);
  EXPECT_GT(density, 0.04);
  EXPECT_LT(density, 0.8);
  // The rays of two neighbours pass through slightly different haze.
  EXPECT_NEAR(-std::log(contrast(4.0f) / 100.0), 4.0 * density, 0.1 * density);
}

struct DepthAndRatio {
  float depth;
  double ratio;
};
class D435iDepth : public ::testing::TestWithParam<DepthAndRatio> {};

TEST_P(D435iDepth, HasTheSigmaOfTriangulationTimesTheRatio) {
  const auto [z, ratio] = GetParam();
  const SensorOptions options{
      .noise = SensorNoise::kD435i, .noise_ratio = ratio, .min_depth = 0.1, .max_depth = 20.0};
  const Sensor sensor(options, SmallCamera(), 1);
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int frame = 0; frame < 5; ++frame) {
    const cv::Mat depth = sensor.Observe(MakeChecker(z), frame).depth;
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        const double error = static_cast<double>(depth.at<float>(v, u)) - static_cast<double>(z);
        sum += error;
        squares += error * error;
        ++count;
      }
    }
  }
  const double model = 0.08 * std::pow(static_cast<double>(z), 2) / (425.0 * 0.05);
  EXPECT_NEAR(options.Noise().Sigma(static_cast<double>(z)), model, 1e-12) << "the data sheet's";
  // 5 x 1200 independent grains: sigma / sqrt(2 n) is 0.9 %; the tolerance is three of them.
  EXPECT_NEAR(std::sqrt(squares / count) / (ratio * model), 1.0, 0.03);
  EXPECT_LT(std::abs(sum / count), 4.0 * ratio * model / std::sqrt(6000.0));
}

INSTANTIATE_TEST_SUITE_P(Distances, D435iDepth,
                         ::testing::Values(DepthAndRatio{0.8f, 1.0}, DepthAndRatio{2.0f, 1.5},
                                           DepthAndRatio{4.5f, 1.0}));

TEST(D435i, SeesNothingWhereTheSecondCameraCannot) {
  Rendering scene = MakeChecker(3.0f);
  scene.depth.colRange(100, 160).setTo(1.0);
  const SensorOptions options{.noise = SensorNoise::kD435i};
  const cv::Mat depth = Sensor(options, SmallCamera(), 1).Observe(scene, 0).depth;
  // To the left of the near edge f b (1/1 - 1/3) = 5.1 px are occluded.
  EXPECT_EQ(cv::countNonZero(depth.colRange(95, 100)), 0);
  EXPECT_EQ(cv::countNonZero(depth.colRange(0, 94)), 120 * 94);
  EXPECT_EQ(cv::countNonZero(depth.colRange(100, 160)), 120 * 60);
}

TEST(D435i, FindsLittleWhereThereIsNothingToMatch) {
  Rendering plain = MakeChecker(2.0f);
  plain.bgr.setTo(cv::Scalar::all(90));
  const SensorOptions options{.noise = SensorNoise::kD435i};
  const Sensor sensor(options, SmallCamera(), 1);
  const double share = cv::countNonZero(sensor.Observe(plain, 0).depth) / (160.0 * 120.0);
  EXPECT_NEAR(share, 0.3, 0.02);
}

TEST(D435i, GainRaisesTheNoiseOfColour) {
  const SensorOptions options{.noise = SensorNoise::kD435i};
  const Sensor sensor(options, SmallCamera(), 1);
  const auto sigma = [&](double gain) {
    Rendering plain = MakeChecker(2.0f);
    plain.bgr.setTo(cv::Scalar::all(100));
    cv::Scalar mean, deviation;
    cv::meanStdDev(sensor.Observe(plain, 0, 0, gain).bgr, mean, deviation);
    return deviation[0];
  };
  // The sum of read noise, shot noise and rounding.
  EXPECT_NEAR(sigma(1.0), std::sqrt(0.64 + 2.0 + 1.0 / 12.0), 0.03);
  EXPECT_NEAR(sigma(8.0), std::sqrt(0.64 * 64.0 + 16.0 + 1.0 / 12.0), 0.15);
}

TEST(Stretches, RiseAndFallSmoothlyAndBlackoutsAtOnce) {
  const std::vector<Stretch> stretches = {{StretchKind::kDust, 2.0, 5.0},
                                          {StretchKind::kBlackout, 4.0, 6.0}};
  EXPECT_EQ(Intensity(stretches, StretchKind::kDust, 1.99), 0.0);
  EXPECT_EQ(Intensity(stretches, StretchKind::kDust, 2.25), 0.5);
  EXPECT_EQ(Intensity(stretches, StretchKind::kDust, 3.0), 1.0);
  EXPECT_EQ(Intensity(stretches, StretchKind::kDust, 5.01), 0.0);
  EXPECT_EQ(Intensity(stretches, StretchKind::kBlackout, 4.0), 1.0);
  EXPECT_EQ(Intensity(stretches, StretchKind::kBumpy, 3.0), 0.0);
}

TEST(Stretches, OfASceneComeBackEveryLapAndEndWithTheSequence) {
  SimulationOptions options = SmallOptions();
  options.duration = 10.0;
  options.blackouts = {{.begin = 3.0, .duration = 2.0}, {.begin = 11.0, .duration = 1.0}};
  // Laps of 4 s, delayed by a second of rest and half a second of acceleration.
  const Simulation simulation = SimulateWall(options, {{StretchKind::kDust, 1.0, 2.0}});
  ASSERT_EQ(simulation.stretches().size(), 3u);
  EXPECT_EQ(simulation.stretches()[0].begin, 2.5);
  EXPECT_EQ(simulation.stretches()[1].kind, StretchKind::kBlackout);
  EXPECT_EQ(simulation.stretches()[2].begin, 6.5);
  for (const Stretch& stretch : simulation.stretches()) {
    EXPECT_GE(stretch.begin, 0.0);
    EXPECT_LT(stretch.begin, stretch.end);
    EXPECT_LE(stretch.end, options.duration);
  }
}

TEST(Simulation, ACoveredLensSeesNothing) {
  SimulationOptions options = SmallOptions();
  options.blackouts = {{.begin = 1.0, .duration = 1.0}};
  const Simulation simulation = SimulateWall(options);
  for (const int i : {30, 45, 60}) {
    const SimulatedFrame frame = simulation.Render(i);
    EXPECT_EQ(cv::norm(frame.bgr, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::countNonZero(frame.depth), 0);
  }
  for (const int i : {29, 61}) {
    const SimulatedFrame frame = simulation.Render(i);
    EXPECT_GT(cv::mean(frame.bgr)[0], 50.0);
    EXPECT_GT(cv::countNonZero(frame.depth), 160 * 120 / 2);
  }
}

// Makes a white plate 0.4 m wide at depth z [m] in front of the camera's initial position.
Scene MakePlate(double z) {
  Scene scene;
  const int white =
      scene.AddTexture(std::make_unique<NoiseTexture>(Rgb(1, 1, 1), 0.0f, ValueNoise{}));
  scene.AddRectangle({-0.2, -0.2, z}, {0.4, 0, 0}, {0, 0.4, 0}, white);
  scene.looks.resize(scene.mesh.vertices.size());
  return scene;
}

TEST(Simulation, AMovingObjectOccludesFartherSurfacesAndIsOccludedByNearerOnes) {
  SimulationOptions options = SmallOptions();
  options.sensor.noise = SensorNoise::kOff;
  options.exposure.mode = ExposureMode::kIdeal;
  const auto approach = [](double t) { return MakePlate(2.5 - t); };  // the wall is 2 m away
  const SimulatedFrame without = SimulateWall(options, {}, approach).Render(21);
  options.traffic = true;
  const Simulation simulation = SimulateWall(options, {}, approach);
  const SimulatedFrame behind = simulation.Render(3),
                       before = simulation.Render(21);  // 2.4 m and 1.8 m
  EXPECT_NEAR(behind.depth.at<float>(60, 80), 2.0f, 1e-6f);
  EXPECT_NEAR(before.depth.at<float>(60, 80), 1.8f, 1e-6f);
  cv::Mat moved = before.depth != without.depth;
  // A width of 0.4 m at 1.8 m is 34.2 px.
  EXPECT_NEAR(cv::countNonZero(moved), 34.2 * 34.2, 2.0 * 34.2);
}

TEST(Simulation, DeepShadowIsTakenLongAndWithGain) {
  const Simulation simulation = SimulateWall(SmallOptions(), {{StretchKind::kLowLight, 1.0, 3.0}});
  const SimulatedFrame light = simulation.Render(60), dark = simulation.Render(105);
  EXPECT_LT(light.exposure.time, 0.0201);
  EXPECT_EQ(light.exposure.gain, 1.0);
  EXPECT_NEAR(dark.exposure.time, 0.02, 1e-12);
  EXPECT_GT(dark.exposure.gain, 4.0);
}

TEST(Simulation, RefusesEffectsOutOfRangeByName) {
  const auto refused = [](auto&& change) {
    SimulationOptions options = SmallOptions();
    change(&options);
    try {
      options.Validate();
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused([](auto* o) {
              o->blackouts = {{1.0, 0.0}};
            }).find("Blackout::duration"),
            std::string::npos);
  EXPECT_NE(refused([](auto* o) { o->exposure.time = 0.0; }).find("ExposureOptions::time"),
            std::string::npos);
  EXPECT_NE(refused([](auto* o) { o->exposure.vignetting = 1.0; }).find("vignetting"),
            std::string::npos);
  EXPECT_NE(refused([](auto* o) { o->sensor.stereo.subpixel = 0.0; }).find("subpixel"),
            std::string::npos);
}

}  // namespace
}  // namespace highwall::simulate::camera_effects_test
