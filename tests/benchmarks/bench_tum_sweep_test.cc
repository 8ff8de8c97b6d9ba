// Runs sweeps of highwall_bench_tum in the same way as a user, on a few generated frames.
#include <signal.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::bench_tum_sweep_test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

class BenchTumSweep : public ::testing::Test {
 protected:
  void WriteSequence(const std::string& sequence, int frames) const {
    testing::WriteSmallRoom(folder_.path() / sequence, frames);
  }
  std::filesystem::path File(const std::string& name) const { return folder_ / name; }
  Outcome Run(const std::string& program, const std::string& arguments) const {
    return testing::RunProgram(program, arguments, folder_.path());
  }
  Outcome Bench(const std::string& options) const { return Run(testing::kBenchTum, options); }
  std::string Printed(const std::string& options) const {
    const Outcome outcome = Bench(options);
    EXPECT_EQ(outcome.exit_code, 0) << options << ": " << outcome.err;
    return outcome.out;
  }
  json Report(const std::string& options) const {
    const std::string text = Printed(options + " --json");
    return text.empty() ? json() : json::parse(text);
  }
  void Refuse(const std::string& options, int code, const std::vector<std::string>& parts) const {
    SCOPED_TRACE(options);
    testing::ExpectRefused(Bench(options), code, parts);
  }

 private:
  testing::TemporaryDirectory folder_;
};

// Keeps the figures that do not depend on processing time.
json WithoutTimes(json report) {
  json kept;
  const json flat = report["sequences"].flatten();
  for (const auto& [place, value] : flat.items()) {
    const bool time = std::regex_search(place, std::regex("_ms$|seconds$|_mib$|_over_orb$"));
    if (!time) kept[place] = value;
  }
  return kept;
}

TEST_F(BenchTumSweep, AnInterruptedSweepContinuesWhereItEnded) {
  WriteSequence("room", 5);
  const std::string sweep = "--data . --sequences room --runs 3 --features both --out kept";
  Report(sweep);
  const std::filesystem::path kept = File("kept/runs/room/both/1.json");
  json record = json::parse(ReadText(kept));
  EXPECT_EQ(record["figures"]["coverage"], 1.0);
  record["figures"]["coverage"] = 0.125;  // a value that no run gives
  WriteText(kept, record.dump());
  std::filesystem::remove(File("kept/runs/room/both/2.json"));
  const json runs = Report(sweep)["sequences"]["room"]["both"]["runs"];
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_EQ(runs[0]["coverage"], 0.125) << "it was run again";
  EXPECT_EQ(runs[1]["coverage"], 1.0);
  EXPECT_TRUE(std::filesystem::exists(File("kept/runs/room/both/2.json")));
  for (const char* table : {"figures.json", "runs.csv", "table.md"}) {
    EXPECT_TRUE(std::filesystem::exists(File("kept") / table)) << table;
  }
}

TEST_F(BenchTumSweep, ASignalEndsItWithTheTablesOfTheRunsDone) {
  WriteSequence("first", 4);
  WriteSequence("second", 40);
  const std::string out = File("kept").string();
  testing::BackgroundProgram program(
      testing::kBenchTum, {"--data", File("").string(), "--sequences", "first,second", "--runs",
                           "1", "--features", "points", "--deterministic", "--out", out});
  while (program.IsRunning() && !std::filesystem::exists(File("kept/runs/first/points/1.json"))) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(program.IsRunning());
  program.Send(SIGTERM);
  EXPECT_EQ(program.ExitCode(), 143);
  EXPECT_FALSE(std::filesystem::exists(File("kept/runs/second"))) << "a part of a run";
  const std::string table = ReadText(File("kept/table.md"));
  EXPECT_TRUE(Contains(table, "first") && !Contains(table, "second")) << table;
  const json whole = Report("--data . --sequences first,second --runs 1 --features points " +
                            std::string("--deterministic --out kept"));
  EXPECT_EQ(whole["sequences"].size(), 2U);
}

TEST_F(BenchTumSweep, ARunOfOtherSwitchesIsNotTakenForThisOne) {
  WriteSequence("room", 3);
  const std::string sweep = "--data . --sequences room --runs 1 --out kept --setting ";
  Report(sweep + "mine='--features points'");
  Refuse(sweep + "mine='--no-loops' --json", 2,
         {"mine/1.json: is of '--features points'", "--out"});
  Refuse(sweep + "mine='--features points' --deterministic --json", 2, {"mine/1.json: is of"});
}

TEST_F(BenchTumSweep, ShardsOfGnuParallelInOneFolderAreTheWholeSweep) {
  // The parallel of moreutils takes other arguments.
  if (std::system("parallel --version 2> /dev/null | grep -q '^GNU parallel'") != 0) {
    GTEST_SKIP() << "GNU parallel is not installed";
  }
  WriteSequence("room", 4);
  const std::string sweep =
      "--data . --sequences room --runs 2 --features points,both --deterministic";
  const json whole = Report(sweep + " --out whole");
  const Outcome parts = Run("parallel", "-j 2 " + std::string(testing::kBenchTum) + " " + sweep +
                                            " --out parts --shard {}/2 ::: 1 2");
  EXPECT_EQ(parts.exit_code, 0) << parts.err;
  EXPECT_EQ(WithoutTimes(Report("merge parts --out parts")), WithoutTimes(whole));
  EXPECT_EQ(testing::CountLines(ReadText(File("parts/runs.csv"))), 1U + 4U);
}

TEST_F(BenchTumSweep, ShardsThatAreMergedAreTheWholeSweep) {
  WriteSequence("room", 4);
  const std::string sweep =
      "--data . --sequences room --scenes room --duration 1 --fps 4 --scale 0.25 --seeds 2 --runs "
      "1 "
      "--features points,both --deterministic --out ";
  const json whole = Report(sweep + "whole");
  EXPECT_EQ(Printed(sweep + "part1 --shard 1/2 --markdown"), "") << "a part has no table";
  Printed(sweep + "part2 --shard 2/2 --json");
  EXPECT_FALSE(std::filesystem::exists(File("part1/figures.json")));
  const json merged = Report("merge part1 part2 --out all");
  EXPECT_EQ(WithoutTimes(merged), WithoutTimes(whole));
  EXPECT_EQ(merged["sequences"]["room_1s_4fps_scale0.25"]["both"]["runs"][1]["seed"], 2);
  EXPECT_EQ(WithoutTimes(json::parse(ReadText(File("all/figures.json")))), WithoutTimes(whole));
  EXPECT_EQ(testing::CountLines(ReadText(File("all/runs.csv"))), 1U + 6U);
  const std::string markdown = Printed("merge part1 part2 --markdown --sequences room");
  EXPECT_EQ(testing::CountLines(markdown), 4U) << markdown;
  EXPECT_TRUE(Contains(markdown, "| room | points | 1 |"));
  Refuse("merge part1 part1", 2, {"is in another of the sweeps as well"});
  Refuse("merge nowhere", 2, {"nowhere/runs: holds no run"});
}

TEST_F(BenchTumSweep, TablesHoldEveryStatisticAndTheLossReasons) {
  WriteSequence("room", 5);
  const json entry = Report("--data . --sequences room --runs 2 --dense --setting all=''");
  const json& row = entry["sequences"]["room"]["all"];
  const json& run = row["runs"][0];
  for (const char* figure : {"ape_max_m", "ape_mean_m", "ape_median_m", "ape_min_m", "ape_rmse_m",
                             "ape_sse_m2", "ape_std_m", "rpe_1_frame_std_m", "frames", "submaps",
                             "peak_memory_mib", "frame_p99_ms", "cloud_mb", "octree_mb"}) {
    ASSERT_TRUE(run.contains(figure)) << figure;
    EXPECT_GE(row["high"][figure], row["median"][figure]) << figure;
    EXPECT_LE(row["low"][figure], row["median"][figure]) << figure;
  }
  EXPECT_EQ(run["frames"], 5.0);
  EXPECT_NEAR(run["ape_sse_m2"].get<double>(), 5.0 * std::pow(run["ape_rmse_m"].get<double>(), 2),
              1e-12);
  EXPECT_GT(run["cloud_mb"], run["octree_mb"]);
  EXPECT_LT(run["peak_memory_mib"], 4000.0);
}

TEST_F(BenchTumSweep, AnotherSystemIsScoredOnTheSameFrames) {
  WriteSequence("room", 8);
  const std::string sweep = "--data . --sequences room --runs 2 --features both --deterministic ";
  Printed(sweep + "--out kept");
  std::filesystem::create_directories(File("other"));
  const std::string trajectory = ReadText(File("kept/runs/room/both/1.txt"));
  WriteText(File("other/room_1.txt"), trajectory);
  WriteText(File("other/room_2.txt"),
            trajectory.substr(0, trajectory.rfind('\n', trajectory.size() - 2) + 1));
  const json against =
      Report("merge kept --data . --reference same=other")["references"]["same"]["room"]["both"];
  EXPECT_EQ(against["frames"], 8);
  EXPECT_EQ(against["common_frames"], 7) << "one run lacks the last";
  EXPECT_EQ(against["own"]["coverage"], 1.0);
  EXPECT_EQ(against["other"]["runs"], 2);
  EXPECT_EQ(against["own"]["ape_rmse_m"], against["other"]["ape_rmse_m"]);
  EXPECT_EQ(against["ape_ratio"]["value"], 1.0);
  const std::string text = Printed(sweep + "--reference same=other");
  EXPECT_TRUE(Contains(text, "| room | both | same | 2 / 2 | 7 of 8 | 1.000 / 1.000 |")) << text;
  EXPECT_TRUE(Contains(text, "| 1.000 | 1.000 to 1.000 |")) << text;
  Refuse("merge kept --data . --json --reference none=kept", 2, {"kept: has no SEQUENCE_*.txt"});
  Refuse("merge kept --data . --reference other", 1, {"a reference is NAME=DIR"});
}

TEST_F(BenchTumSweep, ThePapersTablesHaveItsFiguresBesideOurs) {
  WriteSequence("rgbd_dataset_freiburg2_desk_with_person", 5);
  WriteSequence("fr1_xyz", 5);
  const std::string text = Printed(
      "--data . --sequences rgbd_dataset_freiburg2_desk_with_person,fr1_xyz --runs 1 --paper");
  EXPECT_TRUE(Contains(text,
                       "| the paper | 0.018487 | 0.005951 | 0.005655 | 0.001261 | 0.006580 | "
                       "0.006278 | 0.002808 | 145 |"))
      << text;
  EXPECT_TRUE(Contains(text, "| the paper | - | 0.005585 | - | - | 0.006751 | - | - | - |"));
  EXPECT_TRUE(Contains(text, "| fr1_xyz | the paper | 7.3 | 0.0457 | 160 |"));
  for (const char* setting : {"points", "points_and_lines", "as_the_paper"}) {
    const std::string number = " [0-9]\\.[0-9]{6} \\|";
    const std::string row = std::string("\\| fr1_xyz \\| ") + setting + " \\|";
    std::string errors = row;
    for (int i = 0; i < 7; ++i) errors += number;
    EXPECT_TRUE(std::regex_search(text, std::regex(errors + " 5 \\|\n"))) << setting << text;
    EXPECT_TRUE(std::regex_search(text, std::regex(errors + " 4 \\|\n"))) << setting << text;
    EXPECT_TRUE(std::regex_search(text, std::regex(row + " [0-9.]+ \\| 0\\.[0-9]+ \\| [0-9]+ \\|")))
        << setting;
  }
}

TEST_F(BenchTumSweep, AFigureThatMovesFailsWithBothValuesUntilItIsRenewed) {
  const json description{
      {"sweep",
       {{"seeds", 1},
        {"scenes", {{{"scene", "room"}, {"duration_s", 1}, {"fps", 4}, {"scale", 0.25}}}},
        {"settings", {{"points", "--features points"}}}}},
      {"tolerances", {{"ape_rmse_m", 0.01}, {"lost_frames", 0}}},
      {"figures", json::object()}};
  WriteText(File("figures.json"), description.dump());
  Outcome outcome = Bench("figures figures.json --data scenes");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_TRUE(Contains(outcome.out, "room_1s_4fps_scale0.25/points/ape_rmse_m: was nan"));
  EXPECT_TRUE(Contains(outcome.err, "figures have moved"));
  Printed("figures figures.json --data scenes --renew");
  EXPECT_EQ(Printed("figures figures.json --data scenes"), "");
  json report = json::parse(ReadText(File("figures.json")));
  json& figure = report["figures"]["room_1s_4fps_scale0.25"]["points"]["ape_rmse_m"];
  const double right = figure;
  EXPECT_GT(right, 0.0);
  figure = 1.02 * right;
  WriteText(File("figures.json"), report.dump());
  outcome = Bench("figures figures.json --data scenes");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(testing::CountLines(outcome.out), 2U) << outcome.out;
  EXPECT_TRUE(Contains(outcome.out, "/points/ape_rmse_m: was 0.0"));
  EXPECT_TRUE(Contains(outcome.out, ", is 0.0"));
  EXPECT_TRUE(Contains(outcome.out, "highwall_bench_tum figures figures.json --renew"));
}

TEST_F(BenchTumSweep, RefusesInvalidSweepsInOneLine) {
  const std::string sweep = "--data . --sequences room ";
  Refuse("--data .", 1, {"--sequences or --scenes"});
  Refuse(sweep + "--setting points", 1, {"--setting", "NAME=SWITCHES", "points"});
  Refuse(sweep + "--setting a/b=''", 1, {"letters, digits"});
  Refuse(sweep + "--setting 'a=--features planes'", 1, {"setting a, '--features planes'"});
  Refuse(sweep + "--setting a='' --features both", 1, {"--setting excludes --features"});
  Refuse(sweep + "--shard 3/2", 1, {"a shard is NUMBER/COUNT"});
  Refuse(sweep + "--seeds 2", 1, {"--seeds requires --scenes"});
  Refuse(sweep + "--json --markdown", 1, {"--json", "--markdown"});
  Refuse(sweep + "--paired '' '' --out kept", 1, {"--paired excludes --out"});
  Refuse("merge", 1, {"highwall_bench_tum merge: sweeps is required"});
  Refuse("figures none.json", 2, {"none.json: cannot be read"});
}

}  // namespace
}  // namespace highwall::bench_tum_sweep_test
