// Runs highwall_bench_tum as a user does, on a few generated frames.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/small_room.h"

namespace highwall {
namespace {

using nlohmann::json;
using testing::Outcome;

class BenchTum : public ::testing::Test {
 protected:
  void Film(const std::string& sequence, int frames) const {
    testing::FilmSmallRoom(folder_.path() / sequence, frames);
  }

  std::filesystem::path Folder(const std::string& sequence) const { return folder_ / sequence; }
  Outcome Bench(const std::string& options) const {
    return testing::RunProgram(HIGHWALL_BENCH_TUM,
                               "--data " + folder_.path().string() + " " + options);
  }

 private:
  testing::TemporaryDirectory folder_;
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
    // All of a frame holds its tracking, and the first frame a keyframe as well.
    EXPECT_GE(median["frame_ms"], median["tracking_ms"]);
    EXPECT_GT(median["frame_mean_ms"], median["tracking_ms"]);
  }
  EXPECT_EQ(report["sequences"]["room"]["points"]["median"]["lines"], 0.0);
  EXPECT_GT(report["sequences"]["room"]["both"]["median"]["lines"], 0.0);
}

TEST_F(BenchTum, AFrameThatCannotBeReadIsNotCovered) {
  Film("room", 5);
  const std::filesystem::directory_iterator image(Folder("room") / "rgb");
  testing::WriteText(image->path(), "no picture");
  const Outcome outcome = Bench("--sequences room --runs 1 --features both --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json figures = json::parse(outcome.out)["sequences"]["room"]["both"]["median"];
  EXPECT_DOUBLE_EQ(figures["coverage"].get<double>(), 0.8);
  EXPECT_EQ(figures["lost_frames"], 0.0);
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
  testing::ExpectRefused(Bench("--sequences nowhere --json"), 2, {"nowhere: does not exist"});
}

TEST_F(BenchTum, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("").exit_code, 1);
  EXPECT_EQ(Bench("--sequences a --features planes").exit_code, 1);
  EXPECT_EQ(Bench("--sequences a --runs 0").exit_code, 1);
}

}  // namespace
}  // namespace highwall
