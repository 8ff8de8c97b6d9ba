#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

#include "simulate/camera/raycaster.h"
#include "simulate/camera/sensor.h"
#include "simulate/camera/simulation.h"
#include "simulate/scenes/room.h"

namespace highwall::simulate::simulate_test {
namespace {

constexpr double kPi = std::numbers::pi;

// A quarter of the default image: faster, with the same field of view.
PinholeCamera SmallCamera() {
  return {.width = 160, .height = 120, .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5};
}

SimulationOptions SmallOptions(SensorNoise noise = SensorNoise::kOff) {
  SimulationOptions options;
  options.camera = SmallCamera();
  options.sensor.noise = noise;
  return options;
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

// A large wall through (0, 0, distance), facing a camera at the origin when yaw [rad] is zero.
Scene MakeWallScene(double distance, double yaw = 0.0, bool checker = false) {
  Scene scene;
  MasonryOptions tiles{.cell = {0.2f, 0.2f}, .shift = 0.0f, .checker = checker, .contrast = 0.0f};
  const int texture = scene.AddTexture(std::make_unique<MasonryTexture>(tiles));
  const Eigen::Vector3d s(50.0 * std::cos(yaw), 0.0, 50.0 * std::sin(yaw)), t(0.0, 50.0, 0.0);
  scene.AddRectangle(Eigen::Vector3d(0.0, 0.0, distance) - 0.5 * (s + t), s, t, texture);
  return scene;
}

// A stationary camera at the origin.
Simulation AtRest(Scene scene, const SimulationOptions& options) {
  return Simulation(std::move(scene), SplineTrajectory(std::vector<Pose>(4), 10.0), options);
}

TEST(Renderer, DepthIsTheDistanceOfAWallItFaces) {
  const SimulatedFrame frame = AtRest(MakeWallScene(2.5), SmallOptions()).Render(0);
  double least = 0.0, greatest = 0.0;
  cv::minMaxLoc(frame.depth, &least, &greatest);
  EXPECT_EQ(least, 2.5);  // z, not the length of the ray: the same in the corners; exact in float
  EXPECT_EQ(greatest, 2.5);
}

TEST(Renderer, DepthOfASlantedWallFollowsItsEquationThroughADistortedLens) {
  SimulationOptions options = SmallOptions();
  options.camera.k1 = -0.2;
  options.camera.p1 = 0.003;
  const double yaw = 0.6;
  const SimulatedFrame frame = AtRest(MakeWallScene(2.0, yaw), options).Render(0);
  for (int v = 0; v < options.camera.height; v += 7) {
    for (int u = 0; u < options.camera.width; u += 7) {
      // z = 2 + x tan(yaw), x = m_x z.
      const double m_x = options.camera.Unproject({u, v}, 1.0).x();
      const double expected = 2.0 / (1.0 - m_x * std::tan(yaw));
      EXPECT_NEAR(frame.depth.at<float>(v, u), expected, 1e-6);  // half a float step at 3 m
    }
  }
}

TEST(Renderer, AveragesStructureFinerThanAPixel) {
  // At 60 m the 0.2 m tiles are half a pixel wide: unfiltered, the image would show moire patterns.
  Renderer renderer(MakeWallScene(60.0, 0.0, true), SmallCamera());
  const cv::Mat green = [&] {
    std::vector<cv::Mat> channels;
    cv::split(renderer.Render(Pose()).bgr, channels);
    return channels[1](cv::Rect(60, 40, 40, 40)).clone();
  }();
  cv::Scalar mean, sigma;
  cv::meanStdDev(green, mean, sigma);
  const Rendering near = Renderer(MakeWallScene(1.0, 0.0, true), SmallCamera()).Render(Pose());
  std::vector<cv::Mat> channels;
  cv::split(near.bgr, channels);
  cv::Scalar near_mean, near_sigma;
  cv::meanStdDev(channels[1], near_mean, near_sigma);
  EXPECT_LT(sigma[0], 0.5 * near_sigma[0]);
}

TEST(Sensor, MeasuresOnlyWithinItsRange) {
  EXPECT_EQ(cv::countNonZero(AtRest(MakeWallScene(0.39), SmallOptions()).Render(0).depth), 0);
  EXPECT_EQ(cv::countNonZero(AtRest(MakeWallScene(8.01), SmallOptions()).Render(0).depth), 0);
  EXPECT_EQ(cv::countNonZero(AtRest(MakeWallScene(7.99), SmallOptions()).Render(0).depth),
            160 * 120);
}

TEST(Sensor, KinectDepthHasTheSpreadAndTheStepsOfItsModel) {
  SimulationOptions options = SmallOptions(SensorNoise::kKinect);
  options.camera.fx = options.camera.fy = 525.0;
  constexpr double kZ = 3.0;
  const SimulatedFrame frame = AtRest(MakeWallScene(kZ), options).Render(0);
  cv::Scalar mean, sigma;
  cv::meanStdDev(frame.depth, mean, sigma);
  // Nguyen's sigma, scaled in the same ratio as the truth, and the error of rounding to steps of
  // z^2 / (8 f b), uniform over a step.
  const double model = options.sensor.noise_ratio * (0.0012 + 0.0019 * (kZ - 0.4) * (kZ - 0.4));
  const double step = kZ * kZ / (8.0 * 525.0 * 0.075);
  // 19200 samples: sigma / sqrt(2 n) = 0.5 %; the steps near the mean differ by another per cent.
  EXPECT_NEAR(sigma[0], std::hypot(model, step / std::sqrt(12.0)), 0.03 * model);
  EXPECT_NEAR(mean[0], kZ, 0.001);
  for (int u = 0; u < options.camera.width; ++u) {
    const double steps = 8.0 * 525.0 * 0.075 / frame.depth.at<float>(60, u);
    EXPECT_NEAR(steps, std::round(steps), 1e-4);
  }
}

TEST(Sensor, KinectSeesNothingBehindAnEdgeNorAtGrazingIncidence) {
  Rendering ideal{cv::Mat(60, 80, CV_32FC3, cv::Scalar(0)), cv::Mat(60, 80, CV_32FC1, 3.0f),
                  cv::Mat(60, 80, CV_32FC1, 1.0f)};
  ideal.depth.colRange(0, 40).setTo(1.5);
  ideal.depth.colRange(70, 80).setTo(0.0);  // the sky, which occludes nothing
  ideal.cosine.rowRange(50, 60).setTo(0.05);
  const SensorImages seen = Sensor({}, SmallCamera(), 1).Observe(ideal, 0);
  EXPECT_EQ(cv::countNonZero(seen.depth(cv::Rect(40, 0, 2, 50))), 0);         // half of the window
  EXPECT_EQ(cv::countNonZero(seen.depth(cv::Rect(42, 0, 28, 50))), 28 * 50);  // beyond it
  EXPECT_EQ(cv::countNonZero(seen.depth(cv::Rect(0, 0, 40, 50))), 40 * 50);   // the near side
  EXPECT_EQ(cv::countNonZero(seen.depth.rowRange(50, 60)), 0);
}

TEST(Simulation, SameSeedSameBytesWhateverTheThreads) {
  const SimulationOptions options = SmallOptions(SensorNoise::kKinect);
  const SimulatedFrame one = SimulateRoom(options).Render(7, 1);
  const SimulatedFrame five = SimulateRoom(options).Render(7, 5);
  EXPECT_TRUE(SameBytes(one.bgr, five.bgr));
  EXPECT_TRUE(SameBytes(one.depth, five.depth));
  EXPECT_EQ(std::memcmp(one.T_WC.data(), five.T_WC.data(), Pose::kSize * sizeof(double)), 0);
}

TEST(Simulation, AnotherSeedIsAnotherSequence) {
  SimulationOptions options = SmallOptions();
  const SimulatedFrame one = SimulateRoom(options).Render(7);
  options.seed = 2;
  const SimulatedFrame two = SimulateRoom(options).Render(7);
  EXPECT_FALSE(SameBytes(one.bgr, two.bgr));
  EXPECT_FALSE(SameBytes(one.depth, two.depth));
  EXPECT_GT((one.T_WC.p() - two.T_WC.p()).norm(), 0.01);
}

TEST(Simulation, EveryFrameHasNoiseOfItsOwn) {
  const Simulation still = AtRest(MakeWallScene(2.0), SmallOptions(SensorNoise::kKinect));
  const SimulatedFrame first = still.Render(0), second = still.Render(1);
  cv::Mat difference;
  cv::subtract(first.bgr, second.bgr, difference, cv::noArray(), CV_32F);
  cv::Scalar mean, sigma;
  cv::meanStdDev(difference, mean, sigma);
  // Two independent errors of sigma 2, each rounded (1/12): sqrt(2 (4 + 1/12)) = 2.858.
  for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(sigma[channel], 2.858, 0.06);
}

TEST(Simulation, DepthAndColourAgreeBetweenFramesUnderTheTruePoses) {
  const SimulationOptions options = SmallOptions();
  const Simulation room = SimulateRoom(options);
  const SimulatedFrame a = room.Render(0), b = room.Render(3);
  const Pose T_BA = b.T_WC.Inverse() * a.T_WC;
  cv::Mat smooth_a, smooth_b;  // pixels of both frames average over different surface points
  cv::GaussianBlur(a.bgr, smooth_a, {3, 3}, 0.8);
  cv::GaussianBlur(b.bgr, smooth_b, {3, 3}, 0.8);
  std::vector<double> depth_errors, grey_errors;
  for (int v = 0; v < options.camera.height; ++v) {
    for (int u = 0; u < options.camera.width; ++u) {
      const double z = a.depth.at<float>(v, u);
      if (z == 0.0) continue;
      const Eigen::Vector3d p_B = T_BA * options.camera.Unproject({u, v}, z);
      const Eigen::Vector2d uv = options.camera.Project(p_B);
      if (!options.camera.Contains(uv, 1.0)) continue;
      cv::Mat patch, depth;
      const cv::Point2f at(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
      cv::getRectSubPix(b.depth, {1, 1}, at, depth);
      cv::getRectSubPix(smooth_b, {1, 1}, at, patch);
      depth_errors.push_back(std::abs(depth.at<float>(0, 0) - p_B.z()));
      grey_errors.push_back(
          std::abs(patch.at<cv::Vec3b>(0, 0)[1] - smooth_a.at<cv::Vec3b>(v, u)[1]));
    }
  }
  ASSERT_GT(depth_errors.size(), 15000u);
  const auto quantile = [](std::vector<double>* values, double q) {
    const auto nth =
        values->begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values->size()));
    std::nth_element(values->begin(), nth, values->end());
    return *nth;
  };
  // Bilinear interpolation of a plane's depth over a pixel has errors of some hundredths of a
  // millimetre; the other differences are pixels at edges.
  EXPECT_LT(quantile(&depth_errors, 0.5), 2e-5);
  EXPECT_LT(quantile(&depth_errors, 0.85), 5e-5);
  EXPECT_LT(quantile(&grey_errors, 0.5), 1.5);
  EXPECT_LT(quantile(&grey_errors, 0.9), 6.0);
}

TEST(Simulation, RefusesOptionsOutOfRangeByName) {
  SimulationOptions options = SmallOptions();
  options.fps = 0.0;
  EXPECT_THROW(SimulateRoom(options), InvalidArgument);
  options = SmallOptions();
  options.duration = -1.0;
  EXPECT_THROW(SimulateRoom(options), InvalidArgument);
  options = SmallOptions();
  options.sensor.max_depth = options.sensor.min_depth;
  EXPECT_THROW(SimulateRoom(options), InvalidArgument);
  EXPECT_THROW(SimulateRoom(SmallOptions()).Render(300), InvalidArgument);
}

TEST(SplineTrajectory, TurnsEvenlyWhenItsControlPosesDo) {
  std::vector<Pose> control;
  for (int i = 0; i < 12; ++i) {
    control.push_back(Pose::FromTangent({1, 2, 3}, {0, 0, 2 * kPi * i / 12}));
  }
  const SplineTrajectory spline(control, 6.0);
  const Pose start = spline.T_WC(0.0);
  for (double t = 0.0; t < 6.0; t += 0.37) {
    const Eigen::Quaterniond expected = start.q() * so3::Exp({0, 0, 2 * kPi * t / 6.0});
    EXPECT_NEAR(expected.angularDistance(spline.T_WC(t).q()), 0.0, 1e-7);  // acos near 1
    EXPECT_NEAR((spline.T_WC(t).p() - Eigen::Vector3d(1, 2, 3)).norm(), 0.0, 1e-12);
  }
}

TEST(SplineTrajectory, RepeatsAndRefusesTooFewPoses) {
  std::vector<Pose> control;
  for (int i = 0; i < 5; ++i)
    control.push_back(Pose::FromTangent({1.0 * i, 0, 0}, {0.1 * i, 0, 0}));
  const SplineTrajectory spline(control, 2.0);
  EXPECT_LT((spline.T_WC(0.3).p() - spline.T_WC(4.3).p()).norm(), 1e-12);
  EXPECT_LT((spline.T_WC(0.3).p() - spline.T_WC(-1.7).p()).norm(), 1e-12);
  EXPECT_THROW(SplineTrajectory(std::vector<Pose>(3), 2.0), InvalidArgument);
  EXPECT_THROW(SplineTrajectory(control, 0.0), InvalidArgument);
}

class RoomPath : public ::testing::TestWithParam<std::pair<double, int>> {
 protected:
  double duration() const { return GetParam().first; }
  std::uint64_t seed() const { return static_cast<std::uint64_t>(GetParam().second); }
};

TEST_P(RoomPath, MovesAsAHandDoesAndReturnsToItsStart) {
  const SplineTrajectory path = MakeRoomTrajectory(duration(), seed());
  constexpr double kStep = 0.01;
  Eigen::Vector3d last_velocity = Eigen::Vector3d::Zero(), last_rate = last_velocity;
  for (int i = 0; i * kStep < duration(); ++i) {
    const Pose a = path.T_WC(i * kStep), b = path.T_WC((i + 1) * kStep);
    const Eigen::Vector3d velocity = (b.p() - a.p()) / kStep;
    const Eigen::Vector3d rate = so3::Log(a.q().conjugate() * b.q()) / kStep;
    EXPECT_GT(velocity.norm(), 0.3);
    EXPECT_LT(velocity.norm(), 0.6);
    EXPECT_LT(rate.norm(), 60.0 * kPi / 180.0);
    if (i > 0) {  // velocity is continuous: accelerations remain those of a hand
      EXPECT_LT((velocity - last_velocity).norm() / kStep, 1.5);
      EXPECT_LT((rate - last_rate).norm() / kStep, 2.0);
    }
    last_velocity = velocity;
    last_rate = rate;
  }
  const Pose gap = path.T_WC(0.0).Inverse() * path.T_WC(duration());
  EXPECT_LT(gap.p().norm(), 1e-9);
  EXPECT_LT(gap.Angle(), 1e-7);
}

TEST_P(RoomPath, StaysClearOfEverything) {
  const Scene room = MakeRoom(seed());
  const Raycaster raycaster(room.mesh);
  const SplineTrajectory path = MakeRoomTrajectory(duration(), seed());
  constexpr int kPoses = 40, kDirections = 800;  // 5 degrees apart on the sphere
  for (int i = 0; i < kPoses; ++i) {
    const Eigen::Vector3d p_WC = path.T_WC(duration() * i / kPoses).p();
    for (int k = 0; k < kDirections; ++k) {
      const double z = 1.0 - (2.0 * k + 1.0) / kDirections,
                   azimuth = k * kPi * (3 - std::sqrt(5.0));
      const double r = std::sqrt(1.0 - z * z);
      const Eigen::Vector3d direction(r * std::cos(azimuth), r * std::sin(azimuth), z);
      const int triangle = raycaster.FirstTriangle(p_WC, direction);
      ASSERT_NE(triangle, Raycaster::kNone) << "the room is closed";
      const Surface& surface = room.surfaces[static_cast<std::size_t>(
          room.surface_of_triangle[static_cast<std::size_t>(triangle)])];
      ASSERT_GT(surface.normal.dot(surface.origin - p_WC) / surface.normal.dot(direction), 0.42);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(DurationsAndSeeds, RoomPath,
                         ::testing::Values(std::pair(10.0, 1), std::pair(20.0, 1),
                                           std::pair(10.0, 2), std::pair(20.0, 2),
                                           std::pair(33.0, 3)));

TEST(Room, IsRichInCornersAndSegmentsAllAround) {
  SimulationOptions options;
  options.duration = 20.0;
  const Simulation room = SimulateRoom(options);
  const auto orb = cv::ORB::create(2000);
  const auto lsd = cv::createLineSegmentDetector();
  for (int i = 0; i < room.size(); i += room.size() / 5) {
    cv::Mat grey;
    cv::cvtColor(room.Render(i).bgr, grey, cv::COLOR_BGR2GRAY);
    std::vector<cv::KeyPoint> corners;
    orb->detect(grey, corners);
    std::vector<cv::Vec4f> segments;
    lsd->detect(grey, segments);
    const auto long_segments = std::count_if(segments.begin(), segments.end(), [](auto& s) {
      return std::hypot(s[0] - s[2], s[1] - s[3]) > 40.0f;
    });
    EXPECT_GE(corners.size(), 500u) << "frame " << i;
    EXPECT_GE(long_segments, 40) << "frame " << i;
  }
}

}  // namespace
}  // namespace highwall::simulate::simulate_test
