// Runs highwall_bench_tum --paired in the same way as a user, on a few generated frames.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <regex>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::bench_tum_paired_test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::Outcome;

class BenchTumPaired : public ::testing::Test {
 protected:
  void WriteSequence(const std::string& sequence, int frames) const {
    testing::WriteSmallRoom(folder_.path() / sequence, frames);
  }
  std::filesystem::path Folder(const std::string& sequence) const { return folder_ / sequence; }
  // Returns a switch for a calibration that makes everything in the room too near.
  std::string TooNear(const std::string& sequence) const {
    std::string text = testing::ReadText(Folder(sequence) / "calibration.yaml");
    text = std::regex_replace(text, std::regex("min: .*"), "min: 50");
    text = std::regex_replace(text, std::regex("max: .*"), "max: 60");
    testing::WriteText(folder_ / "too_near.yaml", text);
    return "--config too_near.yaml";
  }
  Outcome Bench(const std::string& options) const {
    return testing::RunProgram(testing::kBenchTum, "--data . " + options, folder_.path());
  }
  json Report(const std::string& options) const {
    const Outcome outcome = Bench(options + " --json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    return outcome.exit_code == 0 ? json::parse(outcome.out) : json();
  }

 private:
  testing::TemporaryDirectory folder_;
};

TEST_F(BenchTumPaired, EqualSettingsHaveARatioOfExactlyOne) {
  WriteSequence("room", 8);
  const json report =
      Report("--sequences room --runs 3 --step 2 --paired '' '--features \"both\"'");
  ASSERT_TRUE(report.contains("sequences"));
  const json& room = report["sequences"]["room"];
  EXPECT_EQ(room["compared"], 3);
  EXPECT_EQ(room["ratio"]["b_over_a"], 1.0);
  EXPECT_EQ(room["ratio"]["interval_95"], json({1.0, 1.0}));
  ASSERT_EQ(room["pairs"].size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const json& pair = room["pairs"][static_cast<std::size_t>(i)];
    EXPECT_EQ(pair["begin"], 2 * i);
    EXPECT_EQ(pair["common_frames"], 8 - 2 * i);
    EXPECT_EQ(pair["a"]["ape_rmse_m"], pair["b"]["ape_rmse_m"]);
    EXPECT_GT(pair["a"]["frame_ms"], 0.0);
  }
  EXPECT_NE(room["pairs"][0]["a"]["ape_rmse_m"], room["pairs"][1]["a"]["ape_rmse_m"]);
}

std::string Printed(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

TEST_F(BenchTumPaired, TheTableSaysHowTheSettingsDiffer) {
  WriteSequence("first", 7);
  WriteSequence("second", 9);
  const std::string options =
      "--sequences first,second --runs 2 --step 1 --paired '' '--features points --no-loops'";
  const json report = Report(options);
  const Outcome outcome = Bench(options);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(report["b"], "--features points --no-loops");
  double logs = 0.0;
  for (const char* name : {"first", "second"}) {
    SCOPED_TRACE(outcome.out);
    const json& sequence = report["sequences"][name];
    EXPECT_EQ(sequence["compared"], 2);
    double log = 0.0;
    for (const json& pair : sequence["pairs"]) {
      EXPECT_NE(pair["a"]["ape_rmse_m"], pair["b"]["ape_rmse_m"]);
      log += 0.5 * std::log(pair["b"]["ape_rmse_m"].get<double>() /
                            pair["a"]["ape_rmse_m"].get<double>());
    }
    EXPECT_NEAR(sequence["ratio"]["log_mean"].get<double>(), log, 1e-12);
    logs += 0.5 * log;
    // Times are not compared, because they are from another run.
    const auto mm = [&](const char* setting) {
      return Printed("%.2f", 1e3 * sequence[setting]["ape_rmse_m"].get<double>());
    };
    const json& interval = sequence["ratio"]["interval_95"];
    const std::regex row(std::string("\n") + name + " +2 +" + mm("a") + " +" + mm("b") + " +" +
                         Printed("%.3f", std::exp(log)) + " +" +
                         Printed("%.3f", interval[0].get<double>()) + " to " +
                         Printed("%.3f", interval[1].get<double>()) + " +0 +0 +[0-9.]+ +[0-9.]+\n");
    EXPECT_TRUE(std::regex_search(outcome.out, row));
  }
  EXPECT_NEAR(report["all"]["these"]["log_mean"].get<double>(), logs, 1e-12);
  EXPECT_TRUE(Contains(outcome.out, "geometric mean of 2 sequences: B/A " +
                                        Printed("%.3f", std::exp(logs)) + "; 95 %: "));
  EXPECT_TRUE(Contains(outcome.out, "\nA: (default)\nB: --features points --no-loops\n"));
}

TEST_F(BenchTumPaired, AnotherBuildRunsTheSecondSettingFromTheSameBeginning) {
  WriteSequence("room", 8);
  const std::string options = "--sequences room --runs 2 --step 3 --paired '' ";
  const json here = Report(options + "'--features points'")["sequences"]["room"];
  const json there = Report(options + "'--features points' --paired-program " +
                            std::string(testing::kHighwallProgram));
  EXPECT_EQ(there["program_of_b"], testing::kHighwallProgram);
  for (std::size_t i = 0; i < 2; ++i) {
    const json &mine = here["pairs"][i], &other = there["sequences"]["room"]["pairs"][i];
    EXPECT_EQ(other["common_frames"], 8 - 3 * i);
    EXPECT_EQ(other["a"]["ape_rmse_m"], mine["a"]["ape_rmse_m"]);
    // Its poses are read from a file with nine decimals.
    EXPECT_NEAR(other["b"]["ape_rmse_m"].get<double>(), mine["b"]["ape_rmse_m"].get<double>(),
                1e-8);
    EXPECT_GT(other["b"]["frame_ms"], 0.0);
  }
}

TEST_F(BenchTumPaired, ARunThatIsLostIsNamedAndCounted) {
  WriteSequence("room", 5);
  const std::string options =
      "--sequences room --runs 2 --step 1 --paired '' '" + TooNear("room") + "'";
  const Outcome outcome = Bench(options);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  SCOPED_TRACE(outcome.out);
  EXPECT_TRUE(std::regex_search(outcome.out, std::regex("\nroom +0 +- +- +- +- +0 +9 ")));
  EXPECT_TRUE(Contains(outcome.out, "not compared: room from frame 1: B has 0 of 4 frames"));
  EXPECT_TRUE(Contains(outcome.out, "\nnot compared: 2 of 2 pairs\n"));
  const json report = Report(options);
  EXPECT_EQ(report["all"]["sequences"], 0);
  EXPECT_TRUE(report["sequences"]["room"]["ratio"].is_null());
  EXPECT_FALSE(report["sequences"]["room"]["a"].contains("ape_rmse_m"));
  const json pair = Report(options + " --paired-program " +
                           std::string(testing::kHighwallProgram))["sequences"]["room"]["pairs"][0];
  EXPECT_TRUE(Contains(pair["not_compared"], "no frame could be tracked")) << pair;
  EXPECT_EQ(pair["b"]["lost_frames"], 5);
}

TEST_F(BenchTumPaired, ASettingThatIsNoneIsOneLine) {
  const auto refused = [&](const std::string& options, const std::vector<std::string>& parts) {
    SCOPED_TRACE(options);
    testing::ExpectRefused(Bench("--sequences room " + options), 1, parts);
  };
  refused("--paired '' '--features planes'", {"setting B, '--features planes'", "planes"});
  refused("--paired '--points-only' ''", {"setting A, '--points-only'", "not expected"});
  refused("--paired '' '--live'", {"setting B", "--deterministic excludes --live"});
  refused("--paired '' '--help'", {"setting B"});
  refused("--paired ''", {"--paired", "2 required"});
  refused("--paired '' '' --features both", {"--features excludes --paired"});
  refused("--paired '' '' --step 0", {"--step", "is 0"});
  refused("--step 2", {"--step requires --paired"});
  refused("--paired-program x", {"--paired-program requires --paired"});
}

TEST_F(BenchTumPaired, RefusesAnImpossiblePairInOneLineBeforeTheFirstRun) {
  WriteSequence("room", 6);
  const auto refused = [&](const std::string& options, const std::vector<std::string>& parts) {
    SCOPED_TRACE(options);
    testing::ExpectRefused(Bench("--sequences room --runs 2 " + options), 2, parts);
  };
  refused("--paired '' '' --paired-program ./none", {"./none: cannot be run"});
  refused("--paired '' '--nope' --paired-program " + std::string(testing::kHighwallProgram),
          {"highwall slam", "--nope"});
  refused("--paired '' '--imu paper'", {"has no IMU"});
  refused("--paired '' '' --step 6", {"has 6 frames, too few"});
  std::filesystem::remove(Folder("room") / "groundtruth.txt");
  refused("--paired '' ''", {"groundtruth.txt", "is missing"});
}

}  // namespace
}  // namespace highwall::bench_tum_paired_test
