// highwall convert and highwall info on recordings in other formats than TUM RGB-D.
#include <cstdint>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/frontend/input/open_dataset.h>

#include "run/opened_dataset.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::apps::convert_test {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ExpectRefused;
using testing::Outcome;
using testing::ReadText;
using testing::TemporaryDirectory;
using testing::WriteText;

Outcome Highwall(const std::string& arguments) {
  return testing::RunProgram(testing::kHighwallProgram, arguments);
}

// Five frames of Open3D's recorder, 64 x 48, at depths [mm] up to `far`.
void WriteOpen3d(const fs::path& folder, int far) {
  fs::create_directories(folder / "color");
  fs::create_directories(folder / "depth");
  std::string log;
  for (int i = 0; i < 5; ++i) {
    cv::Mat colour(48, 64, CV_8UC3), depth(48, 64, CV_16UC1);
    cv::RNG random(static_cast<std::uint64_t>(i) + 1);
    random.fill(colour, cv::RNG::UNIFORM, 0, 256);
    random.fill(depth, cv::RNG::UNIFORM, 500, far);
    depth.row(3).setTo(0);
    const std::string name = "00000" + std::to_string(i) + ".png";
    cv::imwrite((folder / "color" / name).string(), colour);
    cv::imwrite((folder / "depth" / name).string(), depth);
    const std::string number = std::to_string(i);
    log += number + " " + number + " 5\n1 0 0 " + number + "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  }
  WriteText(folder / "trajectory.log", log);
  WriteText(folder / "camera_intrinsic.json",
            R"({"width": 64, "height": 48, "intrinsic_matrix": [50,0,0,0,50,0,31,23,1]})");
  WriteText(folder / "imu.csv",
            "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n"
            "0.01, -9.8, 0.5, 0.25, 0.1, 0.2, 0.3\n0.02, -9.8, 0.5, 0.25, 0.1, 0.2, 0.3\n");
}

// The copy has the frames, the camera and the poses of the original.
void ExpectSame(const fs::path& original, const fs::path& copy, const DatasetOptions& options) {
  const OpenedDataset a = OpenWithConfig("", original, options), b = OpenWithConfig("", copy);
  EXPECT_EQ(FindDatasetReader(copy)->format, "TUM RGB-D");
  ASSERT_EQ(a.images->size(), b.images->size());
  EXPECT_TRUE(b.images->warnings().empty());
  EXPECT_EQ(a.config.sensor.camera.fx, b.config.sensor.camera.fx);
  EXPECT_EQ(a.config.sensor.camera.cy, b.config.sensor.camera.cy);
  for (std::size_t i = 0; i < a.images->size(); ++i) {
    EXPECT_EQ(a.images->stamp(i), b.images->stamp(i));
    const auto from = a.images->Load(i), to = b.images->Load(i);
    ASSERT_TRUE(from && to);
    EXPECT_EQ(cv::norm(from->bgr, to->bgr, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(from->depth, to->depth, cv::NORM_INF), 0.0);
  }
  ASSERT_NE(b.images->groundtruth(), nullptr);
  ASSERT_EQ(a.images->groundtruth()->size(), b.images->groundtruth()->size());
  for (std::size_t i = 0; i < a.images->groundtruth()->size(); ++i) {
    const StampedPose &from = a.images->groundtruth()->at(i), &to = b.images->groundtruth()->at(i);
    EXPECT_EQ(from.stamp, to.stamp);
    EXPECT_TRUE(from.pose.Matrix().isApprox(to.pose.Matrix(), 1e-8));
  }
}

TEST(Convert, TheCopyHasTheSameFrames) {
  for (const int far : {4000, 30000}) {
    const TemporaryDirectory folder("to" + std::to_string(far));
    const fs::path original = folder / "scan", copy = folder / "copy";
    WriteOpen3d(original, far);
    const Outcome outcome =
        Highwall("convert " + original.string() + " " + copy.string() + " --fps 10");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(Contains(outcome.out, "frames      5 of 5, depth factor 1000")) << outcome.out;
    EXPECT_TRUE(Contains(outcome.err, "10 frames a second are assumed")) << outcome.err;
    ExpectSame(original, copy, {.frame_rate = 10.0});
  }
}

TEST(Convert, ReadingsAreWrittenInTheUnitsAndSignsOfTheReader) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder / "scan", 4000);
  const Outcome outcome =
      Highwall("convert " + folder.path().string() + "/scan " + folder.path().string() + "/copy");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(ReadText(folder / "copy/imu.csv"),
            "#timestamp [ns],wx [rad/s],wy,wz,ax [m/s^2],ay,az\n"
            "10000000,0.1,0.2,0.3,9.8,-0.5,-0.25\n20000000,0.1,0.2,0.3,9.8,-0.5,-0.25\n");
}

// Two frames of Stray Scanner, of which the first has depth of this confidence.
void WriteStray(const fs::path& folder, int confidence) {
  for (const char* const kind : {"rgb", "depth", "confidence"})
    fs::create_directories(folder / kind);
  for (const char* const name : {"000000.png", "000001.png"}) {
    cv::imwrite((folder / "rgb" / name).string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar(1, 2, 3)));
    cv::imwrite((folder / "depth" / name).string(), cv::Mat(12, 16, CV_16UC1, cv::Scalar(1500)));
    cv::imwrite((folder / "confidence" / name).string(), cv::Mat(12, 16, CV_8UC1, cv::Scalar(2)));
  }
  cv::imwrite((folder / "confidence/000000.png").string(),
              cv::Mat(12, 16, CV_8UC1, cv::Scalar(confidence)));
  WriteText(folder / "odometry.csv",
            "timestamp, frame, x, y, z, qx, qy, qz, qw\n1.0, 000000, 0, 0, 0, 0, 0, 0, 1\n"
            "1.5, 000001, 0, 0, 0, 0, 0, 0, 1\n");
  WriteText(folder / "camera_matrix.csv", "45 0 32\n0 45 24\n0 0 1\n");
}

TEST(Convert, SaysThatTheLayoutCannotStateConfidence) {
  for (const int confidence : {1, 2}) {
    const TemporaryDirectory folder("confidence" + std::to_string(confidence));
    WriteStray(folder / "scan", confidence);
    const Outcome outcome =
        Highwall("convert " + (folder / "scan").string() + " " + (folder / "copy").string());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(Contains(outcome.out, "confidence  left out of 1 frames: "), confidence == 1)
        << outcome.out;
  }
}

TEST(Convert, AFrameThatCannotBeReadIsLeftOutAndNamed) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder / "scan", 4000);
  WriteText(folder / "scan/depth/000002.png", "no image");
  const Outcome outcome =
      Highwall("convert " + folder.path().string() + "/scan " + folder.path().string() + "/copy");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "frames      4 of 5")) << outcome.out;
  EXPECT_TRUE(Contains(outcome.err, "warning: frame 2 is left out: ")) << outcome.err;
  EXPECT_EQ(OpenDataset(folder / "copy")->size(), 4U);
}

TEST(Convert, RefusesAFolderThatHoldsSomethingAndLeavesNothingBehind) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder / "scan", 4000);
  const std::string scan = (folder / "scan").string();
  const Outcome outcome = Highwall("convert " + scan + " " + scan);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "scan: exists and is not empty: choose another folder"))
      << outcome.err;
  ExpectRefused(
      Highwall("convert " + (folder / "nowhere").string() + " " + (folder / "b").string()), 2,
      {"nowhere: does not exist"});
  EXPECT_EQ(folder.FileCount(), 1U);
}

TEST(Info, NamesTheFormatTheCameraAndTheMissingStamps) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder / "scan", 4000);
  fs::remove(folder / "scan/imu.csv");
  fs::remove(folder / "scan/depth/000004.png");
  const Outcome outcome = Highwall("info " + folder.path().string() + "/scan --fps 5 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json info = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(info["format"], "Open3D");
  EXPECT_EQ(info["frames"], 4);
  EXPECT_EQ(info["colour"]["count"], 5);
  EXPECT_EQ(info["rate"], 5.0);
  EXPECT_EQ(info["depth_factor"], 1000.0);
  EXPECT_NEAR(info["median_depth"].get<double>(), 2.25, 0.1);
  EXPECT_EQ(info["calibration"]["name"], "camera_intrinsic.json");
  EXPECT_EQ(info["calibration"]["confidence"], "stated");
  EXPECT_EQ(info["groundtruth"]["count"], 5);
  EXPECT_TRUE(Contains(info["problems"][0].get<std::string>(), "has no stamps"));
}

TEST(OpenWithConfig, ACalibrationThatIsGivenReplacesTheStatedOne) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path(), 4000);
  EXPECT_EQ(OpenWithConfig("", folder.path()).config.sensor.camera.fx, 50.0);
  EXPECT_EQ(OpenWithConfig("", folder.path()).origin, "camera_intrinsic.json");
  const std::string camera = "camera: {width: 64, height: 48, fx: 51, fy: 51, cx: 31, cy: 23}\n";
  WriteText(folder / "calibration.yaml", camera + "depth_factor: 500\n");
  const OpenedDataset opened = OpenWithConfig("", folder.path());
  EXPECT_EQ(opened.config.sensor.camera.fx, 51.0);
  EXPECT_EQ(opened.origin, (folder / "calibration.yaml").string());
  EXPECT_GT(opened.images->Load(0)->depth.at<float>(1, 1), 0.99F);
}

}  // namespace
}  // namespace highwall::apps::convert_test
