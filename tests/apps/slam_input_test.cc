// Tests `highwall slam` with slightly irregular lists, depth and ground truth.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/stamp.h>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_input_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::CountLines;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

class SlamInput : public ::testing::Test {
 protected:
  fs::path dataset() const { return folder_.path() / "dataset"; }
  fs::path run() const { return folder_.path() / "run"; }
  void WriteSequence(int frames) const { testing::WriteSmallRoom(dataset(), frames); }
  Outcome SlamOnDataset(const std::string& options = "") const {
    return testing::RunProgram(
        testing::kHighwallProgram,
        "slam --dataset " + dataset().string() + " --out " + run().string() + " " + options);
  }

 private:
  testing::TemporaryDirectory folder_;
};

TEST_F(SlamInput, ABadGroundTruthIsOneWarningAndStopsNeitherTheRunNorItsPage) {
  WriteSequence(6);
  WriteText(dataset() / "groundtruth.txt", "100.0 0 0 0 0 0 0 1\n100.1 0 nan 0 0 0 0 1\n");
  const Outcome outcome = SlamOnDataset("--no-map --report");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "groundtruth.txt:2: ty 'nan' is not a finite number"))
      << outcome.err;
  EXPECT_EQ(outcome.err.find("groundtruth.txt"), outcome.err.rfind("groundtruth.txt"));
  EXPECT_FALSE(Contains(outcome.out, "highwall eval ape")) << "it would fail: " << outcome.out;
  EXPECT_EQ(json::parse(ReadText(run() / "run.json"))["tracked_frames"], 6);
}

TEST_F(SlamInput, ReadsAListWithAnExchangedAndADoubledLineAndNamesThem) {
  WriteSequence(6);
  std::vector<std::string> lines;
  std::istringstream list(ReadText(dataset() / "rgb.txt"));
  for (std::string line; std::getline(list, line);) lines.push_back(line + "\n");
  std::swap(lines[lines.size() - 2], lines[lines.size() - 3]);
  lines.push_back(lines.back());
  std::string text = "\xef\xbb\xbf";
  for (const std::string& line : lines) text += line;
  WriteText(dataset() / "rgb.txt", text);
  const Outcome outcome = SlamOnDataset("--no-map --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(CountLines(outcome.err), 2U) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "is smaller than the one before; the list is sorted"));
  EXPECT_TRUE(Contains(outcome.err, "is there twice; the first line stays"));
  EXPECT_EQ(json::parse(outcome.out)["tracked_frames"], 6);
}

TEST_F(SlamInput, CoverageCountsColourImagesAndSaysHowManyHaveNoDepth) {
  WriteSequence(6);
  std::istringstream list(ReadText(dataset() / "depth.txt"));
  std::string some;
  int images = 0;
  for (std::string line; std::getline(list, line);) {
    if (line.starts_with('#') || ++images <= 4) some += line + "\n";
  }
  WriteText(dataset() / "depth.txt", some);
  const Outcome outcome = SlamOnDataset("--no-map");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out,
                       "coverage    66.67 % of the 6 colour images of the recording have a pose; "
                       "2 have no depth image in time"))
      << outcome.out;
  EXPECT_TRUE(Contains(outcome.err, "2 of 6 colour images have no depth image within 0.02 s"))
      << outcome.err;
  const json report = json::parse(ReadText(run() / "run.json"));
  EXPECT_DOUBLE_EQ(report["coverage"], 4.0 / 6.0);
  EXPECT_EQ(report["without_depth"], 2);
  EXPECT_EQ(report["colour_images"], 6);
}

TEST_F(SlamInput, TakesTheSwitchThatItNamesWhereDepthIsLate) {
  // The frame rate is so low that no other image is nearer than the matching one.
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.fps = 10.0;
  options.duration = 0.6;
  simulate::WriteTum(simulate::SimulateRoom(options), dataset());
  std::istringstream list(ReadText(dataset() / "depth.txt"));
  std::string late;
  for (std::string line; std::getline(list, line);) {
    const std::size_t blank = line.find(' ');
    const std::optional<Stamp> stamp = ParseStamp(line.substr(0, blank));
    if (stamp) late += FormatStamp(*stamp + 25'000'000) + line.substr(blank) + "\n";
  }
  WriteText(dataset() / "depth.txt", late);
  testing::ExpectRefused(SlamOnDataset(), 2,
                         {"depth is 0.025 s later in the median; give --max-pair-difference 0.03"});
  const Outcome outcome = SlamOnDataset("--no-map --max-pair-difference 0.03 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["tracked_frames"], 6);
  EXPECT_EQ(report["max_pair_difference_s"], 0.03);
  const Outcome map = testing::RunProgram(
      testing::kHighwallProgram,
      "map " + run().string() + " --out " + (run() / "map").string() + " --resolution 0.1");
  EXPECT_EQ(map.exit_code, 0) << "the run names it: " << map.err;
}

}  // namespace
}  // namespace highwall::slam_input_test
