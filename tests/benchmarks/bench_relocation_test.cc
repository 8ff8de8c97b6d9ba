// Runs highwall_bench_relocation in the same way as a user, on a few generated frames.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::bench_relocation_test {
namespace {

using nlohmann::json;
using testing::Outcome;

Outcome Bench(const std::string& options) {
  return testing::RunProgram(testing::kBenchRelocation, options);
}

TEST(BenchRelocation, JsonHoldsEverySeedOfEachPart) {
  const testing::TemporaryDirectory cache;
  const Outcome outcome = Bench("--seeds 1 --first-seed 2 --fps 5 --scale 0.25 --json --cache " +
                                cache.path().string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  for (const char* part : {"kidnap", "covered", "twins"}) {
    SCOPED_TRACE(part);
    ASSERT_EQ(report[part]["runs"].size(), 1U);
    const json& run = report[part]["runs"][0];
    EXPECT_EQ(run["seed"], 2);
    EXPECT_LT(run["known_at_first"], 0.05);
    EXPECT_TRUE(run.contains("missed"));
    // A known place is recognized again only where it is revisited.
    EXPECT_EQ(run.contains("known_again_s"), part != std::string("twins"));
  }
  EXPECT_GT(report["kidnap"]["runs"][0]["ape_without_kidnap_mm"], 0.0);
  // The frames of three seconds at five frames a second.
  EXPECT_EQ(report["covered"]["runs"][0]["lost_covered_frames"], 15);
  EXPECT_EQ(report["kidnap"]["runs"][0]["lost_covered_frames"], 0);
}

TEST(BenchRelocation, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("--parts abducted").exit_code, 1);
  EXPECT_EQ(Bench("--seeds 0").exit_code, 1);
  EXPECT_EQ(Bench("--fps 0").exit_code, 1);
  EXPECT_EQ(Bench("--scale 9").exit_code, 1);
}

}  // namespace
}  // namespace highwall::bench_relocation_test
