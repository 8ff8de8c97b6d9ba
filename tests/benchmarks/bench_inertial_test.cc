// Runs highwall_bench_inertial in the same way as a user, on a few generated frames.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::bench_inertial_test {
namespace {

using nlohmann::json;
using testing::Outcome;
using testing::TemporaryDirectory;

Outcome Bench(const std::string& options) {
  return testing::RunProgram(testing::kBenchInertial, options);
}

TEST(BenchInertial, JsonHoldsEverySeedAndTheMediansOfEachPolicy) {
  const TemporaryDirectory cache;
  const std::string options =
      "--scenes room --seeds 1 --duration 1 --fps 6 --imu off,fixed:1 --json --cache " +
      cache.path().string();
  const Outcome first = Bench(options);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.err, "");
  const json report = json::parse(first.out);
  for (const char* policy : {"off", "fixed:1"}) {
    SCOPED_TRACE(policy);
    const json& entry = report["sequences"]["room"][policy];
    ASSERT_EQ(entry["runs"].size(), 1U);
    EXPECT_EQ(entry["runs"][0]["seed"], 1);
    EXPECT_EQ(entry["median"]["coverage"], 1.0);
    EXPECT_EQ(entry["median"]["lost_frames"], 0.0);
    EXPECT_LT(entry["median"]["ape_rmse_m"], 0.02);  // over a path of half a metre
    EXPECT_EQ(entry["median"].contains("mean_weight"), policy == std::string("fixed:1"));
  }
  // The sequence is kept and reused.
  const std::filesystem::path images = cache.path() / "room_seed1_1s_6fps" / "rgb";
  ASSERT_TRUE(std::filesystem::exists(images));
  const auto written = std::filesystem::last_write_time(images);
  const Outcome second = Bench(options);
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(std::filesystem::last_write_time(images), written);
  EXPECT_EQ(json::parse(second.out)["sequences"]["room"]["off"]["median"]["ape_rmse_m"],
            report["sequences"]["room"]["off"]["median"]["ape_rmse_m"]);
}

TEST(BenchInertial, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("--scenes cave").exit_code, 1);
  EXPECT_EQ(Bench("--imu always").exit_code, 1);
  EXPECT_EQ(Bench("--imu consistent,fixed:0").exit_code, 1);
  EXPECT_EQ(Bench("--inertial rigid").exit_code, 1);
  EXPECT_EQ(Bench("--seeds 0").exit_code, 1);
  EXPECT_EQ(Bench("--time-offset 1").exit_code, 1);
}

TEST(BenchInertial, ACacheThatCannotBeMadeIsOneLineAndExitCodeTwo) {
  testing::ExpectRefused(Bench("--cache /dev/null/cache --json"), 2, {"/dev/null/cache"});
}

}  // namespace
}  // namespace highwall::bench_inertial_test
