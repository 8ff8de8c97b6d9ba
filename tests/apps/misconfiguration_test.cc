// Stamps in another unit, a map of another place, and a dataset that was replaced by another are
// said in plain words, as a user runs the commands.
#include <filesystem>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::misconfiguration_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

constexpr int kFrames = 24;

class Misconfiguration : public ::testing::Test {
 protected:
  fs::path File(const std::string& name) const { return folder_.path() / name; }
  // Writes the first frames of a walk through a room of its own.
  void WriteRoom(const std::string& name, std::uint64_t seed, int frames = kFrames) const {
    fs::remove_all(File(name));
    simulate::SimulationOptions options = testing::SmallRoomOptions();
    options.seed = seed;
    options.duration = frames / options.fps;
    simulate::WriteTum(simulate::SimulateRoom(options), File(name));
  }
  // Writes the stamps of its images anew: stamp(i) in seconds.
  template <class StampOf>
  void Restamp(const std::string& name, const StampOf& stamp) const {
    for (const char* list : {"rgb.txt", "depth.txt"}) {
      std::istringstream lines(ReadText(File(name) / list));
      std::string all, line;
      for (int i = 0; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#') continue;
        all += stamp(i++) + line.substr(line.find(' ')) + "\n";
      }
      WriteText(File(name) / list, all);
    }
    fs::remove(File(name) / "groundtruth.txt");
  }
  Outcome Highwall(const std::string& arguments) const {
    return testing::RunProgram(testing::kHighwallProgram, arguments, folder_.path());
  }
  Outcome Slam(const std::string& options, const std::string& out = "run") const {
    return Highwall("slam --deterministic --no-map --out " + out + " " + options);
  }
  json Report(const std::string& run = "run") const {
    return json::parse(ReadText(File(run) / "run.json"));
  }

 private:
  const testing::TemporaryDirectory folder_;
};

// Returns the finding of a kind; null if there is none.
json FindingOf(const json& report, const std::string& fault) {
  for (const json& finding : report["verdict"]["findings"]) {
    if (finding["fault"] == fault) return finding;
  }
  return nullptr;
}

std::string Milliseconds(int frame) {
  return std::to_string(33 * frame) + ".250000";
}

TEST_F(Misconfiguration, MillisecondsAreSaidAndCostNoKeyframes) {
  WriteRoom("room", 1);
  ASSERT_EQ(Slam("--dataset room", "right").exit_code, 0);
  EXPECT_EQ(Report("right")["verdict"]["trust"], "consistent");
  Restamp("room", Milliseconds);
  const Outcome outcome = Slam("--dataset room");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err,
                       "warning: stamps are likely milliseconds: they are 33 apart: "
                       "divide them by 1000 to have seconds"))
      << outcome.err;
  EXPECT_EQ(FindingOf(Report(), "stamps")["trust"], "doubtful");
  // Before the unit is known, each of ten frames may become a keyframe.
  EXPECT_LE(Report()["keyframes_made"].get<int>(),
            Report("right")["keyframes_made"].get<int>() + 10);
  EXPECT_LT(Report()["keyframes_made"], kFrames - 5);
  EXPECT_EQ(Report()["lost_frames"], 0);
}

// Edits `calibration.yaml`: multiplies the number of a key.
void Multiply(const fs::path& file, const std::string& key, double factor) {
  std::istringstream lines(ReadText(file));
  std::string all, line;
  while (std::getline(lines, line)) {
    const std::size_t colon = line.find(": ");
    if (line.find(key + ":") != std::string::npos && colon != std::string::npos) {
      line = line.substr(0, colon + 2) + std::to_string(factor * std::stod(line.substr(colon + 2)));
    }
    all += line + "\n";
  }
  WriteText(file, all);
}

TEST_F(Misconfiguration, AWrongLensIsNamedBeforeTheFirstFrame) {
  for (const double factor : {0.5, 2.0}) {
    WriteRoom("room", 1, 30);
    Multiply(File("room") / "calibration.yaml", "fx", factor);
    Multiply(File("room") / "calibration.yaml", "fy", factor);
    const Outcome outcome = Slam("--overwrite --dataset room");
    EXPECT_TRUE(Contains(outcome.err, "warning: the focal lengths are likely")) << outcome.err;
    const json lens = FindingOf(Report(), "lens");
    ASSERT_FALSE(lens.is_null()) << factor;
    EXPECT_EQ(lens["trust"], "not to be trusted");
    EXPECT_TRUE(Contains(Highwall("info room").out, "the focal lengths are likely"));
  }
  WriteRoom("room", 1, 30);
  Multiply(File("room") / "calibration.yaml", "cx", 1.3);
  Slam("--overwrite --dataset room");
  EXPECT_TRUE(Contains(FindingOf(Report(), "lens")["text"], "the principal point is likely at"));
}

TEST_F(Misconfiguration, InfoNamesTheUnitOfStamps) {
  WriteRoom("room", 1);
  EXPECT_FALSE(Contains(Highwall("info room").out, "stamps"));
  Restamp("room", Milliseconds);
  EXPECT_TRUE(Contains(Highwall("info room").out, "stamps are likely milliseconds"));
  Restamp("room", [](int frame) { return std::to_string(frame); });
  EXPECT_TRUE(Contains(Highwall("info room").out, "stamps are likely frame numbers"));
}

TEST_F(Misconfiguration, PosesBesideALoadedMapHaveFilesOfTheirOwn) {
  WriteRoom("here", 1);
  WriteRoom("elsewhere", 2, 40);
  ASSERT_EQ(Slam("--dataset here", "map").exit_code, 0);
  const std::string load = " --load-map map/map.hwmap";
  ASSERT_EQ(Slam("--dataset here" + load).exit_code, 0);
  EXPECT_EQ(Report()["loaded_map_met"], true);
  EXPECT_EQ(Report()["verdict"]["trust"], "consistent");
  EXPECT_TRUE(fs::exists(File("run") / "trajectory.txt"));

  const Outcome outcome = Slam("--overwrite --dataset elsewhere" + load);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "the loaded map was never recognized")) << outcome.out;
  const json report = Report();
  EXPECT_EQ(report["loaded_map_met"], false);
  EXPECT_EQ(FindingOf(report, "map not met")["trust"], "doubtful");
  for (const char* name : {"trajectory", "trajectory_causal", "keyframes"}) {
    EXPECT_FALSE(fs::exists(File("run") / (name + std::string(".txt")))) << name;
    EXPECT_TRUE(fs::exists(File("run") / (name + std::string("_2.txt")))) << name;
  }
  EXPECT_EQ(report["submaps"][0]["trajectory"], "trajectory_2.txt");
  EXPECT_EQ(ReadTumTrajectory(File("run") / "trajectory_2.txt").size(),
            report["submaps"][0]["frames"]);
  // Commands that take the run find its poses.
  EXPECT_EQ(Highwall("map run --out maps").exit_code, 0);
  EXPECT_EQ(Highwall("report run").exit_code, 0);
  WriteRoom("third", 3, 12);
  ASSERT_EQ(Slam("--dataset third", "other").exit_code, 0);
  const Outcome merged = Highwall("merge run other --out merged");
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  const json runs = json::parse(ReadText(File("merged") / "run.json"))["runs"];
  EXPECT_EQ(runs[0]["frames"], report["submaps"][0]["frames"]);
}

TEST_F(Misconfiguration, AnotherRecordingOfTheNameIsSaid) {
  WriteRoom("room", 1);
  ASSERT_EQ(Slam("--dataset room").exit_code, 0);
  ASSERT_EQ(Highwall("map run --out maps").exit_code, 0);
  EXPECT_EQ(Highwall("report run").err, "");
  WriteRoom("room", 2);
  testing::ExpectRefused(Highwall("map run --out maps"), 2,
                         {"room: is another recording than that of run: it begins with another "
                          "image than that of the run"});
  testing::ExpectRefused(Highwall("calibrate run"), 2, {"room: is another recording"});
  EXPECT_TRUE(Contains(Highwall("report run").err, "its ground truth is not used"));
  const Outcome named = Highwall("map run --dataset room --out maps");
  EXPECT_EQ(named.exit_code, 0) << named.err;
  EXPECT_TRUE(Contains(named.err, "warning: room is another recording")) << named.err;
  WriteRoom("room", 1, kFrames - 1);
  testing::ExpectRefused(Highwall("map run --out maps"), 2,
                         {"has 23 colour images, that of the run had 24"});
  // Runs of older versions do not know their recording.
  json report = Report();
  report.erase("recording");
  report["per_frame"]["stamp"] = json::array();
  WriteText(File("run") / "run.json", report.dump());
  EXPECT_EQ(Highwall("map run --out maps").exit_code, 0);
}

}  // namespace
}  // namespace highwall::misconfiguration_test
