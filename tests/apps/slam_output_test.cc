// Runs `highwall slam` where something goes wrong with what it writes: a full disk, folders that
// are missing, an end by `kill -9`.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>

#include "support/file_size_limit.h"
#include "support/run_program.h"
#include "support/small_room.h"

namespace highwall {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::BackgroundProgram;
using testing::Contains;
using testing::CountLines;
using testing::FileSizeLimit;
using testing::Outcome;
using testing::ReadText;

class SlamOutput : public ::testing::Test {
 protected:
  fs::path dataset() const { return folder_ / "dataset"; }
  fs::path run() const { return folder_ / "run"; }
  void WriteSequence(int frames) const { testing::WriteSmallRoom(dataset(), frames); }

  // In lockstep: every run gives the same.
  std::vector<std::string> Arguments() const {
    return {"slam", "--dataset", dataset().string(), "--out", run().string(), "--deterministic"};
  }
  Outcome Slam(const std::string& options = "") const {
    std::string text;
    for (const std::string& argument : Arguments()) text += argument + " ";
    return testing::RunProgram(HIGHWALL_BINARY, text + options);
  }
  std::map<std::string, std::string> Results() const {
    std::map<std::string, std::string> results;
    for (const auto& entry : fs::directory_iterator(run())) {
      results[entry.path().filename().string()] = ReadText(entry.path());
    }
    return results;
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(SlamOutput, AMissingFolderOfASavedMapIsMade) {
  WriteSequence(6);
  const fs::path map = folder_ / "maps" / "of" / "room.hwmap";
  const Outcome outcome = Slam("--no-map --save-map " + map.string());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(map));
  EXPECT_EQ(ReadTumTrajectory(run() / "trajectory.txt").size(), 6U);
}

TEST_F(SlamOutput, AFolderOfASavedMapThatCannotBeMadeIsRefusedBeforeTheWork) {
  // Were the dataset looked at first, it would be to blame.
  const fs::path file = folder_ / "file";
  std::ofstream(file) << "precious";
  const Outcome outcome = Slam("--save-map " + (file / "a" / "room.hwmap").string());
  testing::ExpectRefused(outcome, 2, {(file / "a").string() + ": cannot be made: "});
  EXPECT_FALSE(fs::exists(run()));
}

// Files that do not fit are missing and named, with the reason; all others are as they would be.
TEST_F(SlamOutput, AFullDiskCostsNoMoreThanWhatDoesNotFit) {
  WriteSequence(8);
  const fs::path map = folder_ / "room.hwmap";
  const std::string options = "--adjust-all --save-map " + map.string();
  ASSERT_EQ(Slam(options).exit_code, 0);
  const auto whole = Results();
  fs::remove(map);

  constexpr std::size_t kLimit = 20000;  // [byte]
  std::vector<std::string> missing = {map.string()};
  for (const auto& [name, content] : whole) {
    if (content.size() > kLimit) missing.push_back((run() / name).string());
  }
  ASSERT_GT(missing.size(), 3U) << "cloud.ply and pictures";
  Outcome outcome;
  {
    const FileSizeLimit limit(kLimit);
    outcome = Slam("--json " + options);
  }
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(CountLines(outcome.err), missing.size()) << outcome.err;
  for (const std::string& path : missing) {
    EXPECT_TRUE(Contains(outcome.err, path + ": could not be written whole: File too large\n"))
        << path << " in " << outcome.err;
    EXPECT_FALSE(fs::exists(path)) << path << " is of the earlier run";
  }
  const auto left = Results();
  EXPECT_EQ(left.size() + missing.size() - 1, whole.size()) << "a temporary was left behind";
  for (const auto& [name, content] : left) {
    if (name == "run.json") continue;
    EXPECT_TRUE(whole.at(name) == content) << name;
  }
  const json report = json::parse(left.at("run.json"));
  EXPECT_EQ(report, json::parse(outcome.out));
  EXPECT_EQ(report["complete"], false);
  EXPECT_EQ(report["failures"].size(), missing.size());
}

// Killed when so many poses are in the file, long before the last, over a complete earlier run.
TEST_F(SlamOutput, AKilledRunLeavesItsPosesAndKeyframesAndNothingElse) {
  constexpr std::size_t kFrames = 45;
  WriteSequence(static_cast<int>(kFrames));
  ASSERT_EQ(Slam("--no-map").exit_code, 0);
  const Trajectory reference = ReadTumTrajectory(run() / "trajectory_causal.txt");
  ASSERT_EQ(reference.size(), kFrames);
  const json report = json::parse(ReadText(run() / "run.json"));
  EXPECT_EQ(report["complete"], true);
  for (const std::size_t poses : {1U, 4U, 12U, 25U}) {
    SCOPED_TRACE(poses);
    ASSERT_EQ(Slam("--no-map").exit_code, 0);
    const fs::path log = run() / "trajectory_causal.txt";
    BackgroundProgram program(HIGHWALL_BINARY, Arguments());
    const auto written = [&] { return CountLines(ReadText(log)); };  // the first is a comment
    while (program.IsRunning() && (fs::exists(run() / "run.json") || written() < 1 + poses)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(program.IsRunning()) << "has ended before it could be killed";
    program.Kill();
    const Trajectory left = ReadTumTrajectory(log);
    ASSERT_GE(left.size(), poses);
    ASSERT_LE(left.size(), reference.size());
    for (std::size_t i = 0; i < left.size(); ++i) {
      EXPECT_EQ(left[i].stamp, reference[i].stamp);
      EXPECT_EQ(left[i].pose.p(), reference[i].pose.p());
    }
    const Trajectory keyframes = ReadTumTrajectory(run() / "keyframes.txt");
    ASSERT_GE(keyframes.size(), 1U);
    EXPECT_EQ(keyframes.front().stamp, reference.front().stamp);
    // Where the last pose was there before the kill, the end of the run may have begun.
    if (left.size() == reference.size()) continue;
    EXPECT_EQ(Results().size(), 2U) << "of the earlier run, or a temporary";
  }
}

// At ten moments from the start to the end, one after the other in one folder: a report is there
// only with all that it reports, and a run that is not killed finds nothing in its way.
TEST_F(SlamOutput, WhereThereIsAReportTheRunIsComplete) {
  WriteSequence(10);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(Slam().exit_code, 0);
  const auto duration = std::chrono::steady_clock::now() - start;
  const auto whole = Results();
  for (int moment = 0; moment < 10; ++moment) {
    SCOPED_TRACE(moment);
    {
      BackgroundProgram program(HIGHWALL_BINARY, Arguments());
      std::this_thread::sleep_for(duration * moment / 9);
      program.Kill();
    }
    const auto left = Results();
    if (!left.contains("run.json")) continue;
    EXPECT_EQ(json::parse(left.at("run.json"))["complete"], true);
    for (const auto& [name, content] : whole) {
      ASSERT_TRUE(left.contains(name)) << name;
      if (name == "run.json") continue;
      EXPECT_TRUE(left.at(name) == content) << name;
    }
  }
  ASSERT_EQ(Slam().exit_code, 0);
  for (const auto& [name, content] : Results()) EXPECT_TRUE(whole.contains(name)) << name;
}

}  // namespace
}  // namespace highwall
