// Runs benchmarks/sweep/Snakefile in the same way as a user, on generated sequences: on this
// machine, and on a Slurm cluster of its own.
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::snakemake_test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

constexpr int kCannotRunHere = 77;  // exit code of with_slurm

class Snakemake : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v snakemake > /dev/null 2>&1") != 0) {
      GTEST_SKIP() << "snakemake is not installed";
    }
    WriteText(folder_ / "sweep.yaml",
              "bench: " + std::string(testing::kBenchTum) +
                  "\n"
                  "highwall: " +
                  std::string(testing::kHighwallProgram) +
                  "\n"
                  "data: data\n"
                  "out: out\n"
                  "sequences: []\n"
                  "generated: {room_a: room --duration 1 --fps 5 --scale 0.25 --imu off}\n"
                  "settings: {points: --features points, both: --no-loops}\n"
                  "runs: 2\n"
                  "lockstep: true\n"
                  "references: {same: other}\n"
                  "memory_mb: 1000\n");
    std::filesystem::create_directories(folder_ / "other");
    WriteText(folder_ / "other/room_a_1.txt", "");
  }
  Outcome Run(const std::string& before, const std::string& options) const {
    return testing::RunProgram(before + "snakemake",
                               "-s " + std::string(testing::kSourceFolder) + "/benchmarks/sweep" +
                                   "/Snakefile --configfile sweep.yaml " + options,
                               folder_.path());
  }
  // Returns the figures in the folder that do not depend on time.
  json Figures(const std::string& folder) const {
    json kept;
    const json flat =
        json::parse(ReadText(folder_ / folder / "figures.json"))["sequences"].flatten();
    for (const auto& [place, value] : flat.items()) {
      const bool time = std::regex_search(place, std::regex("_ms$|seconds$|_mib$|_over_orb$"));
      if (!time) kept[place] = value;
    }
    return kept;
  }
  // Returns the result of the benchmark without Snakemake.
  json FiguresOfTheBenchmark() const {
    const Outcome outcome = testing::RunProgram(
        testing::kBenchTum,
        "--data data --sequences room_a --setting points='--features points' --setting "
        "both=--no-loops --runs 2 --deterministic --json --out alone",
        folder_.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Figures("alone");
  }

  testing::TemporaryDirectory folder_;
};

TEST_F(Snakemake, TwoCoresGiveTheTableOfTheBenchmark) {
  Outcome outcome = Run("", "--cores 2");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Figures("out"), FiguresOfTheBenchmark());
  EXPECT_EQ(Figures("out/scores/room_a"), Figures("out"));
  EXPECT_TRUE(Contains(ReadText(folder_ / "out/table.md"), "| room_a | points | same | 2 / 1 |"));
  outcome = Run("", "--cores 2");
  EXPECT_TRUE(Contains(outcome.err, "Nothing to be done")) << outcome.err;
  // The sweep looks as if it had been interrupted before the last run.
  std::filesystem::remove(folder_ / "out/runs/room_a/both/2.json");
  std::filesystem::remove_all(folder_ / "out/scores");
  std::filesystem::remove(folder_ / "out/figures.json");
  outcome = Run("", "--cores 2");
  EXPECT_TRUE(Contains(outcome.err, "3 of 3 steps (100%) done")) << "run, score, tables";
}

TEST_F(Snakemake, SlurmGivesTheTableOfTheBenchmark) {
  const Outcome outcome =
      Run(std::string(testing::kSourceFolder) + "/tests/benchmarks/with_slurm" + " slurm ",
          "--profile " + std::string(testing::kSourceFolder) + "/benchmarks/sweep" +
              "/slurm --latency-wait 20");
  if (outcome.exit_code == kCannotRunHere) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "with external jobid")) << outcome.err;
  EXPECT_EQ(Figures("out"), FiguresOfTheBenchmark());
}

}  // namespace
}  // namespace highwall::snakemake_test
