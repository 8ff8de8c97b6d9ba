// Checks what `highwall slam` reports of its time: wall time of whole frames, processor time of its
// threads, and the trace of their stages.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/file_size_limit.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_clock_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Outcome;
using testing::ReadText;

class SlamClock : public ::testing::Test {
 protected:
  fs::path File(const std::string& name) const { return folder_.path() / name; }
  // Twelve frames that are far enough apart to become several keyframes.
  void WriteSequence() const {
    simulate::SimulationOptions options = testing::SmallRoomOptions();
    options.fps = 6.0;
    options.duration = 2.0;
    simulate::WriteTum(simulate::SimulateRoom(options), File("dataset"));
  }
  Outcome Slam(const std::string& options) const {
    return testing::RunProgram(testing::kHighwallProgram,
                               "slam --dataset dataset --out run " + options, folder_.path());
  }
  json Report(const std::string& options) const {
    if (!fs::exists(File("dataset"))) WriteSequence();
    const Outcome outcome = Slam(options + " --json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(outcome.out);
  }

 private:
  const testing::TemporaryDirectory folder_;
};

void ExpectHonest(const json& report) {
  const json& seconds = report["processor_seconds"];
  double sum = 0.0;
  for (const auto& [name, of_thread] : seconds["threads"].items()) {
    EXPECT_GE(of_thread, 0.0) << name;
    sum += of_thread.get<double>();
  }
  const double process = seconds["process"];
  EXPECT_NEAR(sum, process, 1e-9 * process) << "the others are the rest";
  EXPECT_GT(seconds["threads"]["tracking"], 0.0);
  EXPECT_GT(seconds["decoding"], 0.0);
  EXPECT_LT(seconds["decoding"], seconds["process"]);
  EXPECT_NEAR(report["processor_ms_per_frame"].get<double>(),
              1e3 * (process - seconds["decoding"].get<double>()) / 12.0, 1e-6);
}

TEST_F(SlamClock, ProcessorTimeIsThatOfTheThreads) {
  const json report = Report("");
  ExpectHonest(report);
  const json& threads = report["processor_seconds"]["threads"];
  for (const char* thread : {"features", "decoding", "local mapping", "dense mapping"}) {
    ASSERT_TRUE(threads.contains(thread)) << threads;
    EXPECT_GT(threads[thread], 0.0) << thread;
  }
  // The thread does little else.
  EXPECT_GE(threads["decoding"], report["processor_seconds"]["decoding"]);
}

TEST_F(SlamClock, OnOneThreadItIsThatOfTheCaller) {
  const json report = Report("--deterministic");
  ExpectHonest(report);
  const json& seconds = report["processor_seconds"];
  std::set<std::string> names;
  for (const auto& [name, of_thread] : seconds["threads"].items()) names.insert(name);
  EXPECT_EQ(names, (std::set<std::string>{"others", "tracking"}));
  EXPECT_LT(seconds["decoding"], seconds["threads"]["tracking"]);
  // One thread cannot use more than the time that passes; the two clocks are read one after the
  // other, and only that of the time is slewed.
  EXPECT_LE(seconds["threads"]["tracking"].get<double>(),
            1.01 * report["seconds"].get<double>() + 0.1);
}

TEST_F(SlamClock, AFrameIncludesItsKeyframe) {
  const json report = Report("--deterministic");
  const json& times = report["milliseconds"];
  EXPECT_EQ(times["frame"]["count"], 12);
  EXPECT_GE(times["frame"]["p95"], times["frame"]["median"]);
  EXPECT_GE(times["frame"]["p99"], times["frame"]["p95"]);
  EXPECT_GE(times["frame"]["worst"], times["frame"]["p99"]);
  EXPECT_GT(times["mapping"]["count"], 0);
  EXPECT_GE(times["frame"]["worst"], times["mapping"]["worst"]);
  double worst = 0.0;
  for (const json& frame : report["per_frame"]["milliseconds"]) {
    worst = std::max(worst, frame.get<double>());
  }
  EXPECT_NEAR(times["frame"]["worst"].get<double>(), worst, 0.005 + 1e-9);  // rounded to 0.01
}

struct Stage {
  std::string name;
  double begin = 0.0, end = 0.0;  // [us]
};

// Stages by the name of their thread. Expects that stages of a thread nest.
std::map<std::string, std::vector<Stage>> ReadTrace(const fs::path& file) {
  std::map<int, std::string> names;
  std::map<std::string, std::vector<Stage>> threads;
  for (const json& event : json::parse(ReadText(file))) {
    EXPECT_EQ(event["pid"], 1);
    if (event["ph"] == "M") {
      if (event["name"] == "thread_name") {
        names[event["tid"].get<int>()] = event["args"]["name"].get<std::string>();
      }
      continue;
    }
    EXPECT_EQ(event["ph"], "X");
    const double begin = event["ts"], duration = event["dur"];
    EXPECT_GE(begin, 0.0);
    EXPECT_GE(duration, 0.0);
    threads[names.at(event["tid"].get<int>())].push_back(
        {event["name"].get<std::string>(), begin, begin + duration});
  }
  constexpr double kRounding = 1e-4;  // [us] of the sum, whose terms have whole nanoseconds
  for (auto& [thread, stages] : threads) {
    std::ranges::sort(stages, [](const Stage& a, const Stage& b) {
      return a.begin != b.begin ? a.begin < b.begin : a.end > b.end;
    });
    std::vector<Stage> open;
    for (const Stage& stage : stages) {
      while (!open.empty() && open.back().end <= stage.begin + kRounding) open.pop_back();
      if (!open.empty()) {
        EXPECT_LE(stage.end, open.back().end + kRounding)
            << thread << ": " << stage.name << " ends after " << open.back().name;
      }
      open.push_back(stage);
    }
  }
  return threads;
}

std::set<std::string> NamesOf(const std::vector<Stage>& stages) {
  std::set<std::string> names;
  for (const Stage& stage : stages) names.insert(stage.name);
  return names;
}

std::ptrdiff_t Count(const std::vector<Stage>& stages, const std::string& name) {
  return std::ranges::count(stages, name, &Stage::name);
}

TEST_F(SlamClock, TheTraceHoldsTheStagesOfEachThread) {
  Report("--trace traces/of/room.json");  // in a folder that is missing
  auto threads = ReadTrace(File("traces/of/room.json"));
  EXPECT_EQ(Count(threads["tracking"], "frame"), 12);
  EXPECT_GE(Count(threads["decoding"], "decoding"), 12);
  EXPECT_LE(Count(threads["decoding"], "decoding"), 13);  // one more may find the end
  const std::set<std::string> caller = NamesOf(threads["tracking"]);
  for (const char* stage : {"next image", "features", "tracking", "prediction", "pose", "local map",
                            "timing", "keyframe insertion", "loop search", "refined frames"}) {
    EXPECT_TRUE(caller.contains(stage)) << stage;
  }
  // The caller may take both tasks of the team.
  std::vector<Stage> features = threads["features"];
  features.insert(features.end(), threads["tracking"].begin(), threads["tracking"].end());
  EXPECT_EQ(Count(features, "points"), 24);
  EXPECT_EQ(Count(features, "lines"), 24);
  EXPECT_TRUE(NamesOf(threads["local mapping"]).contains("local adjustment"));
  EXPECT_TRUE(NamesOf(threads["dense mapping"]).contains("keyframe"));
}

TEST_F(SlamClock, OnOneThreadTheTraceHasOneThread) {
  Report("--deterministic --trace trace.json");
  const auto threads = ReadTrace(File("trace.json"));
  ASSERT_EQ(threads.size(), 1U);
  const std::set<std::string> caller = NamesOf(threads.at("tracking"));
  for (const char* stage : {"decoding", "points", "lines", "local adjustment", "keyframe"}) {
    EXPECT_TRUE(caller.contains(stage)) << stage;
  }
}

TEST_F(SlamClock, TheTraceChangesNoResult) {
  Report("--deterministic --no-map");
  const std::string without = ReadText(File("run/trajectory.txt"));
  Report("--deterministic --no-map --trace trace.json");
  EXPECT_EQ(ReadText(File("run/trajectory.txt")), without);
}

TEST_F(SlamClock, ATraceThatCannotBeWrittenIsNamed) {
  fs::create_directories(File("folder"));
  testing::ExpectRefused(Slam("--trace folder"), 2, {"folder: is not a file"});
  std::ofstream(File("file")) << "precious";
  testing::ExpectRefused(Slam("--trace file/trace.json"), 2, {"is a file"});
  EXPECT_EQ(Slam("--trace ''").exit_code, 1);
  WriteSequence();
  std::ofstream(File("trace.json")) << "of before";
  Outcome outcome;
  {
    const testing::FileSizeLimit limit(4000);  // [byte] a frame has at least 13 events of 60
    outcome = Slam("--no-map --trace trace.json");
  }
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_TRUE(testing::Contains(outcome.err, "trace.json: could not be written whole"))
      << outcome.err;
  EXPECT_EQ(ReadText(File("trace.json")), "of before");
}

}  // namespace
}  // namespace highwall::slam_clock_test
