// Runs `highwall live` with the file device of OpenNI 2 as its camera.
#include <signal.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/open_dataset.h>

#include "support/oni_file.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::live_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::BackgroundProgram;
using testing::Outcome;
using testing::ReadText;

constexpr int kFrames = 24;

Outcome Highwall(const std::string& arguments) {
  return testing::RunProgram(testing::kHighwallProgram, arguments);
}

bool IsEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

// A walk through a room, filmed by a camera of OpenNI.
class Live : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new testing::TemporaryDirectory();
    testing::WriteSmallRoom(*folder_ / "room", kFrames);
    const auto room =
        OpenDataset(*folder_ / "room", ReadSensor(*folder_ / "room/calibration.yaml").sensor);
    const PinholeCamera camera = testing::SmallRoomOptions().camera;
    file_ = new testing::OniFile;
    file_->horizontal_field_of_view = 2.0 * std::atan(0.5 * camera.width / camera.fx);
    file_->vertical_field_of_view = 2.0 * std::atan(0.5 * camera.height / camera.fy);
    for (std::size_t i = 0; i < room->size(); ++i) {
      const RgbdImage image = room->Load(i).value();
      testing::OniFrame frame;
      cv::cvtColor(image.bgr, frame.rgb, cv::COLOR_BGR2RGB);
      image.depth.convertTo(frame.depth, CV_16U, 1000.0);
      file_->frames.push_back(frame);
    }
    WriteCamera("camera.oni", 100'000);
  }
  static void TearDownTestSuite() {
    delete file_;
    delete folder_;
  }
  // interval: [us] between two images.
  static void WriteCamera(const std::string& name, std::uint64_t interval) {
    for (std::size_t i = 0; i < file_->frames.size(); ++i) {
      file_->frames[i].microseconds = 1'000'000 + i * interval;
    }
    testing::WriteOni(*folder_ / name, *file_);
  }

  ~Live() override {
    for (const fs::path& path : {run(), recording()}) fs::remove_all(path);
  }
  static std::string Camera(const std::string& name = "camera.oni") {
    return "openni2:" + (*folder_ / name).string();
  }
  static fs::path run() { return *folder_ / "run"; }
  static fs::path recording() { return *folder_ / "recording"; }
  static json Report() { return json::parse(ReadText(run() / "run.json")); }
  // Expects that each recorded image is one of the camera, in their order.
  static void ExpectRecorded(std::size_t images);

  static testing::TemporaryDirectory* folder_;
  static testing::OniFile* file_;
};

testing::TemporaryDirectory* Live::folder_ = nullptr;
testing::OniFile* Live::file_ = nullptr;

void Live::ExpectRecorded(std::size_t images) {
  const auto recorded =
      OpenDataset(recording(), ReadSensor(recording() / "calibration.yaml").sensor);
  EXPECT_EQ(recorded->size(), images);
  std::size_t next = 0;
  for (std::size_t i = 0; i < recorded->size(); ++i) {
    const auto image = recorded->Load(i);
    ASSERT_TRUE(image);
    cv::Mat rgb;
    cv::cvtColor(image->bgr, rgb, cv::COLOR_BGR2RGB);
    while (next < file_->frames.size() && !IsEqual(rgb, file_->frames[next].rgb)) ++next;
    ASSERT_LT(next, file_->frames.size()) << i;
    EXPECT_TRUE(IsEqual(image->depth, MetricDepth(file_->frames[next].depth, 1000.0))) << i;
  }
}

TEST_F(Live, ARunOfACameraEndsWithItAndItsRecordingRunsAgain) {
  const Outcome outcome = Highwall("live --camera " + Camera() + " --out " + run().string() +
                                   " --record " + recording().string() + " --resolution 0.1");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("live        "), std::string::npos) << outcome.out;
  const json report = Report();
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["camera"], Camera());
  EXPECT_EQ(report["options"]["live"], true);
  EXPECT_FALSE(report.contains("stopped"));
  const auto frames = report["frames"].get<std::size_t>();
  EXPECT_GE(frames, 3U);
  EXPECT_EQ(report["recorded"]["images"].get<std::size_t>(),
            frames + report["dropped_frames"].get<std::size_t>());
  EXPECT_EQ(report["dataset"], recording().string());
  for (const char* const name : {"trajectory.txt", "trajectory_causal.txt", "keyframes.txt",
                                 "map.bt", "cloud.ply", "grid.yaml", "map.hwmap"}) {
    EXPECT_TRUE(fs::exists(run() / name)) << name;
  }
  ExpectRecorded(report["recorded"]["images"].get<std::size_t>());
  const Outcome again = Highwall("slam --dataset " + recording().string() + " --out " +
                                 (*folder_ / "again").string() + " --deterministic --no-map");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(ReadTumTrajectory(*folder_ / "again" / "trajectory.txt").size(),
            report["recorded"]["images"].get<std::size_t>());
  const Outcome map = Highwall("map " + run().string() + " --out " + (*folder_ / "map").string());
  EXPECT_EQ(map.exit_code, 0) << map.err;
}

// The camera is slow: the signal comes while the run waits for an image.
TEST_F(Live, ASignalEndsTheRunWithEveryOutputComplete) {
  WriteCamera("slow.oni", 400'000);
  for (const int signal : {SIGINT, SIGTERM}) {
    SCOPED_TRACE(signal);
    for (const fs::path& path : {run(), recording()}) fs::remove_all(path);
    BackgroundProgram program(testing::kHighwallProgram,
                              {"live", "--camera", Camera("slow.oni"), "--out", run().string(),
                               "--record", recording().string(), "--report"});
    while (program.IsRunning() &&
           testing::CountLines(ReadText(run() / "trajectory_causal.txt")) < 4) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(program.IsRunning());
    program.Send(signal);
    EXPECT_EQ(program.ExitCode(), 128 + signal);
    const json report = Report();
    EXPECT_EQ(report["complete"], true);
    const auto frames = report["frames"].get<std::size_t>();
    EXPECT_LT(frames, static_cast<std::size_t>(kFrames));
    EXPECT_EQ(report["stopped"]["signal"], signal == SIGINT ? "SIGINT" : "SIGTERM");
    EXPECT_EQ(report["stopped"]["frames_done"],
              frames + report["dropped_frames"].get<std::size_t>());
    EXPECT_EQ(ReadTumTrajectory(run() / "trajectory.txt").size(),
              ReadTumTrajectory(run() / "trajectory_causal.txt").size());
    for (const char* const name : {"map.bt", "cloud.ply", "map.hwmap", "report.html"}) {
      EXPECT_TRUE(fs::exists(run() / name)) << name;
    }
    ExpectRecorded(report["recorded"]["images"].get<std::size_t>());
  }
}

// A settings file of ORB-SLAM2 does not state the size.
TEST_F(Live, ACalibrationWithoutASizeIsForTheImagesOfTheCamera) {
  const PinholeCamera camera = testing::SmallRoomOptions().camera;
  const fs::path file = *folder_ / "orb.yaml";
  testing::WriteText(file, fmt::format("%YAML:1.0\nCamera.fx: {}\nCamera.fy: {}\nCamera.cx: {}\n"
                                       "Camera.cy: {}\nDepthMapFactor: 1000.0\n",
                                       camera.fx, camera.fy, camera.cx, camera.cy));
  const Outcome outcome = Highwall("live --camera " + Camera() + " --out " + run().string() +
                                   " --config " + file.string() + " --seconds 1.2 --no-map");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find(
                fmt::format("(for {} x {}, the size of the images)", camera.width, camera.height)),
            std::string::npos)
      << outcome.err;
}

TEST_F(Live, SecondsEndARunThatIsAsGoodAsAnyOther) {
  const Outcome outcome = Highwall("live --camera " + Camera() + " --out " + run().string() +
                                   " --seconds 1.2 --no-map --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_LT(report["frames"].get<std::size_t>() + report["dropped_frames"].get<std::size_t>(),
            static_cast<std::size_t>(kFrames));
  EXPECT_FALSE(report.contains("stopped"));
  EXPECT_EQ(report["dataset"], "");
}

TEST_F(Live, WithoutACameraOneLineSaysWhatToDo) {
  if (Highwall("live --list").exit_code == 0) GTEST_SKIP() << "a camera is connected";
  for (const std::string& arguments :
       {std::string("live --list"), "live --camera openni2 --out " + run().string()}) {
    testing::ExpectRefused(Highwall(arguments), 1, {"OpenNI 2 finds no camera: plug one in"});
  }
  EXPECT_FALSE(fs::exists(run()));
}

TEST_F(Live, WhatCannotBeUsedIsRefusedBeforeTheRun) {
  const std::string out = " --out " + run().string();
  testing::ExpectRefused(Highwall("live --camera webcam" + out), 1,
                         {"must be openni2, openni2:URI or openni2:FILE.oni"});
  testing::ExpectRefused(
      Highwall("live --camera openni2:" + (*folder_ / "none.oni").string() + out), 2,
      {"none.oni: is no recording of OpenNI 2"});
  testing::ExpectRefused(Highwall("live --camera " + Camera() + out + " --imu paper"), 2,
                         {"--imu asks for an IMU, which this camera does not have"});
  testing::ExpectRefused(
      Highwall("live --camera " + Camera() + out + " --record " + folder_->path().string()), 2,
      {"has content already: record to a new folder"});
  testing::ExpectRefused(Highwall("live" + out), 1, {"--camera"});
}

}  // namespace
}  // namespace highwall::live_test
