// Runs `highwall slam` where its output fails: a full disk, missing folders, an end by `kill -9`.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <sys/stat.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>

#include "support/file_size_limit.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_output_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::BackgroundProgram;
using testing::Contains;
using testing::CountLines;
using testing::FileSizeLimit;
using testing::Outcome;
using testing::ReadText;

// Replaces a file, while this object lives, by a pipe without a writer: readers of the file wait.
class WithheldFile {
 public:
  explicit WithheldFile(fs::path path) : path_(std::move(path)), aside_(path_.string() + ".aside") {
    fs::rename(path_, aside_);
    if (::mkfifo(path_.c_str(), 0600) != 0) throw std::runtime_error("no pipe can be made");
  }
  ~WithheldFile() { fs::rename(aside_, path_); }
  WithheldFile(const WithheldFile&) = delete;
  WithheldFile& operator=(const WithheldFile&) = delete;

 private:
  const fs::path path_, aside_;
};

class SlamOutput : public ::testing::Test {
 protected:
  fs::path dataset() const { return folder_ / "dataset"; }
  fs::path run() const { return folder_ / "run"; }
  fs::path ColorImage(std::size_t index) const {
    std::set<fs::path> images;  // in the order of their stamps
    for (const auto& entry : fs::directory_iterator(dataset() / "rgb")) images.insert(entry.path());
    return *std::next(images.begin(), static_cast<std::ptrdiff_t>(index));
  }
  void WriteSequence(int frames) const { testing::WriteSmallRoom(dataset(), frames); }

  // Synchronous mode: every run gives the same result.
  std::vector<std::string> Arguments() const {
    return {"slam", "--dataset", dataset().string(), "--out", run().string(), "--deterministic"};
  }
  Outcome Slam(const std::string& options = "") const {
    std::string text;
    for (const std::string& argument : Arguments()) text += argument + " ";
    return testing::RunProgram(testing::kHighwallProgram, text + options);
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
  // If the dataset were read first, the error would refer to it.
  const fs::path file = folder_ / "file";
  std::ofstream(file) << "precious";
  const Outcome outcome = Slam("--save-map " + (file / "a" / "room.hwmap").string());
  testing::ExpectRefused(outcome, 2, {(file / "a").string() + ": cannot be made: "});
  EXPECT_FALSE(fs::exists(run()));
}

// Files that do not fit are missing and are named with the reason; all others are complete.
TEST_F(SlamOutput, AFullDiskKeepsTheFilesThatFit) {
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

// File names from older or other systems: Latin 1, truncated in the middle of a character.
TEST_F(SlamOutput, NamesThatAreNotUtf8AreReportedAndFoundAgain) {
  WriteSequence(6);
  const std::string recording = "B\xFCro \xE5\xB7", out = "l\xE4uft";
  fs::rename(dataset(), folder_ / recording);
  const auto highwall = [&](const std::string& arguments) {
    const Outcome outcome =
        testing::RunProgram(testing::kHighwallProgram, arguments, folder_.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out;
  };
  const std::string report =
      highwall("slam --deterministic --json --dataset '" + recording + "' --out " + out);
  EXPECT_EQ(json::parse(report), json::parse(ReadText(folder_ / out / "run.json")));
  EXPECT_TRUE(json::parse(report)["complete"]);
  // The run names its recording, and the recording its calibration.
  EXPECT_EQ(json::parse(highwall("map " + out + " --json --out m\xE4p"))["frames"],
            json::parse(report)["keyframes"]);
  const std::string poses = " '" + recording + "/groundtruth.txt' " + out + "/trajectory.txt";
  EXPECT_EQ(json::parse(highwall("eval ape --json" + poses))["associated"], 6);
  highwall("eval ape" + poses + " --evo-results h\xF6he.zip");
  EXPECT_TRUE(json::accept(highwall("info --json '" + recording + "'")));
  highwall("report " + out);
  const std::string map = "m\xE4p/cloud.ply";
  EXPECT_TRUE(json::accept(highwall("map compare --json " + map + " " + map)));
}

// Killed over a complete earlier run, while it waits for an image that does not arrive.
TEST_F(SlamOutput, AKilledRunLeavesItsPosesAndKeyframesAndNothingElse) {
  constexpr std::size_t kFrames = 15;
  WriteSequence(static_cast<int>(kFrames));
  ASSERT_EQ(Slam("--no-map").exit_code, 0);
  const Trajectory reference = ReadTumTrajectory(run() / "trajectory_causal.txt");
  ASSERT_EQ(reference.size(), kFrames);
  for (const std::size_t poses : {1U, 4U, 12U}) {
    SCOPED_TRACE(poses);
    ASSERT_EQ(Slam("--no-map").exit_code, 0);
    EXPECT_EQ(json::parse(ReadText(run() / "run.json"))["complete"], true);

    const WithheldFile image(ColorImage(poses));
    const fs::path log = run() / "trajectory_causal.txt", keyframes = run() / "keyframes.txt";
    BackgroundProgram program(testing::kHighwallProgram, Arguments());
    const auto lines = [](const fs::path& file) { return CountLines(ReadText(file)); };
    // The first line is a comment. The keyframe of the first frame is written after its pose.
    while (program.IsRunning() && (lines(log) != 1 + poses || lines(keyframes) < 2)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(program.IsRunning());
    program.Kill();
    const Trajectory left = ReadTumTrajectory(log);
    ASSERT_EQ(left.size(), poses);
    for (std::size_t i = 0; i < left.size(); ++i) {
      EXPECT_EQ(left[i].stamp, reference[i].stamp);
      EXPECT_EQ(left[i].pose.p(), reference[i].pose.p());
    }
    EXPECT_EQ(ReadTumTrajectory(keyframes).front().stamp, reference.front().stamp);
    EXPECT_TRUE(Results().contains(".highwall.lock")) << "the folder is still Highwall's";
    EXPECT_EQ(Results().size(), 3U) << "of the earlier run, or a temporary";
  }
}

// The run is killed at ten times from start to end, each time in the same folder: a report exists
// only with all the files that it reports, and a run that is not killed finds no obstacle.
TEST_F(SlamOutput, WhereThereIsAReportTheRunIsComplete) {
  WriteSequence(10);
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(Slam().exit_code, 0);
  const auto duration = std::chrono::steady_clock::now() - start;
  const auto whole = Results();
  for (int moment = 0; moment < 10; ++moment) {
    SCOPED_TRACE(moment);
    {
      BackgroundProgram program(testing::kHighwallProgram, Arguments());
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
}  // namespace highwall::slam_output_test
