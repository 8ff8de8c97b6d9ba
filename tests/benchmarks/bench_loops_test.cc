// Runs highwall_bench_loops as a user does, on little.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "../apps/run_program.h"

namespace highwall {
namespace {

using nlohmann::json;
using testing::Outcome;

Outcome Bench(const std::string& options) {
  return testing::RunProgram(HIGHWALL_BENCH_LOOPS, options);
}

TEST(BenchLoops, ComparesIndexesAndClosesALoop) {
  const Outcome outcome =
      Bench("--parts index,correction --index-keyframes 40 --corrected-keyframes 60 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["index"]["keyframes"], 40);
  ASSERT_GE(report["index"]["indexes"].size(), 3u);
  for (const json& index : report["index"]["indexes"]) {
    EXPECT_EQ(index["right"], 1.0) << index["index"] << ": four places are not many";
    EXPECT_GT(index["query_ms"], 0.0);
  }
  const json& correction = report["correction"];
  EXPECT_GE(correction["keyframes"], 50);
  EXPECT_GT(correction["corrected_s"], 0.0);
  EXPECT_GT(correction["adjusted_s"], correction["corrected_s"]);
  EXPECT_LT(correction["rmse_after_m"], correction["rmse_before_m"]);
}

TEST(BenchLoops, RefusesWhatItDoesNotKnow) {
  EXPECT_EQ(Bench("--parts mazes").exit_code, 1);
  EXPECT_EQ(Bench("--seeds 0").exit_code, 1);
}

}  // namespace
}  // namespace highwall
