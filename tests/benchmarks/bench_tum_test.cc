// Runs highwall_bench_tum in the same way as a user, on a few generated frames.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::bench_tum_test {
namespace {

using nlohmann::json;
using testing::Outcome;

class BenchTum : public ::testing::Test {
 protected:
  void WriteSequence(const std::string& sequence, int frames) const {
    testing::WriteSmallRoom(folder_.path() / sequence, frames);
  }

  std::filesystem::path Folder(const std::string& sequence) const { return folder_ / sequence; }
  Outcome Bench(const std::string& options) const {
    return testing::RunProgram(testing::kBenchTum,
                               "--data " + folder_.path().string() + " " + options);
  }

 private:
  testing::TemporaryDirectory folder_;
};

TEST_F(BenchTum, JsonHoldsEveryRunAndTheirMedians) {
  WriteSequence("room", 6);
  const Outcome outcome = Bench("--sequences room --runs 2 --features points,both --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["runs"], 2);
  ASSERT_EQ(report["sequences"]["room"].size(), 2U);
  for (const char* features : {"points", "both"}) {
    SCOPED_TRACE(features);
    const json& entry = report["sequences"]["room"][features];
    EXPECT_EQ(entry["runs"].size(), 2U);
    const json& median = entry["median"];
    EXPECT_GE(median["ape_rmse_m"], 0.0);
    EXPECT_LT(median["ape_rmse_m"], 0.02);  // six frames of a slow walk
    EXPECT_EQ(median["coverage"], 1.0);
    EXPECT_EQ(median["lost_frames"], 0.0);
    EXPECT_GT(median["tracking_ms"], 0.0);
    EXPECT_GT(median["orb_ms"], 0.0);
    EXPECT_GT(median["processor_ms"], 0.0);
    // The time of a frame includes its tracking, and that of the first frame also a keyframe.
    EXPECT_GE(median["frame_ms"], median["tracking_ms"]);
    EXPECT_GT(median["frame_mean_ms"], median["tracking_ms"]);
  }
  EXPECT_EQ(report["sequences"]["room"]["points"]["median"]["lines"], 0.0);
  EXPECT_GT(report["sequences"]["room"]["both"]["median"]["lines"], 0.0);
}

TEST_F(BenchTum, AFrameThatCannotBeReadIsNotCovered) {
  WriteSequence("room", 5);
  const std::filesystem::directory_iterator image(Folder("room") / "rgb");
  testing::WriteText(image->path(), "no picture");
  const Outcome outcome = Bench("--sequences room --runs 1 --features both --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json figures = json::parse(outcome.out)["sequences"]["room"]["both"]["median"];
  EXPECT_DOUBLE_EQ(figures["coverage"].get<double>(), 0.8);
  EXPECT_EQ(figures["lost_frames"], 0.0);
}

// One wrong figure of a run, with all others right, violates one of these.
TEST_F(BenchTum, FiguresOfARunAgreeWithEachOther) {
  constexpr int kFrames = 6;
  WriteSequence("room", kFrames);
  const Outcome outcome = Bench("--sequences room --runs 3 --features both --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json entry = json::parse(outcome.out)["sequences"]["room"]["both"];
  ASSERT_EQ(entry["runs"].size(), 3U);
  for (const json& run : entry["runs"]) {
    const auto figure = [&](const char* name) { return run.at(name).get<double>(); };
    // Depth is noisy: no run is free of error; six frames of a slow walk drift by less than 2 cm.
    for (const char* error : {"ape_rmse_m", "rpe_1_frame_rmse_m"}) {
      EXPECT_GT(figure(error), 1e-6) << error;
      EXPECT_LT(figure(error), 0.02) << error;
    }
    EXPECT_EQ(figure("rpe_30_frames_rmse_m"), -1.0) << "there are six frames";
    EXPECT_GE(figure("keyframes"), 1.0);
    EXPECT_LE(figure("keyframes"), kFrames);
    EXPECT_GT(figure("points"), 100.0);
    EXPECT_GT(figure("lines"), 5.0);
    EXPECT_LT(figure("lines"), figure("points"));
    EXPECT_GE(figure("tracking_p99_ms"), figure("tracking_ms"));
    EXPECT_GE(figure("frame_p95_ms"), figure("frame_ms"));
    EXPECT_GE(figure("frame_p99_ms"), figure("frame_p95_ms"));
    EXPECT_GE(figure("frame_worst_ms"), figure("frame_p99_ms"));
    EXPECT_GE(figure("frame_p99_ms"), figure("tracking_p99_ms")) << "tracking is part of it";
    EXPECT_GT(figure("mapping_ms"), 0.0);
    EXPECT_EQ(figure("tracking_over_orb"), figure("tracking_ms") / figure("orb_ms"));
    EXPECT_EQ(figure("processor_over_orb"), figure("processor_ms") / figure("orb_processor_ms"));
    EXPECT_GT(figure("processor_over_orb"), 0.0);
    EXPECT_GT(figure("decoding_processor_ms"), 0.0);
    // Half of the frames take at least the median.
    const double half = 0.5 * kFrames * 1e-3;  // [s / ms]
    EXPECT_GT(figure("seconds"), half * figure("frame_ms"));
  }
  for (const auto& [name, median] : entry["median"].items()) {
    std::vector<double> values;
    for (const json& run : entry["runs"]) values.push_back(run.at(name).get<double>());
    std::sort(values.begin(), values.end());
    EXPECT_EQ(median, values[1]) << name;
  }
}

// Returns the cell of a row under the column of this name; both end at the same position.
std::string Cell(const std::string& header, const std::string& row, const std::string& column) {
  const std::size_t at = (header + " ").find(" " + column + " ");
  if (at == std::string::npos) return "no column " + column;
  const std::size_t end = at + 1 + column.size();
  const std::size_t begin = row.find_last_of(' ', end - 1);
  return row.substr(begin + 1, end - begin - 1);
}

TEST_F(BenchTum, TableHoldsTheFiguresOfEachSequence) {
  WriteSequence("first", 2);
  WriteSequence("second", 6);
  const std::string options = "--sequences first,second --runs 1 --features both --deterministic";
  const Outcome outcome = Bench(options), in_json = Bench(options + " --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(in_json.exit_code, 0) << in_json.err;
  const json report = json::parse(in_json.out);
  std::istringstream lines(outcome.out);
  std::string header, row;
  std::getline(lines, header);
  for (const char* sequence : {"first", "second"}) {
    SCOPED_TRACE(outcome.out);
    std::getline(lines, row);
    EXPECT_EQ(row.rfind(std::string(sequence) + " ", 0), 0U);
    EXPECT_NE(row.find(" both "), std::string::npos);
    const json& median = report["sequences"][sequence]["both"]["median"];
    const auto expect = [&](const char* column, const char* figure, const char* format) {
      char text[32];
      std::snprintf(text, sizeof(text), format, median.at(figure).get<double>());
      EXPECT_EQ(Cell(header, row, column), text) << column;
    };
    expect("APE m", "ape_rmse_m", "%.5f");
    expect("RPE1 m", "rpe_1_frame_rmse_m", "%.5f");
    expect("RPE30 m", "rpe_30_frames_rmse_m", "%.5f");
    expect("cover", "coverage", "%.3f");
    expect("lost", "lost_frames", "%.0f");
    expect("kf", "keyframes", "%.0f");
    const auto cell = [&](const char* column) {
      return std::atof(Cell(header, row, column).c_str());
    };
    // Times are from another run: only relations that hold in any run. Hundredths of a millisecond.
    EXPECT_GT(cell("track ms"), 0.0);
    EXPECT_GE(cell("track 99"), cell("track ms"));
    EXPECT_GE(cell("frame 99"), cell("track 99"));
    EXPECT_GE(cell("frame 95"), cell("frame ms"));
    EXPECT_GE(cell("worst"), cell("frame 99"));
    EXPECT_GT(cell("cpu ms"), 0.0);
    EXPECT_GT(cell("ORB ms"), 0.0);
    EXPECT_NEAR(cell("ratio"), cell("track ms") / cell("ORB ms"),
                0.005 + 0.005 * (1.0 + cell("ratio")) / (cell("ORB ms") - 0.005));
  }
}

TEST_F(BenchTum, ShowsTheProcessorTimeInUnitsOfOrbOnRequest) {
  WriteSequence("room", 4);
  const std::string kept = " --out " + Folder("kept").string();
  const std::string sweep = "--sequences room --runs 1 --features both --deterministic" + kept;
  const Outcome with = Bench(sweep + " --unit"), without = Bench(sweep);
  ASSERT_EQ(with.exit_code, 0) << with.err;
  ASSERT_EQ(without.exit_code, 0) << without.err;
  std::istringstream lines(with.out);
  std::string header, row;
  std::getline(lines, header);
  std::getline(lines, row);
  const double ratio = std::atof(Cell(header, row, "cpu/ORB").c_str());
  EXPECT_GT(ratio, 0.0);
  EXPECT_FALSE(testing::Contains(without.out, "cpu/ORB"));
  EXPECT_TRUE(testing::Contains(without.out, "cpu ms"));
  // The run is kept: the other forms show the same figure.
  const json report = json::parse(Bench(sweep + " --json").out);
  EXPECT_NEAR(report["sequences"]["room"]["both"]["median"]["processor_over_orb"].get<double>(),
              ratio, 0.005 + 1e-9);
  for (const char* figure : {"processor_ms", "processor_over_orb", "frame_worst_ms"}) {
    EXPECT_TRUE(testing::Contains(testing::ReadText(Folder("kept/runs.csv")), figure)) << figure;
  }
  EXPECT_FALSE(testing::Contains(Bench(sweep + " --markdown").out, "per frame [ORB]"));
  const std::string table = Bench(sweep + " --markdown --unit").out;
  EXPECT_TRUE(
      testing::Contains(table, "| processor, per frame [ms] | processor, per frame [ORB] |"))
      << table;
}

TEST_F(BenchTum, LiveRunsShowDroppedFramesDelaysAndCausalErrors) {
  WriteSequence("room", 6);
  const std::string sweep =
      "--sequences room --runs 1 --features points --out " + Folder("kept").string();
  const Outcome live = Bench(sweep + " --live --rate 0.5");
  ASSERT_EQ(live.exit_code, 0) << live.err;
  for (const char* title : {"causal", "drop", "delay 99"}) {
    EXPECT_TRUE(testing::Contains(live.out, title)) << live.out;
  }
  const json report = json::parse(Bench(sweep + " --live --rate 0.5 --json").out);
  const json& figures = report["sequences"]["room"]["points"]["median"];
  EXPECT_EQ(figures["frames"], 6.0) << "dropped ones included";
  EXPECT_GE(figures["dropped_frames"], 0.0);
  EXPECT_GT(figures["delay_ms"], 0.0);
  EXPECT_GE(figures["delay_p99_ms"], figures["delay_ms"]);
  EXPECT_GT(figures["causal_ape_rmse_m"], 0.0);
  EXPECT_LT(figures["causal_ape_rmse_m"], 0.02);  // six frames of a slow walk
  // A kept run is not taken for one at another pace.
  testing::ExpectRefused(Bench(sweep + " --live --json"), 2,
                         {"is of", "live at 0.5 times the pace"});
  testing::ExpectRefused(Bench(sweep + " --json"), 2, {"is of", "live at 0.5 times the pace"});
}

TEST_F(BenchTum, OtherRunsHaveNoColumnsOfLiveOnes) {
  WriteSequence("room", 4);
  const Outcome outcome = Bench("--sequences room --runs 1 --features points --deterministic");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(testing::Contains(outcome.out, "causal")) << outcome.out;
  EXPECT_FALSE(testing::Contains(outcome.out, "delay")) << outcome.out;
}

TEST_F(BenchTum, ALiveRunIsNotDeterministic) {
  testing::ExpectRefused(Bench("--sequences room --live --deterministic"), 1,
                         {"--live", "--deterministic"});
  testing::ExpectRefused(Bench("--sequences room --rate 2"), 1, {"--rate", "--live"});
}

TEST_F(BenchTum, AMissingSequenceIsOneLineAndExitCodeTwo) {
  testing::ExpectRefused(Bench("--sequences nowhere --json"), 2, {"nowhere: does not exist"});
}

TEST_F(BenchTum, WrongUsageExitsWithOne) {
  EXPECT_EQ(Bench("").exit_code, 1);
  EXPECT_EQ(Bench("--sequences a --features planes").exit_code, 1);
  testing::ExpectRefused(Bench("--sequences a --features point"), 1, {"did you mean 'points'?"});
  EXPECT_EQ(Bench("--sequences a --runs 0").exit_code, 1);
}

}  // namespace
}  // namespace highwall::bench_tum_test
