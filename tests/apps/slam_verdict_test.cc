// Tests the verdict of `highwall slam` on a recording and its configuration.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_verdict_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

class SlamVerdict : public ::testing::Test {
 protected:
  SlamVerdict() { testing::WriteSmallRoom(dataset(), 20); }

  fs::path dataset() const { return folder_.path() / "dataset"; }
  fs::path run() const { return folder_.path() / "run"; }
  Outcome Slam(const std::string& options) const {
    return testing::RunProgram(testing::kHighwallProgram, "slam --dataset " + dataset().string() +
                                                              " --out " + run().string() +
                                                              " --overwrite " + options);
  }
  json Verdict() const { return json::parse(ReadText(run() / "run.json"))["verdict"]; }
  // Depth five times as far, beyond what the dense map takes.
  void MakeDepthFar() const {
    const fs::path file = dataset() / "calibration.yaml";
    std::string text = ReadText(file);
    const std::size_t at = text.find("depth_factor:");
    ASSERT_NE(at, std::string::npos) << text;
    text.replace(at, text.find('\n', at) - at, "depth_factor: 1000");
    WriteText(file, text);
  }

 private:
  testing::TemporaryDirectory folder_;
};

TEST_F(SlamVerdict, ARightRecordingIsConsistent) {
  const Outcome outcome = Slam("--strict --report");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(outcome.out.ends_with("verdict     consistent\n")) << outcome.out;
  EXPECT_EQ(Verdict()["trust"], "consistent");
  EXPECT_TRUE(Verdict()["findings"].empty());
  EXPECT_TRUE(
      Contains(ReadText(run() / "report.html"), "Recording and configuration: consistent."));
}

TEST_F(SlamVerdict, AnEmptyDenseMapIsFoundAndStrictFails) {
  MakeDepthFar();
  const Outcome outcome = Slam("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "verdict     doubtful: ") ||
              Contains(outcome.out, "verdict     not to be trusted: "))
      << outcome.out;
  EXPECT_TRUE(Contains(Verdict().dump(), "the dense map is empty")) << Verdict();
  EXPECT_EQ(Slam("--strict").exit_code, 3);
}

}  // namespace
}  // namespace highwall::slam_verdict_test
