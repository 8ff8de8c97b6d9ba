#include "run/run_output.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/mapping/point_cloud_io.h>

#include "support/file_size_limit.h"
#include "support/temporary_directory.h"

namespace highwall::apps::run_output_test {
namespace {

namespace fs = std::filesystem;
using testing::ReadText;

FrameResult Tracked(int frame, bool keyframe = false) {
  FrameResult result;
  result.stamp = FromSeconds(100.0 + 0.1 * frame);
  result.state = TrackingState::kTracking;
  result.T_WC = Pose(Eigen::Quaterniond::Identity(), {0.1 * frame, 0.0, 0.0});
  if (keyframe) result.mapping.emplace();
  return result;
}

FrameResult Lost(int frame) {
  FrameResult result = Tracked(frame);
  result.state = TrackingState::kLost;
  return result;
}

Trajectory Poses(const std::vector<int>& frames) {
  Trajectory trajectory;
  for (const int frame : frames) trajectory.push_back({Tracked(frame).stamp, Tracked(frame).T_WC});
  return trajectory;
}

class RunOutputTest : public ::testing::Test {
 protected:
  fs::path run() const { return folder_ / "run"; }
  // Returns the stamps in a file as a process killed now would leave it.
  std::vector<Stamp> StampsIn(const char* name) const {
    std::vector<Stamp> stamps;
    for (const StampedPose& pose : ReadTumTrajectory(run() / name)) stamps.push_back(pose.stamp);
    return stamps;
  }
  static std::vector<Stamp> StampsOf(const std::vector<int>& frames) {
    std::vector<Stamp> stamps;
    for (const int frame : frames) stamps.push_back(Tracked(frame).stamp);
    return stamps;
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(RunOutputTest, EveryPoseIsInItsFileBeforeTheNextFrame) {
  RunOutput output(run());
  output.Follow(Lost(0));
  EXPECT_FALSE(fs::exists(run())) << "nothing has been tracked yet";
  output.Follow(Tracked(1, true));
  EXPECT_EQ(StampsIn("trajectory_causal.txt"), StampsOf({1}));
  EXPECT_EQ(StampsIn("keyframes.txt"), StampsOf({1}));
  output.Follow(Tracked(2));
  output.Follow(Lost(3));
  EXPECT_EQ(StampsIn("trajectory_causal.txt"), StampsOf({1, 2}));
  EXPECT_EQ(StampsIn("keyframes.txt"), StampsOf({1}));
  output.Follow(Tracked(4, true));
  EXPECT_EQ(StampsIn("trajectory_causal.txt"), StampsOf({1, 2, 4}));
  EXPECT_EQ(StampsIn("keyframes.txt"), StampsOf({1, 4}));
}

TEST_F(RunOutputTest, FromTheFirstPoseOnNothingOfAnEarlierRunIsLeft) {
  fs::create_directories(run());
  const std::vector<std::string> results = {"run.json",
                                            "trajectory.txt",
                                            "velocities.txt",
                                            "trajectory_causal.txt",
                                            "covariances_causal.txt",
                                            "trajectory_adjusted.txt",
                                            "keyframes.txt",
                                            "cloud.ply",
                                            "map.bt",
                                            "grid.yaml",
                                            "grid.pgm",
                                            "cloud_top.png",
                                            "cloud.png",
                                            "octree_top.png",
                                            "octree.png",
                                            "sparse_map.png",
                                            "report.html",
                                            "map.hwmap",
                                            "trajectory_run1.txt",
                                            "trajectory_run12_2.txt"};
  for (const std::string& name : results) std::ofstream(run() / name) << "earlier";
  for (const char* name : {"notes.txt", "trajectory_runway.txt"}) {
    std::ofstream(run() / name) << "of the user";
  }
  RunOutput output(run());
  output.Follow(Lost(0));
  for (const std::string& name : results) EXPECT_EQ(ReadText(run() / name), "earlier") << name;
  output.Follow(Tracked(1, true));
  for (const std::string& name : results) {
    const bool grows = name == "trajectory_causal.txt" || name == "keyframes.txt";
    EXPECT_EQ(fs::exists(run() / name), grows) << name;
  }
  for (const char* name : {"notes.txt", "trajectory_runway.txt"}) {
    EXPECT_EQ(ReadText(run() / name), "of the user");
  }
}

TEST_F(RunOutputTest, CovariancesAreWrittenForEachPoseIfTheyAreKept) {
  RunOutput without(run());
  without.Follow(Tracked(0));
  EXPECT_FALSE(fs::exists(run() / "covariances_causal.txt"));
  RunOutput output(run());
  output.KeepCovariances();
  for (const int frame : {1, 2}) {
    FrameResult result = Tracked(frame);
    result.uncertainty.emplace().in_map(0, 5) = result.uncertainty->in_map(5, 0) = -2.5e-7;
    output.Follow(result);
    output.Follow(Lost(frame + 10));
  }
  std::ifstream file(run() / "covariances_causal.txt");
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("#")) lines.push_back(line);
  }
  const std::string row = " 0 0 0 0 0 -2.5e-07 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0";
  EXPECT_EQ(lines, (std::vector{FormatStamp(Tracked(1).stamp) + row,
                                FormatStamp(Tracked(2).stamp) + row}));
}

// A run that continues in the map of its own folder must not lose it when it is killed.
TEST_F(RunOutputTest, AMapThatIsLoadedOrSavedIsNotRemoved) {
  fs::create_directories(run());
  const fs::path map = run() / "map.hwmap", same = run() / "../run/map.hwmap";
  std::ofstream(map) << "earlier";
  RunOutput(run(), {}, same).Follow(Tracked(1));
  EXPECT_TRUE(fs::exists(map));
  RunOutput(run(), same).Follow(Tracked(1));
  EXPECT_TRUE(fs::exists(map));
  RunOutput(run(), {}, folder_ / "other.hwmap").Follow(Tracked(1));
  EXPECT_FALSE(fs::exists(map));
}

TEST_F(RunOutputTest, TheTrajectoriesAreThereBeforeTheRestAndTheReportIsLast) {
  RunOutput output(run());
  for (const int frame : {0, 1, 2}) output.Follow(Tracked(frame, true));
  SlamRun result;
  result.largest.causal = Poses({0, 1, 2});
  result.largest.trajectory = Poses({0, 1, 2});
  result.keyframes = Poses({0, 2});
  output.WriteTrajectories(result);
  EXPECT_EQ(StampsIn("trajectory.txt"), StampsOf({0, 1, 2}));
  EXPECT_EQ(StampsIn("keyframes.txt"), StampsOf({0, 2})) << "as they are in the end";
  EXPECT_FALSE(fs::exists(run() / "run.json"));
  const nlohmann::json report = output.WriteRest(result, {{"frames", 3}});
  EXPECT_EQ(report, nlohmann::json::parse(ReadText(run() / "run.json")));
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["frames"], 3);
  EXPECT_FALSE(report.contains("failures"));
  EXPECT_TRUE(output.failures().empty());
}

TEST_F(RunOutputTest, VelocitiesOfEachSubmapAreWrittenWhereThereAreAny) {
  RunOutput output(run());
  output.Follow(Tracked(0, true));
  SlamRun result;
  result.largest.causal = result.largest.trajectory = result.keyframes = Poses({0, 1});
  for (const int frame : {2, 3}) {
    SubmapRun& other = result.others.emplace_back();
    other.causal = other.trajectory = Poses({frame});
  }
  FrameVelocity velocity{Tracked(3).stamp, {0.25, -1.5, 0.125}, {0, 0, 0.5}};
  velocity.covariance.diagonal().setConstant(4e-6);
  velocity.covariance(0, 5) = velocity.covariance(5, 0) = -2.5e-7;
  result.others.back().velocities = {velocity};
  output.WriteTrajectories(result);
  EXPECT_FALSE(fs::exists(run() / "velocities.txt"));
  EXPECT_FALSE(fs::exists(run() / "velocities_2.txt"));
  const std::string text = ReadText(run() / "velocities_3.txt");
  const std::string line =
      FormatStamp(velocity.stamp) +
      " 0.250000 -1.500000 0.125000 0.000000 0.000000 0.500000"
      " 4e-06 0 0 0 0 -2.5e-07 4e-06 0 0 0 0 4e-06 0 0 0 4e-06 0 0 4e-06 0 4e-06\n";
  EXPECT_TRUE(text.starts_with("# stamp")) << text;
  EXPECT_TRUE(text.ends_with('\n' + line)) << text;
}

// The disk is full for a while: data that could not be written then are written at the end.
TEST_F(RunOutputTest, AnInterruptedLogIsWrittenAgainInTheEnd) {
  RunOutput output(run());
  SlamRun result;
  {
    const testing::FileSizeLimit limit(512);
    for (int frame = 0; frame < 20; ++frame) output.Follow(Tracked(frame, frame == 0));
  }
  for (int frame = 0; frame < 30; ++frame) {
    if (frame >= 20) output.Follow(Tracked(frame));
    result.largest.causal.push_back(Poses({frame}).front());
  }
  result.largest.trajectory = result.largest.causal;
  result.keyframes = Poses({0});
  output.WriteTrajectories(result);
  EXPECT_EQ(ReadText(run() / "trajectory_causal.txt"), ReadText(run() / "trajectory.txt"));
  EXPECT_TRUE(output.failures().empty());
}

// A wall of 1 m x 1 m at x metres in front of the camera.
DenseMap Wall(float x) {
  DenseMap dense;
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 400; ++i) {
    points.emplace_back(x, 0.05f * static_cast<float>(i % 20), 0.05f * static_cast<float>(i / 20));
    dense.cloud.push_back({.p = points.back()});
  }
  dense.octree.Insert(points, Pose());
  AddGrid(std::vector<Pose>(1), true, {}, dense);
  return dense;
}

TEST_F(RunOutputTest, SubmapsThatWereNotJoinedHaveMapsOfTheirOwn) {
  fs::create_directories(run());
  for (const char* name : {"cloud_2.ply", "cloud_top_3.png", "grid_12.pgm", "trajectory_4.txt"}) {
    std::ofstream(run() / name) << "earlier";
  }
  for (const char* name : {"cloud_.ply", "cloud_2.txt", "grid_b.pgm", "notes_2.txt"}) {
    std::ofstream(run() / name) << "of the user";
  }
  RunOutput output(run());
  output.Follow(Tracked(0, true));
  SlamRun result;
  result.largest.causal = result.largest.trajectory = result.keyframes = Poses({0, 1});
  result.largest.dense = Wall(1.0f);
  for (const float x : {2.0f, 3.0f}) {
    SubmapRun& other = result.others.emplace_back();
    other.causal = other.trajectory = Poses({static_cast<int>(x)});
    other.dense = Wall(x);
  }
  output.WriteTrajectories(result);
  const nlohmann::json report = output.WriteRest(result, nlohmann::json::object());
  EXPECT_TRUE(output.failures().empty());
  for (const auto& [suffix, x] : {std::pair("", 1.0f), {"_2", 2.0f}, {"_3", 3.0f}}) {
    const auto path = [&, suffix = suffix](const std::string& stem, const char* extension) {
      return run() / (stem + suffix + extension);
    };
    const std::vector<ColoredPoint> cloud = ReadPly(path("cloud", ".ply"));
    ASSERT_EQ(cloud.size(), 400U);
    EXPECT_EQ(cloud[0].p.x(), x);
    const OctomapBuilder octree = OctomapBuilder::Read(path("map", ".bt"));
    EXPECT_EQ(octree.IsOccupied({x, 0.5, 0.5}), true);
    EXPECT_NE(ReadText(path("grid", ".yaml")).find(path("grid", ".pgm").filename().string()),
              std::string::npos);
    EXPECT_TRUE(fs::exists(path("grid", ".pgm")));
    for (const char* picture : {"cloud", "cloud_top", "octree", "octree_top"}) {
      EXPECT_TRUE(fs::exists(path(picture, ".png"))) << picture << suffix;
    }
  }
  EXPECT_EQ(report["map"]["cloud"]["points"], 400);
  EXPECT_EQ(report["submaps"][2]["map"]["cloud"]["points"], 400);
  EXPECT_GT(report["submaps"][1]["map"]["octree"]["file_mb"], 0.0);
  for (const char* name : {"grid_12.pgm", "trajectory_4.txt"}) {
    EXPECT_FALSE(fs::exists(run() / name)) << name;
  }
  for (const char* name : {"cloud_.ply", "cloud_2.txt", "grid_b.pgm", "notes_2.txt"}) {
    EXPECT_EQ(ReadText(run() / name), "of the user") << name;
  }
}

TEST_F(RunOutputTest, FailuresOfTheRunAndOfItsFilesAreAllNamed) {
  RunOutput output(run());
  output.Follow(Tracked(0, true));
  fs::create_directories(run() / "trajectory_adjusted.txt" / "in the way");
  SlamRun result;
  result.largest.causal = result.largest.trajectory = result.largest.adjusted = result.keyframes =
      Poses({0});
  result.failures = {"saved map: no room"};
  output.WriteTrajectories(result);
  const nlohmann::json report = output.WriteRest(result, nlohmann::json::object());
  EXPECT_EQ(report["complete"], false);
  ASSERT_EQ(output.failures().size(), 2U);
  EXPECT_EQ(output.failures()[0], "saved map: no room");
  EXPECT_NE(output.failures()[1].find((run() / "trajectory_adjusted.txt").string() + ": "),
            std::string::npos);
  EXPECT_EQ(report["failures"], nlohmann::json(output.failures()));
  EXPECT_EQ(report, nlohmann::json::parse(ReadText(run() / "run.json")));
}

TEST_F(RunOutputTest, AFolderThatCannotBeMadeIsSaidAtTheFirstPose) {
  std::ofstream(folder_ / "file") << "in the way";
  RunOutput blocked(folder_ / "file" / "run");
  EXPECT_THROW(blocked.Follow(Tracked(0)), IoError);
  RunOutput map_blocked(run(), folder_ / "file" / "room.hwmap");
  EXPECT_THROW(map_blocked.Follow(Tracked(0)), IoError);
}

TEST_F(RunOutputTest, TheFolderOfASavedMapIsMade) {
  RunOutput output(run(), folder_ / "maps" / "deep" / "room.hwmap");
  output.Follow(Lost(0));
  EXPECT_FALSE(fs::exists(folder_ / "maps"));
  output.Follow(Tracked(1));
  EXPECT_TRUE(fs::is_directory(folder_ / "maps" / "deep"));
}

}  // namespace
}  // namespace highwall::apps::run_output_test
