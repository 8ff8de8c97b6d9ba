// Runs `highwall merge` on the results of `highwall slam` for sessions in generated rooms.
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/map/map.h>

#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::merge_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::ExpectRefused;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

constexpr double kFps = 10.0;
constexpr double kLater = 1000.0;  // [s] offset of the second session to the first

// Two sessions in a room that share half of their views, the second of them at another time and at
// the same time, and one session in another room.
class MergeTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<testing::TemporaryDirectory>("_merge");
    WriteSequence(5, "room", 7.0);
    WriteSequence(6, "elsewhere", 3.0);
    Cut("room", "monday", 0, 40, 0.0);
    Cut("room", "tuesday", 25, 70, kLater);
    Cut("room", "meanwhile", 25, 70, 0.0);
    for (const char* session : {"monday", "tuesday", "meanwhile", "elsewhere"}) Slam(session);
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static void WriteSequence(unsigned seed, const std::string& name, double seconds) {
    simulate::SimulationOptions options;
    options.seed = seed;
    options.duration = seconds;
    options.fps = kFps;
    options.imu.enabled = false;
    options.camera = {
        .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
    const simulate::Simulation room(simulate::MakeRoom(seed),
                                    simulate::MakeRoomTrajectory(10.0, seed), options);
    simulate::WriteTum(room, *folder_ / name);
  }
  // Copies frames of a sequence to a separate recording, `later` [s].
  static void Cut(const std::string& sequence, const std::string& session, int begin, int end,
                  double later) {
    const fs::path from = *folder_ / sequence, to = *folder_ / session;
    fs::create_directories(to);
    fs::create_directory_symlink(from / "rgb", to / "rgb");
    fs::create_directory_symlink(from / "depth", to / "depth");
    fs::copy_file(from / "calibration.yaml", to / "calibration.yaml");
    for (const char* list : {"rgb.txt", "depth.txt"}) {
      std::istringstream lines(ReadText(from / list));
      std::string kept, line;
      for (int i = 0; std::getline(lines, line);) {
        if (line.starts_with('#')) continue;
        const std::size_t blank = line.find(' ');
        const Stamp stamp = *ParseStamp(line.substr(0, blank)) + FromSeconds(later);
        if (i >= begin && i < end) kept += FormatStamp(stamp) + line.substr(blank) + "\n";
        ++i;
      }
      WriteText(to / list, kept);
    }
  }
  static void Slam(const std::string& session) {
    const Outcome outcome =
        In("slam --deterministic --no-map --dataset " + session + " --out run_" + session);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  static Outcome In(const std::string& arguments) {
    return testing::RunProgram(testing::kHighwallProgram, arguments, folder_->path());
  }
  static Trajectory Read(const std::string& file) { return ReadTumTrajectory(*folder_ / file); }
  static json Report(const std::string& folder) {
    return json::parse(ReadText(*folder_ / (folder + "/run.json")));
  }
  // Returns the ground truth of both sessions in one world.
  static Trajectory Truth() {
    Trajectory truth = Read("room/groundtruth.txt");
    const std::size_t once = truth.size();
    for (std::size_t i = 0; i < once; ++i) {
      truth.push_back({truth[i].stamp + FromSeconds(kLater), truth[i].pose});
    }
    return truth;
  }

  static std::unique_ptr<testing::TemporaryDirectory> folder_;
};

std::unique_ptr<testing::TemporaryDirectory> MergeTest::folder_;

TEST_F(MergeTest, SessionsOfOneRoomBecomeOneMapWithEveryFrameInIt) {
  const Outcome outcome = In("merge run_monday run_tuesday --out office");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(Contains(outcome.out, "one: all keyframes share a world")) << outcome.out;
  const Trajectory all = Read("office/trajectory.txt");
  EXPECT_EQ(all.size(), 40U + 45U);
  EXPECT_EQ(Read("office/trajectory_run1.txt").size(), 40U);
  EXPECT_EQ(Read("office/trajectory_run2.txt").size(), 45U);
  // Each session alone has 3 to 4 mm; both share one alignment.
  EXPECT_LT(AbsolutePoseError(Truth(), all).statistics.rmse, 0.01);
  const SavedMap map = LoadMap(*folder_ / "office/map.hwmap");
  EXPECT_EQ(map.map.roots().size(), 1U);
  EXPECT_EQ(map.map.num_keyframes(), Read("office/keyframes.txt").size());

  const json report = Report("office");
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["runs"][1]["name"], "run_tuesday");
  EXPECT_EQ(report["runs"][1]["frames"], 45);
  EXPECT_EQ(report["runs"][1]["frames_left_out"], 0);
  EXPECT_EQ(report["submaps"].size(), 1U);
  EXPECT_EQ(report["submaps"][0]["runs"], json({1, 2}));
  EXPECT_EQ(report["loops"]["merges"], 1);
  EXPECT_TRUE(fs::exists(*folder_ / "office/sparse_map.png"));
}

// A keyframe is a frame: both follow the same map, to the digits of the files.
TEST_F(MergeTest, FramesKeepTheirPlaceBesideTheirKeyframes) {
  ASSERT_EQ(In("merge run_monday run_tuesday --out kept").exit_code, 0);
  const Trajectory before = Read("run_tuesday/trajectory.txt");
  const Trajectory after = Read("kept/trajectory_run2.txt");
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 1; i < before.size(); ++i) {
    const Pose step = before[i - 1].pose.Inverse() * before[i].pose;
    const Pose now = after[i - 1].pose.Inverse() * after[i].pose;
    EXPECT_EQ(before[i].stamp, after[i].stamp);
    // The adjustment moves keyframes, which are some 6 cm apart, by this much.
    EXPECT_LT((step.p() - now.p()).norm(), 0.015) << i;
  }
}

TEST_F(MergeTest, WhereStampsOverlapOneTrajectoryHoldsOneSession) {
  const Outcome outcome = In("merge run_monday run_meanwhile --out overlap");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "overlap: trajectory.txt is that of run_meanwhile"))
      << outcome.out;
  EXPECT_TRUE(ReadText(*folder_ / "overlap/trajectory.txt") ==
              ReadText(*folder_ / "overlap/trajectory_run2.txt"));
  EXPECT_EQ(Read("overlap/trajectory_run1.txt").size(), 40U);
  const json report = Report("overlap");
  EXPECT_EQ(report["submaps"][0]["runs"], json({1, 2}));
  EXPECT_EQ(report["submaps"][0]["runs_in_trajectory"], json({2}));
}

TEST_F(MergeTest, SessionsOfTwoRoomsStayApartAndItIsSaid) {
  const Outcome outcome = In("merge run_monday run_elsewhere --out apart");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "2 separate worlds")) << outcome.out;
  EXPECT_TRUE(Contains(outcome.out, "apart       run_elsewhere: ")) << outcome.out;
  const Trajectory before = Read("run_monday/trajectory.txt"), after = Read("apart/trajectory.txt");
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    // A session without a match stays as it is, except for the digits of the files.
    EXPECT_LT((before[i].pose.p() - after[i].pose.p()).norm(), 1e-8) << i;
  }
  EXPECT_EQ(Read("apart/trajectory_2.txt").size(), 30U);
  EXPECT_FALSE(fs::exists(*folder_ / "apart/trajectory_run2.txt")) << "none of it is in the first";
  EXPECT_EQ(Read("apart/trajectory_run2_2.txt").size(), 30U);
  EXPECT_EQ(Report("apart")["submaps"].size(), 2U);
}

TEST_F(MergeTest, TheSameRunsGiveTheSameBytes) {
  std::map<std::string, std::string> first;
  for (const char* out : {"once", "again"}) {
    ASSERT_EQ(In("merge run_monday run_tuesday --out " + std::string(out)).exit_code, 0);
    for (const auto& entry : fs::directory_iterator(*folder_ / out)) {
      const std::string name = entry.path().filename().string();
      const auto [known, is_new] = first.emplace(name, ReadText(entry.path()));
      EXPECT_TRUE(is_new || known->second == ReadText(entry.path())) << name;
    }
  }
}

TEST_F(MergeTest, MergedRunsMergeOnWithMapsAndRuns) {
  ASSERT_EQ(In("merge run_monday run_elsewhere --out first").exit_code, 0);
  fs::copy_file(*folder_ / "run_tuesday/map.hwmap", *folder_ / "tuesday.hwmap");
  const Outcome outcome = In("merge first tuesday.hwmap --out second --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report, Report("second"));
  ASSERT_EQ(report["runs"].size(), 3U);
  EXPECT_EQ(report["runs"][0]["name"], "run_monday");
  EXPECT_EQ(report["runs"][0]["frames"], 40);
  EXPECT_EQ(report["runs"][2]["name"], "tuesday.hwmap");
  EXPECT_EQ(report["runs"][2]["frames"], Report("run_tuesday")["submaps"][0]["keyframes"]);
  ASSERT_EQ(report["submaps"].size(), 2U);
  EXPECT_EQ(report["submaps"][0]["runs"], json({1, 3}));
  EXPECT_LT(AbsolutePoseError(Truth(), Read("second/trajectory.txt")).statistics.rmse, 0.01);
}

TEST_F(MergeTest, ASessionContinuesTheMergedMap) {
  ASSERT_EQ(In("merge run_monday run_tuesday --out base").exit_code, 0);
  const Outcome outcome =
      In("slam --deterministic --no-map --dataset meanwhile --load-map base/map.hwmap --localize "
         "--out "
         "localized");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GT(Read("localized/trajectory.txt").size(), 40U) << "of 45";
}

TEST_F(MergeTest, RefusesRunsThatCannotBeMergedInOneLine) {
  const auto refused = [&](const std::string& arguments, int code,
                           const std::vector<std::string>& parts) {
    SCOPED_TRACE(arguments);
    ExpectRefused(In("merge " + arguments), code, parts);
    EXPECT_FALSE(fs::exists(*folder_ / "nothing"));
  };
  refused("run_monday --out nothing", 1, {"two runs or more"});
  refused("run_monday run_tuesday", 1, {"--out is required"});
  refused("run_monday run_monday/ --out nothing", 2, {"run_monday/ is given twice, as run_monday"});
  refused("run_monday none --out nothing", 2, {"none: is not there"});
  refused("run_monday tuesday --out nothing", 2, {"tuesday: is no finished run"});
  refused("run_monday room/calibration.yaml --out nothing", 2, {"is no map of Highwall"});
  for (const char* out : {"run_monday", "run_monday/merged", "./run_monday/../run_monday"}) {
    refused("run_monday run_tuesday --out " + std::string(out), 2,
            {"which is to be merged: choose another folder"});
  }
  WriteText(*folder_ / "file", "");
  refused("run_monday run_tuesday --out file", 2, {"is a file, but --out needs a folder"});

  const auto damaged = [&](const std::string& file, const std::string& text) {
    fs::remove_all(*folder_ / "damaged");
    fs::copy(*folder_ / "run_tuesday", *folder_ / "damaged");
    fs::remove(*folder_ / ("damaged/" + file));
    if (!text.empty()) WriteText(*folder_ / ("damaged/" + file), text);
  };
  damaged("map.hwmap", "");
  refused("run_monday damaged --out nothing", 2, {"map.hwmap: is not there", "--save-map"});
  damaged("map.hwmap", ReadText(*folder_ / "run_tuesday/map.hwmap").substr(0, 5000));
  refused("run_monday damaged --out nothing", 2, {"map.hwmap: is cut short"});
  damaged("run.json", "{");
  refused("run_monday damaged --out nothing", 2, {"run.json: is damaged"});
  damaged("run.json", R"({"runs": 7})");
  refused("run_monday damaged --out nothing", 2, {"run.json: is damaged"});
  damaged("trajectory.txt", "");
  refused("run_monday damaged --out nothing", 2, {"trajectory.txt: cannot be opened"});
}

// The order of the runs and further runs do not matter.
TEST_F(MergeTest, ARunIsNotMergedWithOneThatHoldsItsKeyFrames) {
  ASSERT_EQ(In("slam --deterministic --no-map --dataset tuesday --load-map run_monday/map.hwmap "
               "--out went_on")
                .exit_code,
            0);
  ASSERT_EQ(In("merge run_monday run_tuesday --out both").exit_code, 0);
  const auto refused = [&](const std::string& runs, const std::string& whole,
                           const std::string& part) {
    SCOPED_TRACE(runs);
    ExpectRefused(In("merge " + runs + " --out nothing"), 2,
                  {whole + ": holds", "keyframes of " + part + " already", "leave " + part});
    EXPECT_FALSE(fs::exists(*folder_ / "nothing"));
  };
  refused("run_monday went_on", "went_on", "run_monday");
  refused("went_on run_elsewhere run_monday", "went_on", "run_monday");
  refused("both run_tuesday", "both", "run_tuesday");
  refused("run_monday run_monday/map.hwmap", "run_monday/map.hwmap", "run_monday");
}

TEST_F(MergeTest, MapsOfAnotherCameraOrOtherPointsAndLocalizationsAreRefused) {
  SavedMap map = LoadMap(*folder_ / "run_tuesday/map.hwmap");
  map.map.SetFeatureType({.name = "sift"});
  SaveMap(*folder_ / "sift.hwmap", map.camera, map.map);
  ExpectRefused(In("merge run_monday sift.hwmap --out nothing"), 2,
                {"sift.hwmap: is a map of points by sift, run_monday of points by orb"});
  map.map.SetFeatureType({.pyramid = {.levels = 4, .scale_factor = 1.5}});
  SaveMap(*folder_ / "coarse.hwmap", map.camera, map.map);
  ExpectRefused(In("merge run_monday coarse.hwmap --out nothing"), 2,
                {"coarse.hwmap: is a map of points by orb in 4 levels of 1.5, run_monday of points "
                 "by orb in 8 levels of 1.2"});
  map.camera.fx = 300.0;
  SaveMap(*folder_ / "other.hwmap", map.camera, map.map);
  ExpectRefused(In("merge run_monday other.hwmap --out nothing"), 2,
                {"other.hwmap: is a map of another camera", "fx 300", "fx 262.5"});
  ASSERT_EQ(In("slam --deterministic --no-map --dataset monday --load-map run_monday/map.hwmap "
               "--localize --out only")
                .exit_code,
            0);
  ExpectRefused(In("merge run_tuesday only --out nothing"), 2, {"only: is a localization"});
}

}  // namespace
}  // namespace highwall::merge_test
