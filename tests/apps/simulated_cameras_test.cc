// The cameras that highwall simulate can be given: a depth camera of its own, and images that are
// stored turned by a quarter.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "simulate/camera/simulation.h"
#include "simulate/output/portrait.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::simulate::simulated_cameras_test {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryDirectory;

PinholeCamera Camera(int width, int height, double focal) {
  return {.width = width,
          .height = height,
          .fx = focal,
          .fy = focal,
          .cx = 0.5 * (width - 1),
          .cy = 0.5 * (height - 1)};
}

// No noise, of 0.3 s: three frames.
SimulationOptions Options() {
  SimulationOptions options;
  options.fps = 10.0;
  options.duration = 0.3;
  options.camera = Camera(160, 120, 150.0);
  options.sensor.noise = SensorNoise::kOff;
  options.imu.ideal = true;
  return options;
}

// 4 cm and 2 degrees beside the colour camera, of a wider view and fewer pixels.
DepthCamera Beside() {
  DepthCamera depth{
      .camera = Camera(112, 84, 75.0),
      .T_CD = Pose(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 90.0, Eigen::Vector3d::UnitY())),
                   Eigen::Vector3d(0.04, 0.01, 0.0))};
  depth.camera.k1 = -0.05;
  return depth;
}

// A recording on disk, opened as a user's.
struct Recording {
  SensorCalibration calibration;
  std::unique_ptr<const Dataset> images;
};

Recording WriteAndOpen(const SimulationOptions& options, const fs::path& folder,
                       const TumOptions& tum = {}) {
  WriteTum(SimulateRoom(options), folder, {}, tum);
  const SensorCalibration calibration = ReadSensor(folder / "calibration.yaml");
  return {calibration, OpenDataset(folder, calibration.sensor)};
}

cv::Mat Turned(const cv::Mat& image) {
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  return turned;
}

// Whether the surface is plane for kMargin pixels around: inverse depth is then linear in the
// pixel. It is not seen so obliquely either that its readings count as those of two surfaces
// (DepthRegistration).
bool IsAwayFromEdges(const cv::Mat& depth, int u, int v) {
  constexpr int kMargin = 4;       // [px]
  constexpr double kBend = 2e-5;   // [1/m] rounding of the depth
  constexpr double kSteep = 0.01;  // [relative] from pixel to pixel: half a pixel of depth
  const auto inverse = [&](int x, int y) { return 1.0 / depth.at<float>(y, x); };
  for (int y = v - kMargin; y <= v + kMargin; ++y) {
    for (int x = u - kMargin; x <= u + kMargin; ++x) {
      const double here = inverse(x, y), right = inverse(x + 1, y), below = inverse(x, y + 1);
      if (std::max(std::abs(right - here), std::abs(below - here)) > kSteep * here) return false;
      if (std::abs(inverse(x - 1, y) + right - 2.0 * here) > kBend) return false;
      if (std::abs(inverse(x, y - 1) + below - 2.0 * here) > kBend) return false;
    }
  }
  return true;
}

struct Agreement {
  int pixels = 0;        // away from edges
  int holes = 0;         // among them
  double largest = 0.0;  // [relative] difference of the others
};

Agreement Compare(const cv::Mat& registered, const cv::Mat& expected) {
  constexpr int kBorder = 5;  // [px]
  Agreement agreement;
  for (int v = kBorder; v < expected.rows - kBorder; ++v) {
    for (int u = kBorder; u < expected.cols - kBorder; ++u) {
      if (!IsAwayFromEdges(expected, u, v)) continue;
      ++agreement.pixels;
      const double z = expected.at<float>(v, u), is = registered.at<float>(v, u);
      if (is == 0.0) {
        ++agreement.holes;
      } else {
        agreement.largest = std::max(agreement.largest, std::abs(is - z) / z);
      }
    }
  }
  return agreement;
}

TEST(DepthCameraOfItsOwn, AtTheColourCameraTakesTheSameImages) {
  SimulationOptions options = Options();
  const SimulatedFrame one = SimulateRoom(options).Render(1);
  options.depth_camera = DepthCamera{.camera = options.camera};
  const SimulatedFrame two = SimulateRoom(options).Render(1);
  EXPECT_EQ(cv::norm(one.bgr, two.bgr, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(one.depth, two.depth, cv::NORM_INF), 0.0);
}

TEST(DepthCameraOfItsOwn, LeavesColourAloneAndHasItsOwnSize) {
  SimulationOptions options = Options();
  const SimulatedFrame one = SimulateRoom(options).Render(1);
  options.depth_camera = Beside();
  const SimulatedFrame two = SimulateRoom(options).Render(1);
  EXPECT_EQ(cv::norm(one.bgr, two.bgr, cv::NORM_INF), 0.0);
  EXPECT_EQ(two.depth.size(), cv::Size(112, 84));
}

TEST(DepthCameraOfItsOwn, RegisteredAgreesWithTheDepthOfTheColourCamera) {
  const TemporaryDirectory folder;
  SimulationOptions options = Options();
  const Simulation aligned = SimulateRoom(options);
  options.depth_camera = Beside();
  for (const bool portrait : {false, true}) {
    const Recording own =
        WriteAndOpen(options, folder / (portrait ? "portrait" : "own"), {.portrait = portrait});
    ASSERT_TRUE(own.calibration.sensor.depth_camera);
    ASSERT_EQ(own.images->size(), 3U);
    for (std::size_t i = 0; i < own.images->size(); ++i) {
      const auto image = own.images->Load(i);
      ASSERT_TRUE(image);
      const cv::Mat exact = aligned.Render(static_cast<int>(i)).depth;
      const Agreement agreement = Compare(image->depth, portrait ? Turned(exact) : exact);
      EXPECT_GT(agreement.pixels, 9000) << "of 19,200";
      EXPECT_EQ(agreement.holes, 0);
      EXPECT_LT(agreement.largest, 0.0002);  // half a step of the stored depth is 0.1 mm
    }
  }
}

TEST(Portrait, ACameraProjectsToTheTurnedPixel) {
  PinholeCamera lens = Camera(160, 120, 150.0);
  lens.fy = 151.0;
  lens.cx = 77.0;
  lens.k1 = 0.1;
  lens.k2 = -0.05;
  lens.p1 = 0.01;
  lens.p2 = -0.02;
  lens.k3 = 0.03;
  lens.k4 = 0.02;
  PinholeCamera fisheye = Camera(160, 120, 90.0);
  fisheye.lens = LensModel::kEquidistant;
  fisheye.k1 = 0.05;
  const Eigen::Vector3d p_C(0.3, -0.2, 1.1);
  const Eigen::Vector3d p_P = PortraitPose().Inverse() * p_C;
  for (const PinholeCamera& camera : {lens, fisheye}) {
    const Eigen::Vector2d uv = camera.Project(p_C);
    const PinholeCamera turned = Portrait(camera);
    EXPECT_EQ(turned.width, 120);
    EXPECT_EQ(turned.height, 160);
    EXPECT_LT((turned.Project(p_P) - Eigen::Vector2d(119.0 - uv.y(), uv.x())).norm(), 1e-9);
  }
}

TEST(Portrait, ItsImagesAreTheOthersTurnedByAQuarter) {
  const TemporaryDirectory folder;
  SimulationOptions options = Options();
  options.readout = options.depth_readout = 0.03;
  options.sensor.noise = SensorNoise::kKinect;
  const Recording landscape = WriteAndOpen(options, folder / "landscape");
  const Recording portrait = WriteAndOpen(options, folder / "portrait", {.portrait = true});
  for (std::size_t i = 0; i < landscape.images->size(); ++i) {
    const auto before = landscape.images->Load(i), after = portrait.images->Load(i);
    ASSERT_TRUE(before && after);
    EXPECT_EQ(before->stamp, after->stamp);
    EXPECT_EQ(cv::norm(Turned(before->bgr), after->bgr, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(Turned(before->depth), after->depth, cv::NORM_INF), 0.0);
  }
  // The first row that is read is now the last column.
  EXPECT_EQ(landscape.calibration.sensor.timing.direction, ReadoutDirection::kDown);
  EXPECT_EQ(portrait.calibration.sensor.timing.direction, ReadoutDirection::kLeft);
}

TEST(Portrait, ItsCalibrationAndPosesFitItsImages) {
  const TemporaryDirectory folder;
  SimulationOptions options = Options();
  options.camera.p1 = 0.01;
  options.camera.k1 = -0.1;
  const Recording landscape = WriteAndOpen(options, folder / "landscape");
  const Recording portrait = WriteAndOpen(options, folder / "portrait", {.portrait = true});
  const PinholeCamera &camera = landscape.calibration.sensor.camera,
                      &turned = portrait.calibration.sensor.camera;
  const Trajectory truth = ReadTumTrajectory(folder / "landscape/groundtruth.txt");
  const Trajectory turned_truth = ReadTumTrajectory(folder / "portrait/groundtruth.txt");
  ASSERT_EQ(truth.size(), turned_truth.size());
  const auto before = landscape.images->Load(0), after = portrait.images->Load(0);
  ASSERT_TRUE(before && after);
  const Pose T_WC = truth.front().pose, T_WP = turned_truth.front().pose;
  for (int v = 7; v < 120; v += 35) {
    for (int u = 5; u < 160; u += 30) {
      const double z = before->depth.at<float>(v, u);
      const Eigen::Vector3d p_W = T_WC * camera.Unproject(Eigen::Vector2d(u, v), z);
      const Eigen::Vector3d p_P = T_WP.Inverse() * p_W;
      EXPECT_LT((turned.Project(p_P) - Eigen::Vector2d(119 - v, u)).norm(), 1e-5);
      EXPECT_NEAR(p_P.z(), after->depth.at<float>(u, 119 - v), 1e-5);
    }
  }
  // Both files describe one IMU.
  ASSERT_TRUE(landscape.calibration.imu && portrait.calibration.imu);
  const Pose T_WB = T_WC * landscape.calibration.imu->T_BC.Inverse();
  const Pose turned_T_WB = T_WP * portrait.calibration.imu->T_BC.Inverse();
  EXPECT_TRUE(T_WB.Matrix().isApprox(turned_T_WB.Matrix(), 1e-7));
}

TEST(SimulateCommand, TakesTheCamerasOfACalibrationAndTurnsThem) {
  const TemporaryDirectory folder;
  testing::WriteText(
      folder / "camera.yaml",
      "camera: {width: 320, height: 240, fx: 300, fy: 300, cx: 159.5, cy: 119.5}\n"
      "depth_camera: {width: 224, height: 168, fx: 150, fy: 150, cx: 111.5, cy: 83.5,\n"
      "               T_CD: [1, 0, 0, 0.04, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\n"
      "depth_factor: 5000\n");
  const testing::Outcome outcome = testing::RunProgram(
      testing::kHighwallProgram,
      "simulate room --camera camera.yaml --portrait --scale 0.5 --noise off --fps 10 "
      "--duration 0.1 --out room",
      folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const RgbdSensor sensor = ReadSensor(folder / "room/calibration.yaml").sensor;
  EXPECT_EQ(sensor.camera.width, 120);
  EXPECT_EQ(sensor.camera.height, 160);
  EXPECT_EQ(sensor.camera.fx, 150.0);
  EXPECT_EQ(sensor.timing.direction, ReadoutDirection::kLeft);
  ASSERT_TRUE(sensor.depth_camera);
  EXPECT_EQ(sensor.depth_camera->camera.width, 84);
  EXPECT_EQ(sensor.depth_camera->camera.height, 112);
  // The depth camera is to the right of the colour camera: below it in the turned images.
  EXPECT_LT((sensor.depth_camera->T_CD.p() - Eigen::Vector3d(0, 0.04, 0)).norm(), 1e-12);
  EXPECT_TRUE(OpenDataset(folder / "room", sensor)->Load(0));
}

}  // namespace
}  // namespace highwall::simulate::simulated_cameras_test
