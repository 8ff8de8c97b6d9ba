// Runs `highwall demo` on a recording that exists already, as in a second run.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::demo_test {
namespace {

TEST(Demo, MapsItsRecordingAndPrintsTheErrorAndTheResultFolder) {
  const testing::TemporaryDirectory folder("demo");
  simulate::SimulationOptions options;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  options.fps = 6.0;
  options.duration = 2.0;
  std::filesystem::create_directory(folder.path() / "out");
  simulate::WriteTum(simulate::SimulateRoom(options), folder.path() / "out" / "mine");
  const testing::Outcome outcome =
      testing::RunProgram(testing::kHighwallProgram, "demo --out out", folder.path());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* text :
       {"$ highwall slam --dataset out/mine --out out/run", "frames      12 (0 lost",
        "$ highwall eval ape out/mine/groundtruth.txt out/run/trajectory.txt", "rmse",
        "out/run/cloud.ply", "highwall info"}) {
    EXPECT_TRUE(testing::Contains(outcome.out, text)) << outcome.out;
  }
  EXPECT_FALSE(testing::Contains(outcome.out, "$ highwall simulate")) << outcome.out;
  for (const char* file :
       {"trajectory.txt", "cloud.ply", "map.bt", "grid.yaml", "error.svg", "run.json"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / "run" / file)) << file;
  }
}

TEST(Demo, EndsWithTheStepThatFails) {
  const testing::TemporaryDirectory folder("demo");
  std::filesystem::create_directories(folder.path() / "out" / "mine");
  const testing::Outcome outcome =
      testing::RunProgram(testing::kHighwallProgram, "demo --out out", folder.path());
  EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
  EXPECT_TRUE(testing::Contains(outcome.err, "highwall slam: out/mine")) << outcome.err;
  EXPECT_FALSE(testing::Contains(outcome.out, "$ highwall eval")) << outcome.out;
}

}  // namespace
}  // namespace highwall::demo_test
