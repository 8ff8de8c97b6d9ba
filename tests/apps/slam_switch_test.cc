// Runs `highwall slam` with each switch that affects the result, and without: the results differ.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/mapping/octomap_builder.h>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_switch_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ReadText;

class SlamSwitch : public ::testing::Test {
 protected:
  fs::path dataset() const { return folder_ / "dataset"; }

  // Synchronous mode: any difference is caused by the switch.
  fs::path Run(const std::string& options) {
    const fs::path run = folder_ / ("run" + std::to_string(++runs_));
    const testing::Outcome outcome = testing::RunProgram(
        testing::kHighwallProgram, "slam --deterministic --dataset " + dataset().string() +
                                       " --out " + run.string() + " " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return run;
  }
  static json Report(const fs::path& run) { return json::parse(ReadText(run / "run.json")); }

 private:
  const testing::TemporaryDirectory folder_;
  int runs_ = 0;
};

TEST_F(SlamSwitch, FeaturesDetectorOutliersAndWeightingEachGiveAnotherTrajectory) {
  testing::WriteSmallRoom(dataset(), 8);
  const std::string plain = ReadText(Run("--no-map") / "trajectory.txt");
  for (const char* with : {"--features points", "--features lines", "--point-detector sift",
                           "--line-detector lsd", "--line-outliers paper", "--weighting paper"}) {
    const std::string other = ReadText(Run("--no-map " + std::string(with)) / "trajectory.txt");
    EXPECT_FALSE(other == plain) << with;
  }
}

TEST_F(SlamSwitch, LinesOrPointsAloneMakeAMapOfThem) {
  testing::WriteSmallRoom(dataset(), 4);
  const json points = Report(Run("--no-map --features points"))["landmarks"];
  EXPECT_GT(points["points"], 0);
  EXPECT_EQ(points["lines"], 0);
  const json lines = Report(Run("--no-map --features lines"))["landmarks"];
  EXPECT_EQ(lines["points"], 0);
  EXPECT_GT(lines["lines"], 0);
}

TEST_F(SlamSwitch, TheResolutionIsTheOctreesAndTouchesNoPose) {
  testing::WriteSmallRoom(dataset(), 4);
  const fs::path fine = Run("--resolution 0.1"), coarse = Run("--resolution 0.2");
  EXPECT_EQ(OctomapBuilder::Read(coarse / "map.bt").options().resolution, 0.2);
  EXPECT_LT(fs::file_size(coarse / "map.bt"), fs::file_size(fine / "map.bt"));
  EXPECT_EQ(Report(coarse)["map"]["grid"]["resolution_m"], 0.2);
  EXPECT_TRUE(ReadText(coarse / "trajectory.txt") == ReadText(fine / "trajectory.txt"));
}

TEST_F(SlamSwitch, MasksDynamicObjectsUnlessSwitchedOff) {
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.fps = 8.0;
  options.duration = 3.0;
  options.traffic = true;
  simulate::WriteTum(simulate::SimulateRoom(options), dataset());
  const fs::path on = Run("--no-map"), off = Run("--no-map --moving-objects off");
  EXPECT_FALSE(ReadText(on / "trajectory.txt") == ReadText(off / "trajectory.txt"));
}

// Once around the room and slightly further.
TEST_F(SlamSwitch, LoopsAreClosedUnlessTheyAreOff) {
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.fps = 6.0;
  options.duration = 13.0;
  simulate::WriteTum(simulate::SimulateRoom(options), dataset());
  const json with = Report(Run("--no-map"))["loops"];
  EXPECT_GE(with["closed"].get<int>() + with["refused"].get<int>(), 1);
  const json without = Report(Run("--no-map --no-loops"))["loops"];
  EXPECT_EQ(without["closed"].get<int>() + without["refused"].get<int>(), 0);
}

}  // namespace
}  // namespace highwall::slam_switch_test
