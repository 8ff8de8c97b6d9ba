#include <highwall/frontend/input/euroc_dataset.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/open_dataset.h>

#include "support/temporary_directory.h"

namespace highwall::euroc_dataset_test {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal = 250.0, kBaseline = 0.12;  // [px], [m]

std::string CameraYaml(double x, const std::string& distortion = "[0, 0, 0, 0]",
                       const std::string& model = "pinhole") {
  return "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " + std::to_string(x) +
         ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 20\nresolution: [320, 240]\n"
         "camera_model: " +
         model +
         "\nintrinsics: [250, 250, 159.5, 119.5]\ndistortion_model: radial-tangential\n"
         "distortion_coefficients: " +
         distortion + "\n";
}

void Write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

// Three frames of a wall of noise `distance` [m] ahead; the IMU lies 0.5 m behind the left camera.
class Euroc : public ::testing::Test {
 protected:
  void SetUp() override {
    cv::Mat wall(kHeight, 2 * kWidth, CV_8UC1);
    cv::RNG rng(3);
    rng.fill(wall, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(wall, wall, {5, 5}, 1.2);
    std::string list = "#timestamp [ns],filename\r\n";
    for (int i = 0; i < 3; ++i) {
      const std::string stamp = std::to_string(1'000'000'000 + i * 50'000'000);
      list += stamp + "," + stamp + ".png\r\n";
      fs::create_directories(root() / "cam0" / "data");
      fs::create_directories(root() / "cam1" / "data");
      cv::imwrite((root() / "cam0" / "data" / (stamp + ".png")).string(),
                  wall(cv::Rect(100, 0, kWidth, kHeight)));
      // A pixel that the left camera sees at u, the right one sees at u - disparity.
      cv::imwrite((root() / "cam1" / "data" / (stamp + ".png")).string(),
                  wall(cv::Rect(100 + kDisparity, 0, kWidth, kHeight)));
    }
    for (const char* camera : {"cam0", "cam1"}) Write(root() / camera / "data.csv", list);
    Write(root() / "cam0" / "sensor.yaml", CameraYaml(0.5));
    Write(root() / "cam1" / "sensor.yaml", CameraYaml(0.5 + kBaseline));
  }
  fs::path root() const { return folder_.path() / "mav0"; }
  void ExpectRefused(const std::string& file, const std::string& what) const {
    try {
      const EurocDataset dataset(folder_.path());
      FAIL() << "accepted, but " << what;
    } catch (const IoError& error) {
      EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    }
  }

  static constexpr int kDisparity = 15;  // 2 m
  const testing::TemporaryDirectory folder_;
};

TEST_F(Euroc, DepthIsThatOfTheDisparityOfBothImages) {
  for (const fs::path& directory : {folder_.path(), root()}) {
    ASSERT_TRUE(EurocDataset::IsOne(directory));
    const EurocDataset dataset(directory);
    ASSERT_EQ(dataset.size(), 3U);
    EXPECT_EQ(dataset.stamp(1), 1'050'000'000);
    EXPECT_FALSE(dataset.imu_file().has_value());
    EXPECT_FALSE(dataset.imu().has_value());
    EXPECT_EQ(dataset.groundtruth(), nullptr);
    const auto image = dataset.Load(1);
    ASSERT_TRUE(image.has_value());
    const double depth = kFocal * kBaseline / kDisparity;
    int near = 0, measured = 0;
    for (int v = 20; v < kHeight - 20; ++v) {
      for (int u = 100; u < kWidth - 20; ++u) {  // further left is outside of the right image
        const double z = image->depth.at<float>(v, u);
        measured += z > 0.0;
        near += std::abs(z - depth) < 0.25 / kDisparity * depth;  // a quarter of a pixel
      }
    }
    EXPECT_GT(measured, 30'000) << "of 40,000";
    EXPECT_GT(near, 95 * measured / 100);
  }
}

TEST_F(Euroc, IsOpenedByItsLayoutWithItsOwnCalibration) {
  // The sensor given is of no use to a recording that states its own.
  const std::unique_ptr<Dataset> dataset = OpenDataset(folder_.path(), RgbdSensor());
  EXPECT_EQ(dataset->size(), 3U);
  ASSERT_NE(dataset->calibration(), nullptr);
  EXPECT_EQ(dataset->calibration()->sensor.camera.width, kWidth);
  EXPECT_FALSE(dataset->calibration()->imu);
  EXPECT_TRUE(dataset->Load(0));
}

TEST_F(Euroc, TheSensorIsTheRectifiedLeftCamera) {
  const EurocDataset dataset(folder_.path());
  const RgbdSensor& sensor = dataset.sensor();
  EXPECT_EQ(sensor.camera.width, kWidth);
  EXPECT_NEAR(sensor.camera.fx, kFocal, 1e-6);
  EXPECT_NEAR(sensor.camera.fy, kFocal, 1e-6);
  // A quarter of a pixel at 2 m.
  EXPECT_NEAR(sensor.depth_noise.Sigma(2.0), 0.25 * 4.0 / (kFocal * kBaseline), 1e-9);
}

TEST_F(Euroc, ReadsTheImuAndTheTruthOfTheCamera) {
  Write(root() / "imu0" / "data.csv", "#t,w,w,w,a,a,a\n1000000000,0,0,0,0,0,9.81\n");
  Write(root() / "imu0" / "sensor.yaml",
        "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]\n"
        "rate_hz: 400\ngyroscope_noise_density: 1e-4\ngyroscope_random_walk: 2e-5\n"
        "accelerometer_noise_density: 3e-3\naccelerometer_random_walk: 4e-3\n");
  Write(root() / "state_groundtruth_estimate0" / "data.csv",
        "#t,p,p,p,q,q,q,q\n1000000000,1,2,3,0,0,0,1,0,0,0\n");
  const EurocDataset dataset(folder_.path());
  ASSERT_TRUE(dataset.imu().has_value());
  EXPECT_EQ(dataset.imu_file(), root() / "imu0" / "data.csv");
  EXPECT_EQ(dataset.imu()->noise.gyroscope, 1e-4);
  EXPECT_EQ(dataset.imu()->noise.accelerometer_walk, 4e-3);
  EXPECT_EQ(dataset.imu()->rate, 400.0);
  EXPECT_LT((dataset.imu()->T_BC.p() - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-9);
  ASSERT_NE(dataset.groundtruth(), nullptr);
  // Half a turn about z: the camera is 0.5 m to the other side.
  EXPECT_LT((dataset.groundtruth()->at(0).pose.p() - Eigen::Vector3d(0.5, 2, 3)).norm(), 1e-9);
}

TEST_F(Euroc, WarnsOnceOfATruthThatCannotBeReadAndGoesWithoutIt) {
  for (const std::string bad : {"", "1000000000,1,2,3\n", "1000000000,nan,2,3,1,0,0,0\n",
                                "1000000000,1,2,3,0,0,0,0\n", "1.0 1\n"}) {
    SCOPED_TRACE(bad);
    Write(root() / "state_groundtruth_estimate0" / "data.csv", "#t,p,p,p,q,q,q,q\n" + bad);
    const EurocDataset dataset(folder_.path());
    EXPECT_EQ(dataset.size(), 3U);
    EXPECT_EQ(dataset.groundtruth(), nullptr);
    ASSERT_EQ(dataset.warnings().size(), 1U);
    EXPECT_TRUE(dataset.warnings()[0].ends_with("; the ground truth is not used"))
        << dataset.warnings()[0];
  }
}

TEST_F(Euroc, AFrameThatCannotBeReadIsSkippedAndNamed) {
  Write(root() / "cam1" / "data" / "1050000000.png", "no image");
  const EurocDataset dataset(folder_.path());
  EXPECT_TRUE(dataset.Load(0).has_value());
  EXPECT_FALSE(dataset.Load(1).has_value());
  ASSERT_EQ(dataset.problems().size(), 1U);
  EXPECT_NE(dataset.problems()[0].what.find("cam1/data/1050000000.png"), std::string::npos);
}

TEST_F(Euroc, ImagesOfOneCameraAloneAreLeftOutWithAWarning) {
  Write(root() / "cam1" / "data.csv", "1000000000,1000000000.png\n1050000000,1050000000.png\n");
  const EurocDataset dataset(folder_.path());
  EXPECT_EQ(dataset.size(), 2U);
  ASSERT_EQ(dataset.warnings().size(), 1U);
  EXPECT_NE(dataset.warnings()[0].find("1 of 3 images"), std::string::npos);
}

TEST_F(Euroc, RefusesUnusableFilesByName) {
  EXPECT_FALSE(EurocDataset::IsOne(folder_.path() / "nowhere"));
  const fs::path yaml = root() / "cam1" / "sensor.yaml";
  Write(yaml, CameraYaml(0.5 + kBaseline, "[0, 0, 0, 0]", "omni"));
  ExpectRefused("cam1/sensor.yaml:8", "the camera model 'omni' is not known");
  std::string fisheye = CameraYaml(0.5 + kBaseline);
  fisheye.replace(fisheye.find("radial-tangential"), 17, "equidistant");
  Write(yaml, fisheye);
  ExpectRefused("cam1/sensor.yaml:10", "only pinhole with radial-tangential is known");
  Write(yaml, CameraYaml(0.5 + kBaseline, "[0, 0, x]"));
  ExpectRefused("cam1/sensor.yaml", "'distortion_coefficients' must be a list of 4 finite numbers");
  Write(yaml,
        "%YAML:1.0\nT_BS: 3\nresolution: [320, 240]\ncamera_model: pinhole\n"
        "intrinsics: [250, 250, 159.5, 119.5]\ndistortion_model: radial-tangential\n"
        "distortion_coefficients: [0, 0, 0, 0]\n");
  ExpectRefused("cam1/sensor.yaml", "'T_BS' must be a list of 16 finite numbers");
  Write(yaml, CameraYaml(0.5 - kBaseline));
  ExpectRefused("cam1/sensor.yaml", "to the right");
  Write(yaml, "%YAML:1.0\n{[");
  ExpectRefused("cam1/sensor.yaml", "");
  fs::remove(yaml);
  ExpectRefused("cam1/sensor.yaml", "is missing");
  Write(yaml, CameraYaml(0.5 + kBaseline));
  Write(root() / "cam1" / "data.csv", "1000000000\n");
  ExpectRefused("cam1/data.csv:1", "expected a stamp");
  Write(root() / "cam1" / "data.csv", "7,7.png\n");
  ExpectRefused("mav0", "share a stamp");
}

}  // namespace
}  // namespace highwall::euroc_dataset_test
