// Tests the verdict of `highwall slam` on a recording and its configuration.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>

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
  void MakeDepthConstant() const {
    for (const auto& file : fs::directory_iterator(dataset() / "depth")) {
      const cv::Mat depth = cv::imread(file.path().string(), cv::IMREAD_UNCHANGED);
      ASSERT_TRUE(
          cv::imwrite(file.path().string(), cv::Mat(depth.size(), CV_16UC1, cv::Scalar(10'000))));
    }
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

TEST_F(SlamVerdict, AContradictionIsSaidBeforeAndAfterAndFailsIfStrict) {
  MakeDepthConstant();
  const Outcome outcome = Slam("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(outcome.err.starts_with("highwall slam: warning: depth is the same at all pixels"))
      << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "verdict     not to be trusted: ")) << outcome.out;
  EXPECT_EQ(Verdict()["trust"], "not to be trusted");
  EXPECT_EQ(Verdict()["findings"][0]["fault"], "constant depth");
  EXPECT_EQ(Slam("--strict").exit_code, 3);
}

}  // namespace
}  // namespace highwall::slam_verdict_test
