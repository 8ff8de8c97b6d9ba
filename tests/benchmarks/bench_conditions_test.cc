// Runs highwall_bench_conditions in the same way as a user, on a few generated frames.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::bench_conditions_test {
namespace {

using nlohmann::json;
using testing::Outcome;

Outcome Bench(const std::string& options) {
  return testing::RunProgram(testing::kBenchConditions, options);
}

TEST(BenchConditions, JsonHoldsEverySeedAndTheMediansOfEachRun) {
  const Outcome outcome =
      Bench("--parts moving,depth --scenes room --seeds 1 --duration 0.6 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  ASSERT_EQ(report["moving"].size(), 3U);
  ASSERT_EQ(report["depth"].size(), 2U);
  for (const json& part : report) {
    for (const auto& [name, row] : part.items()) {
      SCOPED_TRACE(name);
      ASSERT_EQ(row["runs"].size(), 1U);
      EXPECT_EQ(row["runs"][0]["seed"], 1);
      EXPECT_EQ(row["median"]["lost_frames"], 0.0);
      // Depth is 4 % too long, over a path of a third of a metre.
      EXPECT_LT(row["median"]["ape_rmse_m"], 0.02);
      EXPECT_FALSE(row["median"].contains("scale"));  // unobservable in so short a time
    }
  }
  EXPECT_TRUE(report["moving"]["room, traffic"]["median"].contains("ape_change_percent"));
}

TEST(BenchConditions, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("--parts fog").exit_code, 1);
  EXPECT_EQ(Bench("--scenes cave").exit_code, 1);
  EXPECT_EQ(Bench("--seeds 0").exit_code, 1);
  EXPECT_EQ(Bench("--contrast 0").exit_code, 1);
}

TEST(BenchConditions, ASequenceThatEndsBeforeTheStretchIsOneLine) {
  testing::ExpectRefused(Bench("--parts texture --seeds 1 --duration 5"), 3,
                         {"ends before the stretch of low_texture"});
  testing::ExpectRefused(Bench("--parts dark --seeds 1 --duration 5"), 3,
                         {"ends before the stretch of low_light"});
}

TEST(BenchConditions, RefusesToBeginBeyondTheSequence) {
  testing::ExpectRefused(Bench("--parts moving --scenes room --seeds 1 --duration 0.6 --starts 6"),
                         3, {"--starts must leave two frames"});
}

}  // namespace
}  // namespace highwall::bench_conditions_test
