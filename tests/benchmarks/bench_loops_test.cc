// Runs highwall_bench_loops in the same way as a user, on little data.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::bench_loops_test {
namespace {

using nlohmann::json;
using testing::Outcome;

Outcome Bench(const std::string& options) {
  return testing::RunProgram(testing::kBenchLoops, options);
}

TEST(BenchLoops, ComparesIndexesAndClosesALoop) {
  const Outcome outcome = Bench(
      "--parts index,correction --index-keyframes 40 --corrected-keyframes 60 --seeds 2 "
      "--json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["index"]["keyframes"], 40);
  ASSERT_GE(report["index"]["indexes"].size(), 3u);
  for (const json& index : report["index"]["indexes"]) {
    EXPECT_EQ(index["right"], 1.0) << index["index"] << ": four places are not many";
    EXPECT_GT(index["query_ms"], 0.0);
  }
  ASSERT_EQ(report["correction"].size(), 1u);
  const json& correction = report["correction"][0];
  EXPECT_GE(correction["keyframes"], 50);
  EXPECT_EQ(correction["closed"], 2);
  EXPECT_GT(correction["corrected_s"]["median"], 0.0);
  EXPECT_GT(correction["adjusted_s"]["median"], correction["corrected_s"]["median"]);
  EXPECT_LT(correction["rmse_after_m"]["worst"], correction["rmse_before_m"]["median"]);
}

TEST(BenchLoops, PutsTrueAndFalseLoopsToAMap) {
  const Outcome outcome = Bench("--parts acceptance --map-keyframes 50 --seeds 1 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out)["acceptance"];
  ASSERT_EQ(report["loops"].size(), 4u);
  for (const json& row : report["loops"]) {
    EXPECT_EQ(row["true"]["accepted"], row["true"]["asked"]) << row.dump();
    EXPECT_EQ(row["inside"]["accepted"], row["inside"]["asked"]) << row.dump();
    EXPECT_EQ(row["outside"]["accepted"], 0) << row.dump();
  }
  EXPECT_EQ(report["repeated"].front()["verified"], 1) << "it is the same place";
  EXPECT_EQ(report["repeated"].back()["verified"], 0) << "nothing is where it was";
}

TEST(BenchLoops, RefusesUnknownValues) {
  EXPECT_EQ(Bench("--parts mazes").exit_code, 1);
  EXPECT_EQ(Bench("--seeds 0").exit_code, 1);
}

}  // namespace
}  // namespace highwall::bench_loops_test
