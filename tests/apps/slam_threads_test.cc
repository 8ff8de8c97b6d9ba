// Runs `highwall slam` with all of its threads: reader, features, tracking, local mapping, loops
// and dense mapping. The recording has two seconds, so that ThreadSanitizer can check it.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::slam_threads_test {
namespace {

using nlohmann::json;

TEST(SlamWithAllThreads, TracksEveryFrame) {
  const testing::TemporaryDirectory folder("threads");
  simulate::SimulationOptions options;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  options.fps = 6.0;
  options.duration = 2.0;
  simulate::WriteTum(simulate::SimulateRoom(options), folder.path() / "dataset");
  const testing::Outcome outcome = testing::RunProgram(
      testing::kHighwallProgram, "slam --dataset dataset --out run --json", folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["frames"], 12);
  EXPECT_EQ(report["lost_frames"], 0);
  EXPECT_GT(report["keyframes"], 1);
  for (const char* file : {"trajectory.txt", "cloud.ply", "map.bt"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "run" / file)) << file;
  }
}

}  // namespace
}  // namespace highwall::slam_threads_test
