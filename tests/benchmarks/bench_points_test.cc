// Runs highwall_bench_points in the same way as a user, on a few generated images.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::bench_points_test {
namespace {

using nlohmann::json;

testing::Outcome Bench(const std::string& options) {
  return testing::RunProgram(testing::kBenchPoints, options);
}

TEST(BenchPoints, MostMatchesOfNearViewsAreRightInEitherMetric) {
  const testing::Outcome outcome = Bench("--gaps 2 --seeds 1 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json rows = json::parse(outcome.out);
  ASSERT_EQ(rows.size(), 2U);
  for (const json& row : rows) {
    SCOPED_TRACE(row["detector"]);
    EXPECT_GT(row["native_precision"], 0.9);
    EXPECT_GT(row["bits_precision"], 0.9);
    EXPECT_LT(row["right_bits_median"], row["wrong_bits_10"]);
  }
  EXPECT_EQ(rows[0]["bits_right"], rows[0]["native_right"]) << "ORB has 256 bits of its own";
}

TEST(BenchPoints, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("--detectors surf").exit_code, 1);
  EXPECT_EQ(Bench("--gaps 0").exit_code, 1);
}

}  // namespace
}  // namespace highwall::bench_points_test
