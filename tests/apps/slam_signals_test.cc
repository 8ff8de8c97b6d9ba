// Ends `highwall slam` by signals.
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_signals_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::BackgroundProgram;
using testing::CountLines;
using testing::Outcome;
using testing::ReadText;

constexpr std::size_t kFrames = 30;

using Files = std::map<std::string, std::string>;  // by their names

// Returns the files that are not hidden.
Files FilesIn(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with('.')) files[name] = ReadText(entry.path());
  }
  return files;
}

class SlamSignals : public ::testing::Test {
 protected:
  SlamSignals() { testing::WriteSmallRoom(dataset(), static_cast<int>(kFrames)); }

  fs::path dataset() const { return folder_ / "dataset"; }
  fs::path run() const { return folder_ / "run"; }
  fs::path causal() const { return run() / "trajectory_causal.txt"; }
  // Synchronous mode: every run gives the same result.
  std::vector<std::string> Arguments() const {
    return {"slam", "--dataset", dataset().string(), "--out", run().string(), "--deterministic"};
  }
  // Waits until the program has tracked so many frames.
  void WaitForPoses(BackgroundProgram& program, std::size_t frames = 4) const {
    while (program.IsRunning() && CountLines(ReadText(causal())) < frames) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(program.IsRunning());
  }
  // Returns the output of a run on the first frames alone: a recording that ends with them.
  Files FilesOfShortRun(std::size_t frames) const {
    const std::string number = std::to_string(frames);
    const fs::path folder = folder_ / ("short" + number), out = folder_ / ("run" + number);
    if (fs::exists(out)) return FilesIn(out);
    fs::create_directories(folder);
    for (const char* const name : {"rgb", "depth"}) {
      const std::string list = std::string(name) + ".txt", all = ReadText(dataset() / list);
      fs::create_directory_symlink(dataset() / name, folder / name);
      std::size_t end = 0;
      for (std::size_t entries = 0; entries < frames; end = all.find('\n', end) + 1) {
        if (all[end] != '#') ++entries;
      }
      testing::WriteText(folder / list, all.substr(0, end));
    }
    fs::copy(dataset() / "calibration.yaml", folder);
    const Outcome outcome = testing::RunProgram(
        testing::kHighwallProgram,
        "slam --dataset " + folder.string() + " --out " + out.string() + " --deterministic");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return FilesIn(out);
  }

  // Expects the output of a run on the frames of its run.json alone, and returns their number.
  std::size_t ExpectShortRun() const;
  // Interrupts runs at random frames.
  void Interrupt(int runs, unsigned seed);

  const testing::TemporaryDirectory folder_;
};

std::size_t SlamSignals::ExpectShortRun() const {
  const Files files = FilesIn(run());
  if (!files.contains("run.json")) {
    ADD_FAILURE() << "no run.json";
    return 0;
  }
  const json report = json::parse(files.at("run.json"));
  const auto done = report.at("frames").get<std::size_t>();
  const Files expected = FilesOfShortRun(done);
  EXPECT_EQ(files.size(), expected.size());
  for (const auto& [file, content] : expected) {
    if (file == "run.json") continue;
    EXPECT_TRUE(files.contains(file) && files.at(file) == content) << file;
  }
  const json ended = json::parse(expected.at("run.json"));
  for (const char* const key : {"complete", "frames", "tracked_frames", "coverage", "keyframes",
                                "landmarks", "submaps", "lost_stamps", "matched_per_frame"}) {
    EXPECT_EQ(report.at(key), ended.at(key)) << key;
  }
  return done;
}

void SlamSignals::Interrupt(int runs, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::size_t> frame(1, kFrames - 4);
  for (int i = 0; i < runs; ++i) {
    const std::size_t at = frame(random);
    SCOPED_TRACE(at);
    fs::remove_all(run());
    BackgroundProgram program(testing::kHighwallProgram, Arguments());
    WaitForPoses(program, at);
    program.Send(SIGINT);
    EXPECT_EQ(program.ExitCode(), 128 + SIGINT);
    EXPECT_GE(ExpectShortRun(), at);
  }
}

// The result is the same as if the recording ended with that frame.
TEST_F(SlamSignals, OneSignalEndsTheRunAtTheNextFrameAndLosesNothing) {
  const std::map<std::string, int> signals = {
      {"SIGINT", SIGINT}, {"SIGTERM", SIGTERM}, {"SIGHUP", SIGHUP}};
  for (const auto& [name, signal] : signals) {
    SCOPED_TRACE(name);
    fs::remove_all(run());
    BackgroundProgram program(testing::kHighwallProgram, Arguments());
    WaitForPoses(program);
    program.Send(signal);
    program.Send(signal);  // as timeout(1) sends it: to the process, and to its group
    EXPECT_EQ(program.ExitCode(), 128 + signal);
    const std::size_t done = ExpectShortRun();
    const json report = json::parse(ReadText(run() / "run.json"));
    ASSERT_GE(done, 3U);
    ASSERT_LT(done, kFrames);
    const json stopped = {{"signal", name}, {"frames_done", done}, {"frames", kFrames}};
    EXPECT_EQ(report["stopped"], stopped);
    EXPECT_EQ(report["complete"], true);
    EXPECT_EQ(report["skipped_frames"], 0);
    EXPECT_EQ(report["coverage"], 1.0);
  }
  const Outcome map = testing::RunProgram(
      testing::kHighwallProgram, "map " + run().string() + " --out " + (folder_ / "map").string());
  EXPECT_EQ(map.exit_code, 0) << map.err;
}

TEST_F(SlamSignals, AnInterruptedRunEqualsOneThatEndedThere) {
  Interrupt(3, 1);
}

TEST_F(SlamSignals, TwentyInterruptedRunsEqualThoseThatEndedThere) {
  Interrupt(20, 2);
}

TEST_F(SlamSignals, ARunThatIsNotStoppedDoesNotSaySo) {
  std::string arguments;
  for (const std::string& argument : Arguments()) arguments += argument + " ";
  const Outcome outcome = testing::RunProgram(testing::kHighwallProgram, arguments + "--no-map");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(json::parse(ReadText(run() / "run.json")).contains("stopped"));
}

// The second signal arrives while the run ends regularly after the first, at increasing delays.
TEST_F(SlamSignals, ASecondSignalTearsNothing) {
  for (const int wait : {120, 200, 300, 500}) {  // [ms]
    SCOPED_TRACE(wait);
    fs::remove_all(run());
    BackgroundProgram program(testing::kHighwallProgram, Arguments());
    WaitForPoses(program);
    program.Send(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(wait));
    program.Send(SIGTERM);
    const int exit_code = program.ExitCode();
    const Files files = FilesIn(run());
    EXPECT_EQ(exit_code, files.contains("run.json") ? exit_code : 128 + SIGTERM);
    const Files expected = FilesOfShortRun(ReadTumTrajectory(causal()).size());
    for (const auto& [file, content] : files) {
      if (file == "run.json" || (file == "keyframes.txt" && !files.contains("trajectory.txt"))) {
        continue;  // keyframes.txt is as during tracking
      }
      EXPECT_TRUE(expected.contains(file) && expected.at(file) == content) << file;
    }
  }
}

TEST_F(SlamSignals, MapOfARunThatWasKilledNamesTheCommandThatWorks) {
  {
    BackgroundProgram program(testing::kHighwallProgram, Arguments());
    WaitForPoses(program);
    program.Kill();
  }
  const std::string map = "map " + run().string(), out = (folder_ / "map").string();
  const std::string poses = causal().string();
  for (const std::string& known : {std::string(), " --dataset " + dataset().string()}) {
    const std::string given = known.empty() ? " --dataset DATASET" : known;
    testing::ExpectRefused(
        testing::RunProgram(testing::kHighwallProgram, map + known + " --out " + out), 2,
        {run().string() + ": is a run that did not end",
         "highwall " + map + given + " --trajectory " + poses + " --out FOLDER\n"});
  }
  const Outcome outcome = testing::RunProgram(
      testing::kHighwallProgram,
      map + " --dataset " + dataset().string() + " --trajectory " + poses + " --out " + out);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(folder_ / "map" / "map.bt"));
}

}  // namespace
}  // namespace highwall::slam_signals_test
