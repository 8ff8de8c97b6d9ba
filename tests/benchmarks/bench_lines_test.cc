// Runs highwall_bench_lines in the same way as a user, on a few windows.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::bench_lines_test {
namespace {

using nlohmann::json;

testing::Outcome Bench(const std::string& options) {
  return testing::RunProgram(testing::kBenchLines, options);
}

json Rows(const std::string& options) {
  const testing::Outcome outcome = Bench(options + " --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return json::parse(outcome.out);
}

TEST(BenchLines, WithoutNoiseEveryFormFindsTheTruth) {
  const json rows = Rows("--seeds 2 --noise 0 --holds 0.1");
  ASSERT_EQ(rows.size(), 12U) << "with and without depth, two slides, three forms";
  for (const json& row : rows) {
    SCOPED_TRACE(row.dump());
    EXPECT_EQ(row["converged"], 1.0);
    // Keyframes start with errors of 30 mm and a degree; steps end at 1e-8 of the values.
    EXPECT_LT(row["position_mm"], 1e-4);
    EXPECT_LT(row["angle_deg"], 1e-5);
    EXPECT_LT(row["line_95_mm"], 1e-4);
  }
}

TEST(BenchLines, OnlyFreeEndsMeetOnTheirLineUnderNoise) {
  const json rows = Rows("--seeds 2 --slides 40 --holds 0.01");
  ASSERT_EQ(rows.size(), 6U);
  for (std::size_t first = 0; first < rows.size(); first += 3) {
    const json &orthonormal = rows[first], &free = rows[first + 1], &held = rows[first + 2];
    SCOPED_TRACE(free["depth"]);
    EXPECT_EQ(orthonormal["form"], "orthonormal");
    EXPECT_GT(free["shrunk"], 0.9);
    // Redundancy of 500 or more per window, two windows: 0.2 is 4 sigma.
    EXPECT_NEAR(orthonormal["chi2_over_redundancy"], 1.0, 0.2);
    EXPECT_LT(free["chi2_over_redundancy"], 0.8);
    EXPECT_EQ(held["shrunk"], 0.0);
    EXPECT_GT(free["line_median_mm"], 2.0 * orthonormal["line_median_mm"].get<double>());
    EXPECT_LT(held["line_median_mm"], 2.0 * orthonormal["line_median_mm"].get<double>());
  }
}

TEST(BenchLines, TheTableIsTheSameOnEveryRunAndTimesAreShownOnRequest) {
  const testing::Outcome table = Bench("--seeds 2");
  ASSERT_EQ(table.exit_code, 0) << table.err;
  EXPECT_EQ(table.out, Bench("--seeds 2").out);
  EXPECT_EQ(std::ranges::count(table.out, '\n'), 2 + 20);
  EXPECT_EQ(std::ranges::count(table.out, '|'), 22 * 14) << table.out;
  const std::string timed = Bench("--seeds 2 --times").out;
  EXPECT_EQ(std::ranges::count(timed, '|'), 22 * 15) << timed;
}

TEST(BenchLines, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("--seeds 0").exit_code, 1);
  EXPECT_EQ(Bench("--holds 0").exit_code, 1);
  EXPECT_EQ(Bench("--noise nan").exit_code, 1);
}

}  // namespace
}  // namespace highwall::bench_lines_test
