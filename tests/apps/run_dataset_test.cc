#include "run/run_dataset.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "run/run_report.h"
#include "support/generated_tum.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::apps::run_dataset_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Outcome;
using testing::WriteText;

constexpr const char* kCamera =
    "camera: {width: 64, height: 48, fx: 50, fy: 50, cx: 31.5, cy: 23.5}\ndepth_factor: 5000\n";

// Two days with a recording "rec" each, a run of the first, and a user who works in the second.
class RunDataset : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* day : {"day1", "day2"}) {
      testing::WriteTum(folder_ / day / "rec");
      WriteText(folder_ / day / "rec" / "calibration.yaml", kCamera);
    }
    fs::create_directories(run());
    fs::current_path(folder_ / "day2");
  }
  void TearDown() override { fs::current_path(before_); }

  fs::path run() const { return folder_ / "day1" / "runs" / "run"; }
  fs::path Recording(const std::string& day) const { return folder_ / day / "rec"; }
  static json Report(const fs::path& dataset) {
    return {{"dataset", dataset.string()},
            {"per_frame", {{"stamp", {"100.000000", "100.500000"}}}}};
  }
  // Writes every stamp a second later.
  static void MakeLater(const fs::path& recording) {
    for (const char* list : {"rgb.txt", "depth.txt"}) {
      std::string text = testing::ReadText(recording / list);
      for (std::size_t at = text.find("100."); at != std::string::npos; at = text.find("100.")) {
        text.replace(at, 4, "101.");
      }
      WriteText(recording / list, text);
    }
  }

 private:
  const fs::path before_ = fs::current_path();

 protected:
  const testing::TemporaryDirectory folder_;
};

TEST_F(RunDataset, ReportNamesFilesSoThatTheyAreFoundFromAnywhere) {
  SlamRunOptions options;
  options.load_map = "old.hwmap";
  const json report = RunJson(SlamRun(), options, "rec", "rec/calibration.yaml");
  EXPECT_EQ(report["dataset"], (fs::current_path() / "rec").string());
  EXPECT_EQ(report["calibration"], (fs::current_path() / "rec/calibration.yaml").string());
  EXPECT_EQ(report["options"]["loaded_map"], (fs::current_path() / "old.hwmap").string());
  EXPECT_EQ(report["options"]["saved_map"], "");
  EXPECT_EQ(RunJson(SlamRun(), options, "rec", "preset tum1")["calibration"], "preset tum1");
  fs::current_path("/");
  ASSERT_EQ(DatasetsOfRun(run(), report).size(), 1U);
  EXPECT_EQ(DatasetsOfRun(run(), report).front(), Recording("day2"));
}

TEST_F(RunDataset, ItsInputOptionsAreThoseOfTheReport) {
  const DatasetOptions options = InputOptionsOfRun(
      {{"max_pair_difference_s", 0.03}, {"topics", "colour=/a,imu=/b"}, {"frame_rate_hz", -1.0}});
  EXPECT_EQ(options.max_stamp_difference, 0.03);
  EXPECT_EQ(options.frame_rate, DatasetOptions().frame_rate);
  EXPECT_EQ(options.topics, (BagTopics{.colour = "/a", .imu = "/b"}));
  EXPECT_EQ(InputOptionsOfRun({{"topics", "color=/a"}}).topics, BagTopics());
}

TEST_F(RunDataset, AnAbsoluteNameIsThatAlone) {
  const std::vector<fs::path> datasets = DatasetsOfRun(run(), Report(Recording("day1")));
  EXPECT_EQ(datasets, std::vector{Recording("day1")});
  EXPECT_TRUE(DatasetsOfRun(run(), Report(folder_ / "gone")).empty());
  EXPECT_TRUE(DatasetsOfRun(run(), json::object()).empty());
  EXPECT_TRUE(DatasetsOfRun(run(), json{{"dataset", 3}}).empty());
}

TEST_F(RunDataset, ARelativeNameIsThatBesideTheRunOrHereWithTheFramesOfTheRun) {
  const auto found = [&] {
    std::vector<fs::path> datasets;
    for (const fs::path& dataset : DatasetsOfRun(run(), Report("rec"))) {
      datasets.push_back(fs::canonical(dataset));
    }
    return datasets;
  };
  const fs::path first = fs::canonical(Recording("day1")), second = fs::canonical("rec");
  EXPECT_EQ(found(), (std::vector{second, first})) << "either may be meant";
  MakeLater(second);
  EXPECT_EQ(found(), std::vector{first});
  fs::current_path(folder_ / "day1");
  EXPECT_EQ(found(), std::vector{first}) << "once, though it is both";
  MakeLater(first);
  EXPECT_EQ(found(), std::vector<fs::path>());
}

TEST_F(RunDataset, OfAnOlderRunThatMayBeEitherIsAskedFor) {
  WriteText(run() / "run.json", Report("rec").dump());
  WriteText(run() / "keyframes.txt", "100 0 0 0 0 0 0 1\n");
  const auto highwall = [](const std::string& arguments) {
    return testing::RunProgram(testing::kHighwallProgram, arguments, fs::current_path());
  };
  const std::string map = "map ../day1/runs/run --out map --resolution 0.1 --raw";
  testing::ExpectRefused(highwall(map), 2, {"run.json: names the dataset rec", "give --dataset"});
  EXPECT_EQ(highwall(map + " --dataset ../day1/rec").exit_code, 0);
  MakeLater("rec");
  EXPECT_EQ(highwall(map).exit_code, 0);
  MakeLater("../day1/rec");
  testing::ExpectRefused(highwall(map), 2, {"rec: is the dataset of the run", "give --dataset"});
}

TEST_F(RunDataset, CalibrationOfAnOlderRunIsThatOfItsDatasetOrTheOneFileOfThatName) {
  json report = Report("rec");
  report["calibration"] = "rec/calibration.yaml";
  EXPECT_EQ(CalibrationOfRun(run(), report), "");
  report["calibration"] = "preset tum1";
  EXPECT_EQ(CalibrationOfRun(run(), report), "tum1");
  WriteText(folder_ / "day1" / "camera.yaml", kCamera);
  report["calibration"] = "camera.yaml";
  EXPECT_EQ(fs::canonical(CalibrationOfRun(run(), report)),
            fs::canonical(folder_ / "day1" / "camera.yaml"));
}

}  // namespace
}  // namespace highwall::apps::run_dataset_test
