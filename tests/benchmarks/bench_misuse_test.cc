// Runs highwall_bench_misuse in the same way as a user, on a few generated frames.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::bench_misuse_test {
namespace {

using nlohmann::json;
using testing::Outcome;

Outcome Bench(const std::string& options) {
  return testing::RunProgram(testing::kBenchMisuse, options);
}

TEST(BenchMisuse, JsonHoldsEveryStrengthOfAFaultWithItsErrorAndItsFindings) {
  const Outcome outcome =
      Bench("--scenes room --seeds 1 --duration 0.5 --faults 'depth factor,unit of stamps' --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  ASSERT_EQ(report["misuses"].size(), 7U);
  for (const auto& [name, row] : report["misuses"].items()) {
    SCOPED_TRACE(name);
    ASSERT_EQ(row["runs"].size(), 1U);
    EXPECT_EQ(row["runs"][0]["recording"], "room 1");
    const bool found = !row["runs"][0]["findings"].empty();
    EXPECT_EQ(row["detected"], found ? 1.0 : 0.0);
    EXPECT_LE(row["named"], row["detected"]);
    EXPECT_FALSE(row.contains("ape_over_images_alone")) << "concerns no IMU";
  }
  // Lengths are a fifth, so that the camera seems to have stayed where it began.
  EXPECT_GT(report["misuses"]["depth factor x 5"]["ape_over_right"], 2.0);
  EXPECT_EQ(report["misuses_total"]["trials"], 7);
  EXPECT_EQ(report["right_total"]["trials"], 0) << "not asked for";
}

TEST(BenchMisuse, RightRecordingsAreScoredByTheirFalseAlarms) {
  const Outcome outcome = Bench("--scenes room --seeds 1 --duration 0.5 --faults right --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_TRUE(report["misuses"].empty());
  EXPECT_EQ(report["right"].size(), 13U);
  EXPECT_EQ(report["right_total"]["trials"], 13);
  for (const auto& [name, row] : report["right"].items()) {
    EXPECT_EQ(row["false_alarms"], 0.0) << name;
    // Noise alone, over a third of a metre.
    EXPECT_LT(row["ape_rmse_m"], 0.02) << name;
  }
}

TEST(BenchMisuse, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("--faults fog").exit_code, 1);
  EXPECT_EQ(Bench("--scenes cave").exit_code, 1);
  EXPECT_EQ(Bench("--seeds 0").exit_code, 1);
  EXPECT_EQ(Bench("--duration 0").exit_code, 1);
}

TEST(BenchMisuse, RefusesUnscorableRecordingsInOneLine) {
  testing::ExpectRefused(Bench("--scenes none --data nowhere"), 2, {"nowhere"});
}

}  // namespace
}  // namespace highwall::bench_misuse_test
