// Runs highwall_bench_tum as a user does, on a few generated frames.
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "../frontend/generated_tum.h"
#include "simulate/room.h"
#include "simulate/tum_writer.h"

namespace highwall {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::TemporaryDirectory;

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class BenchTum : public ::testing::Test {
 protected:
  fs::path data() const { return folder_.path(); }

  void Film(const std::string& sequence, int frames) const {
    simulate::SimulationOptions options;
    options.camera = {
        .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
    options.duration = frames / options.fps;
    simulate::WriteTum(simulate::SimulateRoom(options), data() / sequence);
  }

  Outcome Bench(const std::string& options) const {
    const std::string out = data() / "stdout", err = data() / "stderr";
    const std::string command = HIGHWALL_BENCH_TUM " --data " + data().string() + " " + options +
                                " > " + out + " 2> " + err;
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadText(out), ReadText(err)};
  }

 private:
  TemporaryDirectory folder_;
};

TEST_F(BenchTum, JsonHoldsEveryRunAndTheirMedians) {
  Film("room", 6);
  const Outcome outcome = Bench("--sequences room --runs 2 --features points,both --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["runs"], 2);
  ASSERT_EQ(report["sequences"]["room"].size(), 2U);
  for (const char* features : {"points", "both"}) {
    SCOPED_TRACE(features);
    const json& entry = report["sequences"]["room"][features];
    EXPECT_EQ(entry["runs"].size(), 2U);
    const json& median = entry["median"];
    EXPECT_GE(median["ape_rmse_m"], 0.0);
    EXPECT_LT(median["ape_rmse_m"], 0.02);  // six frames of a slow walk
    EXPECT_EQ(median["coverage"], 1.0);
    EXPECT_EQ(median["lost_frames"], 0.0);
    EXPECT_GT(median["tracking_ms"], 0.0);
    EXPECT_GT(median["orb_ms"], 0.0);
  }
  EXPECT_EQ(report["sequences"]["room"]["points"]["median"]["lines"], 0.0);
  EXPECT_GT(report["sequences"]["room"]["both"]["median"]["lines"], 0.0);
}

TEST_F(BenchTum, TableHasARowForEachSequence) {
  Film("first", 2);
  Film("second", 2);
  const Outcome outcome = Bench("--sequences first,second --runs 1 --features both");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("\nfirst "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("\nsecond "), std::string::npos) << outcome.out;
}

TEST_F(BenchTum, AMissingSequenceIsOneLineAndExitCodeTwo) {
  const Outcome outcome = Bench("--sequences nowhere --json");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("nowhere: does not exist"), std::string::npos) << outcome.err;
}

TEST_F(BenchTum, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("").exit_code, 1);
  EXPECT_EQ(Bench("--sequences a --features planes").exit_code, 1);
  EXPECT_EQ(Bench("--sequences a --runs 0").exit_code, 1);
}

}  // namespace
}  // namespace highwall
