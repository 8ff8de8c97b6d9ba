// Dense maps are built from depth corrected by the current estimate: with rolling-shutter
// compensation and without the depth distortion of the sensor.
#include <cstddef>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "run/calibration_file.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::corrected_depth_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class CorrectedDepth : public ::testing::Test {
 protected:
  void Highwall(const std::string& arguments) {
    const testing::Outcome outcome =
        testing::RunProgram(testing::kHighwallProgram, arguments, folder_.path());
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    out_ = outcome.out;
  }
  // [m] Median distance of a cloud, made with the poses of the run, from the surface of the room.
  double Error(const std::string& cloud) {
    Highwall("map compare " + cloud +
             " room/surface.ply --align run/trajectory.txt room/groundtruth.txt --spacing 0.05 "
             "--json");
    return json::parse(out_)["accuracy"]["median"];
  }

  const testing::TemporaryDirectory folder_{"corrected"};
  std::string out_;
};

// Rows are read out over 30 ms and depth is equally late, and the calibration states both.
TEST_F(CorrectedDepth, OfRowsIsTakenAtTheTimeOfItsPixelsByARunAndByAMapOfIt) {
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.seed = 3;
  options.duration = 4.0;
  options.fps = 15.0;
  options.readout = options.depth_readout = options.depth_delay = 0.03;
  const fs::path room = folder_ / "room";
  simulate::WriteTum(simulate::SimulateRoom(options), room);
  apps::RunConfig config = ReadSensor(room / "calibration.yaml");
  config.sensor.timing = {.colour_readout = 0.03, .depth_readout = 0.03, .depth_delay = 0.03};
  apps::WriteConfig(room / "calibration.yaml", config);
  Highwall("slam --dataset room --deterministic --out run");
  Highwall("map run --out again");
  Highwall("map run --raw --out raw");
  const double of_run = Error("run/cloud.ply"), again = Error("again/cloud.ply"),
               raw = Error("raw/cloud.ply");
  EXPECT_LT(of_run, 0.6 * raw);
  EXPECT_LT(again, 0.6 * raw);
}

// The first seconds are mapped before the depth distortion is known.
TEST_F(CorrectedDepth, OfAPatternThatIsFoundFollowsFromTheFirstKeyframeOn) {
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.duration = 10.0;
  options.fps = 15.0;
  options.sensor.depth_pattern = 0.05;
  simulate::WriteTum(simulate::SimulateRoom(options), folder_ / "room");
  Highwall("slam --dataset room --deterministic --out run");
  Highwall("map run --out again");
  Highwall("map run --raw --out raw");
  const double of_run = Error("run/cloud.ply"), again = Error("again/cloud.ply"),
               raw = Error("raw/cloud.ply");
  EXPECT_LT(of_run, 0.9 * raw);
  // The run corrects the rows of its keyframes by the estimate of their times at that moment.
  EXPECT_NEAR(of_run, again, 0.1 * again);
}

}  // namespace
}  // namespace highwall::corrected_depth_test
