#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "simulate/camera/motion_blur.h"
#include "simulate/camera/renderer.h"
#include "simulate/camera/sensor.h"
#include "simulate/camera/simulation.h"

// Errors of cheap depth cameras: rolling shutter, depth that is delayed relative to colour, and
// depth that reads too long.
namespace highwall::simulate::depth_camera_errors_test {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kFocal = 153.75;  // [px]
constexpr double kWall = 3.0;   // [m] z of a fronto-parallel wall, dark left of x = 0, else bright
constexpr double kSpeed = 2.0;  // [m/s]
constexpr int kFrame = 30;      // 1 s after the first, in the middle of a straight segment

SimulationOptions Options() {
  SimulationOptions options;
  options.camera = {.width = kWidth,
                    .height = kHeight,
                    .fx = kFocal,
                    .fy = kFocal,
                    .cx = 0.5 * (kWidth - 1),
                    .cy = 0.5 * (kHeight - 1)};
  options.sensor.noise = SensorNoise::kOff;
  options.imu.enabled = false;
  return options;
}

Scene MakeWall() {
  Scene scene;
  const auto plain = [&scene](double level) {
    return scene.AddTexture(
        std::make_unique<NoiseTexture>(Rgb(level, level, level), 0.0f, ValueNoise{}));
  };
  scene.AddRectangle({-9, -9, kWall}, {9, 0, 0}, {0, 18, 0}, plain(0.3));
  scene.AddRectangle({0, -9, kWall}, {9, 0, 0}, {0, 18, 0}, plain(0.9));
  return scene;
}

// Moves back and forth along a unit vector at constant speed, with a period of 4 s; in frame kFrame
// the camera is at the origin and looks along z.
Simulation Along(const Eigen::Vector3d& direction, const SimulationOptions& options,
                 MovingScene moving = {}) {
  constexpr int kKnots = 40, kAtFrame = 11;  // the knot at the pose of frame kFrame
  constexpr double kPeriod = 4.0, kWay = kSpeed * kPeriod / kKnots;  // [m] from knot to knot
  std::vector<Pose> control;
  for (int i = 0; i < kKnots; ++i) {
    control.push_back(
        Pose::FromTangent(kWay * (std::min(i, kKnots - i) - kAtFrame) * direction, {0, 0, 0}));
  }
  return Simulation(MakeWall(), SplineTrajectory(control, kPeriod), options, {}, {},
                    std::move(moving));
}

// Returns the column of the step from dark to bright with subpixel accuracy.
double EdgeInRow(const cv::Mat& bgr, int v) {
  const auto level = [&](int u) { return static_cast<double>(bgr.at<cv::Vec3b>(v, u)[1]); };
  double bright = 0.0;
  for (int u = 0; u < kWidth; ++u) {
    bright += (level(u) - level(0)) / (level(kWidth - 1) - level(0));
  }
  return kWidth - 0.5 - bright;
}

double DifferenceOf(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

TEST(Readout, AVerticalEdgeLeansByTheMotionDuringTheReadout) {
  SimulationOptions options = Options();
  options.readout = 0.03;
  const SimulatedFrame frame = Along(Eigen::Vector3d::UnitX(), options).Render(kFrame);
  // The camera moves right: rows that are read later appear farther left.
  const double lean = -kSpeed * options.readout * kFocal / kWall;  // [px] over the whole image
  for (int v = 0; v < kHeight; v += 7) {
    const double share = static_cast<double>(v) / kHeight - 0.5;
    EXPECT_NEAR(EdgeInRow(frame.bgr, v), options.camera.cx + share * lean, 0.2) << v;
  }
  EXPECT_NEAR(EdgeInRow(frame.bgr, kHeight - 1) - EdgeInRow(frame.bgr, 0), lean, 0.3);
}

TEST(Readout, StampAndPoseAreThoseOfTheMiddleRow) {
  const auto render = [](double readout) {
    SimulationOptions options = Options();
    options.readout = options.depth_readout = readout;
    return Along(Eigen::Vector3d(1, 0, 1).normalized(), options).Render(kFrame);
  };
  const SimulatedFrame global = render(0.0), rolling = render(0.03);
  EXPECT_EQ(rolling.stamp, global.stamp);
  EXPECT_EQ((rolling.T_WC.p() - global.T_WC.p()).norm(), 0.0);
  const int middle = kHeight / 2;
  EXPECT_EQ(DifferenceOf(rolling.bgr.row(middle), global.bgr.row(middle)), 0.0);
  EXPECT_EQ(DifferenceOf(rolling.depth.row(middle), global.depth.row(middle)), 0.0);
  for (const int v : {0, kHeight - 1}) {
    EXPECT_GT(DifferenceOf(rolling.bgr.row(v), global.bgr.row(v)), 0.0);
    EXPECT_GT(DifferenceOf(rolling.depth.row(v), global.depth.row(v)), 0.0);
  }
}

TEST(Readout, OfNoTimeIsThePlainRendering) {
  const Simulation simulation = Along(Eigen::Vector3d(1, 0, 1).normalized(), Options());
  const SimulatedFrame frame = simulation.Render(kFrame);
  const Rendering plain =
      Renderer(MakeWall(), simulation.options().camera).Render(simulation.T_WC(frame.stamp));
  cv::Mat bgr;
  plain.bgr.convertTo(bgr, CV_8UC3);
  EXPECT_EQ(DifferenceOf(frame.bgr, bgr), 0.0);
  EXPECT_EQ(DifferenceOf(frame.depth, plain.depth), 0.0);
}

TEST(Readout, OfColourLeavesDepthAloneAndTheOtherWayRound) {
  const auto render = [](double readout, double depth_readout) {
    SimulationOptions options = Options();
    options.readout = readout;
    options.depth_readout = depth_readout;
    return Along(Eigen::Vector3d(1, 0, 1).normalized(), options).Render(kFrame);
  };
  const SimulatedFrame plain = render(0.0, 0.0), colour = render(0.03, 0.0),
                       depth = render(0.0, 0.03), both = render(0.03, 0.03);
  EXPECT_EQ(DifferenceOf(colour.depth, plain.depth), 0.0);
  EXPECT_EQ(DifferenceOf(depth.bgr, plain.bgr), 0.0);
  EXPECT_EQ(DifferenceOf(colour.bgr, both.bgr), 0.0);
  EXPECT_EQ(DifferenceOf(depth.depth, both.depth), 0.0);
  EXPECT_GT(DifferenceOf(colour.bgr, plain.bgr), 0.0);
  EXPECT_GT(DifferenceOf(depth.depth, plain.depth), 0.0);
}

TEST(Readout, EveryRowIsBlurredByTheMotionAboutItsOwnTime) {
  Rendering edge{cv::Mat(kHeight, kWidth, CV_32FC3, cv::Scalar::all(40)),
                 cv::Mat(kHeight, kWidth, CV_32FC1, 2.0f), cv::Mat()};
  edge.bgr.colRange(kWidth / 2, kWidth).setTo(cv::Scalar::all(140));
  const MotionBlur blur(Options().camera);
  const ExposureMotion still, aside{Pose::FromTangent({-0.05, 0, 0}, {0, 0, 0}),
                                    Pose::FromTangent({0.05, 0, 0}, {0, 0, 0})};
  std::vector<ExposureMotion> rows(kHeight / 2, still);
  rows.resize(kHeight, aside);
  const cv::Mat mixed = blur.Apply(edge.bgr, edge.depth, rows);
  const cv::Mat blurred = blur.Apply(edge.bgr, edge.depth, aside);
  const cv::Range upper(0, kHeight / 2), lower(kHeight / 2, kHeight);
  EXPECT_EQ(DifferenceOf(mixed.rowRange(upper), edge.bgr.rowRange(upper)), 0.0);
  EXPECT_EQ(DifferenceOf(mixed.rowRange(lower), blurred.rowRange(lower)), 0.0);
  EXPECT_GT(DifferenceOf(mixed.rowRange(lower), edge.bgr.rowRange(lower)), 0.0);
  EXPECT_THROW(blur.Apply(edge.bgr, edge.depth, std::vector<ExposureMotion>(7)), InvalidArgument);
}

TEST(DepthDelay, DepthIsThatOfTheCameraWhenItsRowIsTaken) {
  SimulationOptions options = Options();
  options.depth_delay = 0.02;
  options.depth_readout = 0.03;
  const Simulation simulation = Along(Eigen::Vector3d::UnitZ(), options);
  const SimulatedFrame frame = simulation.Render(kFrame);
  EXPECT_LT(simulation.T_WC(frame.stamp).p().norm(), 1e-9);  // pose at the stamp, not of depth
  for (const int v : {0, kHeight / 2, kHeight - 1}) {
    const double late = 0.02 + (static_cast<double>(v) / kHeight - 0.5) * 0.03;  // [s]
    EXPECT_NEAR(frame.depth.at<float>(v, 20), kWall - kSpeed * late, 1e-6) << v;
  }
}

TEST(DepthDelay, ShiftsDepthAndNothingElse) {
  SimulationOptions options = Options();
  const Simulation plain = Along(Eigen::Vector3d::UnitZ(), options);
  options.depth_delay = 1.0 / 30.0;
  const Simulation delayed = Along(Eigen::Vector3d::UnitZ(), options);
  const SimulatedFrame frame = delayed.Render(kFrame);
  EXPECT_EQ(frame.stamp, plain.StampOf(kFrame));
  EXPECT_EQ(DifferenceOf(frame.bgr, plain.Render(kFrame).bgr), 0.0);
  // Stamps are whole microseconds.
  EXPECT_LT(DifferenceOf(frame.depth, plain.Render(kFrame + 1).depth), 1e-6 * kSpeed);
}

TEST(DepthDelay, AMovingObjectIsSeenAtTheTimeOfTheMiddleRowOfDepth) {
  const auto approach = [](double t) {  // a plate, 2 m away in frame kFrame
    Scene plate;
    const int white =
        plate.AddTexture(std::make_unique<NoiseTexture>(Rgb(1, 1, 1), 0.0f, ValueNoise{}));
    plate.AddRectangle({-0.2, -0.2, 3.0 - t}, {0.4, 0, 0}, {0, 0.4, 0}, white);
    plate.looks.resize(plate.mesh.vertices.size());
    return plate;
  };
  SimulationOptions options = Options();
  options.traffic = true;
  options.depth_delay = 0.05;
  const SimulatedFrame frame = Along(Eigen::Vector3d::UnitX(), options, approach).Render(kFrame);
  EXPECT_NEAR(frame.depth.at<float>(kHeight / 2, kWidth / 2), 1.95, 1e-6);
}

TEST(DepthBias, IsAConstantOfInverseDepth) {
  const auto measure = [](double z, const SensorOptions& options) {
    const Rendering wall{cv::Mat(kHeight, kWidth, CV_32FC3, cv::Scalar::all(90)),
                         cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(z)),
                         cv::Mat(kHeight, kWidth, CV_32FC1, 1.0f)};
    return Sensor(options, Options().camera, 1).Observe(wall, 0);
  };
  for (const double z : {1.0, 3.0, 6.0}) {
    const SensorOptions ideal{.noise = SensorNoise::kOff, .depth_bias = 0.02};
    EXPECT_NEAR(cv::mean(measure(z, ideal).depth)[0], 1.0 / (1.0 / z + ideal.InverseDepthOffset()),
                1e-6);
  }
  const SensorOptions two_percent{.noise = SensorNoise::kOff, .depth_bias = 0.02};
  EXPECT_NEAR(cv::mean(measure(3.0, two_percent).depth)[0], 3.06, 1e-6);
  // Noise is added: 3.5 mm here, in hundreds of independent grains.
  const SensorOptions stereo{.noise = SensorNoise::kD435i, .noise_ratio = 0.1, .depth_bias = 0.02};
  const SensorImages images = measure(3.0, stereo);
  EXPECT_NEAR(cv::mean(images.depth, images.depth > 0.0f)[0], 3.06, 1e-3);
  const SensorImages without =
      measure(3.0, {.noise = SensorNoise::kD435i, .noise_ratio = 0.1, .depth_bias = 0.0});
  EXPECT_EQ(DifferenceOf(images.bgr, without.bgr), 0.0);
}

TEST(DepthPattern, IsAParaboloidOfInverseDepthAndItsNodesAreNearIt) {
  const SensorOptions options{.noise = SensorNoise::kOff, .depth_pattern = 0.03};
  const double corner = options.InverseDepthPattern(1.0, -1.0);
  const double middle = options.InverseDepthPattern(0.0, 0.0);
  EXPECT_NEAR(1.0 / (1.0 / 3.0 + corner - middle), 3.09, 1e-12);  // 3 % longer than in the middle
  const Rendering wall{cv::Mat(kHeight, kWidth, CV_32FC3, cv::Scalar::all(90)),
                       cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(3.0)),
                       cv::Mat(kHeight, kWidth, CV_32FC1, 1.0f)};
  const cv::Mat depth = Sensor(options, Options().camera, 1).Observe(wall, 0).depth;
  EXPECT_NEAR(depth.at<float>(0, 0), 1.0 / (1.0 / 3.0 + corner), 1e-6);
  double sum = 0.0, squares = 0.0, most = 0.0;
  const DepthPattern pattern = options.Pattern();
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double off = 1.0 / static_cast<double>(depth.at<float>(v, u)) - 1.0 / 3.0;
      const double left = off - pattern.At(u, v, kWidth, kHeight);
      sum += off;
      squares += left * left;
      most = std::max(most, std::abs(left));
    }
  }
  constexpr double kPixels = kWidth * kHeight;
  EXPECT_NEAR(sum / kPixels, 0.0, 0.01 * std::abs(corner));  // pixels at the edge have full weight
  EXPECT_LT(std::sqrt(squares / kPixels), 0.05 * std::abs(corner - middle));
  EXPECT_LT(most, 0.1 * std::abs(corner - middle));
}

TEST(DepthCameraErrors, OutOfRangeAreRefusedByName) {
  const auto refused = [](auto&& change) {
    SimulationOptions options = Options();
    change(&options);
    try {
      options.Validate();
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto names = [](const std::string& text, const char* name) {
    return text.find(name) != std::string::npos;
  };
  for (const double bad : {-0.01, 0.034, std::nan("")}) {  // frames are 33.3 ms apart
    EXPECT_TRUE(names(refused([=](auto* o) { o->readout = bad; }), "::readout")) << bad;
    EXPECT_TRUE(names(refused([=](auto* o) { o->depth_readout = bad; }), "::depth_readout")) << bad;
  }
  EXPECT_EQ(refused([](auto* o) { o->readout = o->depth_readout = 0.033; }), "");
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(names(refused([=](auto* o) { o->depth_delay = kInfinite; }), "::depth_delay"));
  EXPECT_TRUE(names(refused([](auto* o) { o->sensor.depth_bias = 0.2; }), "::depth_bias"));
  EXPECT_TRUE(names(refused([](auto* o) { o->sensor.depth_pattern = 0.2; }), "::depth_pattern"));
}

}  // namespace
}  // namespace highwall::simulate::depth_camera_errors_test
