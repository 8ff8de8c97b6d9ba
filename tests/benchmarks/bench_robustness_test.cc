// Runs highwall_bench_robustness in the same way as a user, on a few generated frames.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::bench_robustness_test {
namespace {

using nlohmann::json;
using testing::Outcome;

constexpr int kFrames = 12;

class BenchRobustness : public ::testing::Test {
 protected:
  void WriteSequence(const std::string& sequence, int frames = kFrames) const {
    testing::WriteSmallRoom(folder_.path() / sequence, frames);
  }
  std::filesystem::path Folder(const std::string& sequence) const { return folder_ / sequence; }
  // Runs the benchmark; the figures go to Table() by default.
  Outcome Bench(const std::string& options, const std::string& file = "table.json") const {
    return testing::RunProgram(testing::kBenchRobustness, options + " --json " + file,
                               folder_.path());
  }
  json Table() const { return json::parse(testing::ReadText(folder_ / "table.json")); }

 private:
  testing::TemporaryDirectory folder_;
};

// Returns the cells of the row that begins with `name`.
std::vector<std::string> Cells(const std::string& table, const std::string& name) {
  std::istringstream lines(table);
  std::vector<std::string> cells;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| " + name + " |", 0) != 0) continue;
    std::istringstream row(line.substr(2));
    for (std::string cell; std::getline(row, cell, '|');) {
      while (!cell.empty() && cell.front() == ' ') cell.erase(0, 1);
      while (!cell.empty() && cell.back() == ' ') cell.pop_back();
      cells.push_back(cell);
    }
  }
  return cells;
}

std::string Printed(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

TEST_F(BenchRobustness, EveryColumnMatchesTheSequence) {
  WriteSequence("room");
  WriteSequence("other", 5);
  // An unreadable image yields no pose; no other pose is lost in so short a walk.
  std::vector<std::filesystem::path> images;
  for (const auto& file : std::filesystem::directory_iterator(Folder("room") / "rgb")) {
    images.push_back(file.path());
  }
  std::ranges::sort(images);
  testing::WriteText(images.at(7), "no picture");

  const Outcome outcome = Bench(
      "--dataset room --second other --only '^(every 2nd frame|no depth from frame 50|depth holes "
      "10 %|kidnapped)$'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.out.rfind("### room\n", 0), 0U);
  const json report = Table();
  EXPECT_EQ(report["seed"], 1);
  EXPECT_EQ(report["runs"], 1);
  const json& rows = report["sequences"]["room"];
  ASSERT_EQ(rows.size(), 5U);

  const auto expect = [&](const char* name, const char* frames, int scored, int lost) {
    SCOPED_TRACE(name);
    const json& median = rows[name]["median"];
    ASSERT_EQ(rows[name]["runs"].size(), 1U);
    EXPECT_EQ(median["frames"], scored);
    EXPECT_EQ(median["without_pose"], lost);
    EXPECT_EQ(median["merges"], 0);
    EXPECT_EQ(median["loops"], 0);
    // Depth is noisy: no run is free of error; frames of a slow walk drift by less than 2 cm.
    const double ape = median["ape_rmse_m"];
    EXPECT_GT(ape, 1e-6);
    EXPECT_LT(ape, 0.02);
    EXPECT_FALSE(median.contains("drift_m_per_m")) << "the walk is shorter than a metre";
    const double ratio = ape / rows["untouched"]["median"]["ape_rmse_m"].get<double>();
    EXPECT_DOUBLE_EQ(median["ape_over_untouched"].get<double>(), ratio);
    const std::vector<std::string> cells = Cells(outcome.out, name);
    ASSERT_EQ(cells.size(), 9U) << outcome.out;
    EXPECT_EQ(cells[1], frames);
    EXPECT_EQ(cells[2], std::to_string(lost));
    EXPECT_EQ(cells[3], lost > 0 ? "7" : "-");
    EXPECT_EQ(cells[4], std::to_string(median["maps"].get<int>()));
    EXPECT_EQ(cells[5], "0");
    EXPECT_EQ(cells[6], Printed("%.1f mm", 1e3 * ape));
    EXPECT_EQ(cells[7], Printed("%.2f", ratio));
    EXPECT_EQ(cells[8], "-");
  };
  expect("untouched", "12", 12, 1);
  expect("every 2nd frame", "6", 6, 0);  // the seventh is left out
  expect("depth holes 10 %", "12", 12, 1);
  expect("no depth from frame 50", "12", 12, 1);
  EXPECT_EQ(rows["untouched"]["median"]["maps"], 1);
  EXPECT_EQ(rows["untouched"]["median"]["elsewhere"], 0);
  EXPECT_EQ(rows["untouched"]["median"]["first_without_pose"], 7);
  // There are only 12 frames: nothing is changed.
  EXPECT_EQ(rows["no depth from frame 50"]["median"], rows["untouched"]["median"]);
  EXPECT_NE(rows["depth holes 10 %"]["median"]["ape_rmse_m"],
            rows["untouched"]["median"]["ape_rmse_m"]);
}

// The first five frames of the same walk are not another place: the map recognizes them correctly.
TEST_F(BenchRobustness, FramesElsewhereAreCountedApart) {
  WriteSequence("room");
  WriteSequence("other", 5);
  const Outcome outcome = Bench("--dataset room --second other --only kidnapped");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json median = Table()["sequences"]["room"]["kidnapped"]["median"];
  EXPECT_EQ(median["frames"], kFrames);
  EXPECT_EQ(median["without_pose"], 0);
  EXPECT_FALSE(median.contains("first_without_pose"));
  EXPECT_EQ(median["elsewhere"], 5);
  EXPECT_EQ(median["elsewhere_taken_home"], 5);
  EXPECT_EQ(median["maps"], 1);
  EXPECT_EQ(Cells(outcome.out, "kidnapped").at(1), "12 + 5 elsewhere (5 taken for home)");
}

TEST_F(BenchRobustness, SeveralRunsHaveSeveralSeedsAndOneSeedTheSameBytes) {
  WriteSequence("room", 6);
  const std::string options = "--dataset room --max-frames 5 --only 'noise 25'";
  ASSERT_EQ(Bench(options + " --seed 4 --runs 3").exit_code, 0);
  const json three = Table()["sequences"]["room"]["noise 25"];
  ASSERT_EQ(three["runs"].size(), 3U);
  EXPECT_EQ(three["median"]["frames"], 5);
  EXPECT_NE(three["runs"][0]["ape_rmse_m"], three["runs"][1]["ape_rmse_m"]);
  ASSERT_EQ(Bench(options + " --seed 5").exit_code, 0);
  EXPECT_EQ(Table()["sequences"]["room"]["noise 25"]["runs"][0], three["runs"][1]);
}

TEST_F(BenchRobustness, WhereNothingIsTrackedThereIsNoError) {
  WriteSequence("room", 4);
  // There are no surfaces nearer than a metre.
  const Outcome outcome = Bench("--dataset room --only 'depth to 1 m'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json row = Table()["sequences"]["room"]["depth to 1 m"];
  EXPECT_EQ(row["median"]["without_pose"], 4);
  EXPECT_EQ(row["median"]["maps"], 0);
  EXPECT_EQ(row["runs"][0]["reasons"], json({{"no depth", 4}}));
  const std::vector<std::string> cells{"depth to 1 m", "4", "4", "0", "0", "0", "-", "-", "-"};
  EXPECT_EQ(Cells(outcome.out, "depth to 1 m"), cells);
}

TEST_F(BenchRobustness, RefusesUnscorableSequencesInOneLineWithExitCodeTwo) {
  testing::ExpectRefused(Bench("--dataset nowhere"), 2, {"nowhere"});
  WriteSequence("room", 2);
  testing::ExpectRefused(Bench("--dataset room --dataset ./room/"), 2,
                         {"has the name of another dataset"});
  testing::ExpectRefused(Bench("--dataset room --second nowhere"), 2, {"nowhere"});
  testing::ExpectRefused(Bench("--dataset room", "nowhere/table.json"), 2, {"nowhere/table.json"});
  std::filesystem::remove(Folder("room") / "groundtruth.txt");
  testing::ExpectRefused(Bench("--dataset room"), 2, {"groundtruth.txt", "is missing or empty"});
}

TEST_F(BenchRobustness, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("").exit_code, 1);
  EXPECT_EQ(Bench("--dataset room --only '('").exit_code, 1);
  EXPECT_EQ(Bench("--dataset room --runs 0").exit_code, 1);
  EXPECT_EQ(Bench("--dataset room --max-frames 1").exit_code, 1);
}

}  // namespace
}  // namespace highwall::bench_robustness_test
