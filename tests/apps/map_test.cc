// Runs highwall map and highwall map compare in the same way as a user.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::map_test {
namespace {

using nlohmann::json;
using testing::Outcome;

std::vector<std::string> LinesOf(const std::string& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// A recorded room and the map built with its exact poses.
class MapCommand : public ::testing::Test {
 protected:
  void SetUp() override { testing::WriteSmallRoom(Dataset(), 20); }

  std::string Path(const std::string& name) const { return folder_.path() / name; }
  std::string Dataset() const { return Path("room"); }
  std::string Out() const { return Path("map"); }
  Outcome Build() const {
    return Map(Dataset() + " --resolution 0.05 --every 2 --json --out " + Out());
  }
  static Outcome Map(const std::string& arguments) {
    return testing::RunProgram(testing::kHighwallProgram, "map " + arguments);
  }
  // Expects the exit code, one line with the reason, and no other output.
  static void ExpectRefused(const std::string& arguments, int code, const std::string& why) {
    SCOPED_TRACE(arguments);
    testing::ExpectRefused(Map(arguments), code, {why});
  }

 private:
  testing::TemporaryDirectory folder_;
};

TEST_F(MapCommand, WritesEveryFormAndItsReport) {
  const Outcome outcome = Build();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report, json::parse(testing::ReadText(Out() + "/map.json")));
  EXPECT_EQ(report["frames"], 10);
  EXPECT_EQ(ReadPly(Out() + "/cloud.ply").size(), report["cloud"]["points"]);
  EXPECT_EQ(ReadPcd(Out() + "/cloud.pcd").size(), report["cloud"]["points"]);
  EXPECT_EQ(OctomapBuilder::Read(Out() + "/map.bt").options().resolution, 0.05);
  EXPECT_EQ(OctomapBuilder::Read(Out() + "/map.ot").LeafCount().occupied,
            report["octree"]["occupied_leaves"]);
  EXPECT_TRUE(testing::ReadText(Out() + "/map_color.ot")
                  .starts_with("# Octomap OcTree file\nid ColorOcTree\n"));
  for (const char* name : {"cloud.png", "cloud_top.png", "octree.png", "octree_top.png"}) {
    const cv::Mat picture = cv::imread(Out() + "/" + name);
    EXPECT_EQ(std::max(picture.cols, picture.rows), 1200) << name;
  }
  EXPECT_EQ(cv::imread(Out() + "/heights.png", cv::IMREAD_UNCHANGED).type(), CV_16UC1);
  for (const char* name : {"grid", "traversability"}) {
    const std::string yaml = testing::ReadText(Out() + "/" + name + ".yaml");
    EXPECT_TRUE(yaml.starts_with("image: " + std::string(name) + ".pgm\n")) << yaml;
    EXPECT_TRUE(std::filesystem::exists(Out() + "/" + name + ".pgm"));
  }
}

// The colours are readable with every kind of colour vision: violet below, yellow above, and red
// for the path only.
TEST_F(MapCommand, TheOctreeIsDrawnInViridis) {
  ASSERT_EQ(Build().exit_code, 0);
  const cv::Mat picture = cv::imread(Out() + "/octree_top.png");
  int lowest = 0, highest = 0, blue = 0;
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const auto& bgr = picture.at<cv::Vec3b>(v, u);
      lowest += bgr == cv::Vec3b(84, 1, 68) ? 1 : 0;
      highest += bgr == cv::Vec3b(37, 231, 253) ? 1 : 0;
      blue += bgr[0] > 150 && bgr[2] < 50 ? 1 : 0;
    }
  }
  EXPECT_GT(lowest, 100);
  EXPECT_GT(highest, 100);
  EXPECT_EQ(blue, 0) << "the rainbow has pure blue below";
}

TEST_F(MapCommand, TheCloudLiesOnTheTrueSurfaceAndCoversTheVisiblePart) {
  ASSERT_EQ(Build().exit_code, 0);
  const Outcome outcome =
      Map("compare " + Out() + "/cloud.ply " + Dataset() +
          "/surface.ply --spacing 0.03 --every 2 --json --seen-by " + Dataset());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json result = json::parse(outcome.out);
  EXPECT_LT(result["accuracy"]["median"], 0.015);
  EXPECT_GT(result["thresholds"][1]["recall"], 0.95);  // within 5 cm
  EXPECT_GT(result["thresholds"][1]["f_score"], 0.95);
  // Not all of the room was observed.
  const Outcome whole =
      Map("compare " + Out() + "/cloud.ply " + Dataset() + "/surface.ply --spacing 0.03 --json");
  EXPECT_LT(json::parse(whole.out)["thresholds"][1]["recall"], 0.9);
}

TEST_F(MapCommand, MeasuresCompletenessWithinTheRangeOnly) {
  ASSERT_EQ(Build().exit_code, 0);
  const auto seen = [&](const std::string& range) {
    const Outcome outcome =
        Map("compare " + Out() + "/cloud.ply " + Dataset() + "/surface.ply --spacing 0.1 --json " +
            "--every 2 --seen-by " + Dataset() + " --max-range " + range);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(outcome.out)["completeness"]["count"].get<int>();
  };
  const int near = seen("3"), far = seen("6");
  EXPECT_GT(near, 0);
  EXPECT_LT(near, far);
  EXPECT_EQ(seen("20"), far) << "the room is smaller than that";
  ExpectRefused("compare a.ply b.ply --max-range 0", 1, "--max-range");
  ExpectRefused("compare a.ply b.ply --trajectory a.txt", 1, "--seen-by");
}

TEST_F(MapCommand, ComparesOctreesAndClouds) {
  ASSERT_EQ(Build().exit_code, 0);
  const Outcome outcome = Map("compare " + Out() + "/map.bt " + Out() + "/cloud.pcd");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("F-score"), std::string::npos);
}

TEST_F(MapCommand, AlignsTrajectoriesBeforeComparing) {
  ASSERT_EQ(Build().exit_code, 0);
  const std::string truth = Dataset() + "/groundtruth.txt";
  const Outcome outcome = Map("compare " + Out() + "/cloud.ply " + Out() + "/cloud.ply --json " +
                              "--align " + truth + " " + truth);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  // Aligned to itself: only rounding errors remain.
  EXPECT_LT(json::parse(outcome.out)["accuracy"]["mean"], 1e-4);
}

TEST_F(MapCommand, MapsARunByItsKeyframes) {
  const std::string run = Path("run");
  std::filesystem::create_directories(run);
  std::ofstream(run + "/run.json") << json{{"dataset", Dataset()}}.dump();
  std::filesystem::copy_file(Dataset() + "/groundtruth.txt", run + "/keyframes.txt");
  const Outcome outcome =
      Map(run + " --resolution 0.2 --every 10 --raw --json --out " + Path("run_map"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["frames"], 2);
  std::ofstream(run + "/run.json") << json{{"dataset", "/nowhere"}}.dump();
  ExpectRefused(run + " --out " + Path("x"), 2, "give --dataset");
  std::ofstream(run + "/run.json") << "{";
  ExpectRefused(run + " --out " + Path("x"), 2, "does not name a dataset");
}

// The colour of frame 4 came with frame 7, which is all red: so is the map of keyframe 4.
TEST_F(MapCommand, TakesTheColourOfALateKeyframeFromItsOwnImage) {
  constexpr std::size_t kHeader = 2;  // [lines]
  const std::vector<std::string> images = LinesOf(Dataset() + "/rgb.txt");
  const std::vector<std::string> poses = LinesOf(Dataset() + "/groundtruth.txt");
  const auto stamp_of = [](const std::string& line) { return line.substr(0, line.find(' ')); };
  const std::string taken = stamp_of(images.at(kHeader + 4)), late = images.at(kHeader + 7);
  cv::imwrite(Dataset() + "/" + late.substr(late.find(' ') + 1),
              cv::Mat(240, 320, CV_8UC3, cv::Scalar(0, 0, 255)));
  const std::string run = Path("run");
  std::filesystem::create_directories(run);
  std::ofstream(run + "/run.json")
      << json{{"dataset", Dataset()},
              {"late_colour", {{"taken", {taken}}, {"stamp", {stamp_of(late)}}}}}
             .dump();
  std::ofstream(run + "/keyframes.txt") << *std::ranges::find(poses, taken, stamp_of) << '\n';
  ASSERT_EQ(Map(run + " --resolution 0.2 --raw --out " + Path("run_map")).exit_code, 0);
  const auto cloud = ReadPly(Path("run_map") + "/cloud.ply");
  ASSERT_FALSE(cloud.empty());
  const std::array<std::uint8_t, 3> red{255, 0, 0};
  EXPECT_TRUE(std::ranges::all_of(cloud, [&](const ColoredPoint& p) { return p.rgb == red; }));
}

// The calibration of this run has a depth offset: its map is built from corrected depth.
TEST_F(MapCommand, MapsARunWithTheCalibrationThatItWasMadeWith) {
  const std::string corrected = Path("corrected.yaml"), run = Path("run");
  std::ofstream(corrected) << testing::ReadText(Dataset() + "/calibration.yaml")
                           << "depth: {inverse_offset: -0.1}\n";
  ASSERT_EQ(testing::RunProgram(testing::kHighwallProgram,
                                "slam --deterministic --no-map --dataset " + Dataset() +
                                    " --config " + corrected + " --out " + run)
                .exit_code,
            0);
  const auto leaves = [&](const std::string& options) {
    const Outcome outcome = Map(run + " --resolution 0.05 --json --out " + Out() + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(outcome.out)["octree"]["occupied_leaves"].get<int>();
  };
  const int by_default = leaves("");
  EXPECT_EQ(by_default, leaves(" --config " + corrected));
  EXPECT_LT(by_default, 0.95 * leaves(" --config " + Dataset() + "/calibration.yaml"));
  std::filesystem::remove(corrected);  // then the calibration of the dataset applies
  EXPECT_GT(leaves(""), by_default);
}

// The world of a run is given by its first camera, whichever of its files the poses are from.
TEST_F(MapCommand, UpIsFoundForATrajectoryOfARunAsForItsKeyframes) {
  const std::string run = Path("run");
  std::filesystem::create_directories(run);
  testing::WriteText(run + "/run.json", "{}");
  Trajectory trajectory = ReadTumTrajectory(Dataset() + "/groundtruth.txt");
  const Pose T_first_W = trajectory.front().pose.Inverse();
  for (StampedPose& frame : trajectory) frame.pose = T_first_W * frame.pose;
  for (const char* file : {"/keyframes.txt", "/trajectory_run1.txt"}) {
    WriteTumTrajectory(run + file, trajectory);
  }
  const std::string options = " --dataset " + Dataset() + " --every 2 --json --out ";
  const Outcome keyframes = Map(run + options + Path("of_keyframes"));
  const Outcome given =
      Map(run + " --trajectory " + run + "/trajectory_run1.txt" + options + Path("of_given"));
  ASSERT_EQ(given.exit_code, 0) << given.err;
  const json grid = json::parse(given.out)["grid"];
  EXPECT_GT(grid["width"], 0);
  EXPECT_EQ(grid, json::parse(keyframes.out)["grid"]);
}

TEST_F(MapCommand, MapsALocalizationByItsTrajectoryAlone) {
  const std::string run = Path("run"), trajectory = run + "/trajectory.txt";
  std::filesystem::create_directories(run);
  const json report{{"dataset", Dataset()}, {"options", {{"localize_only", true}}}};
  testing::WriteText(run + "/run.json", report.dump());
  testing::WriteText(run + "/keyframes.txt", "# none\n");
  std::filesystem::copy_file(Dataset() + "/groundtruth.txt", trajectory);
  ExpectRefused(run + " --out " + Path("x"), 2,
                run + ": is a localization (slam --localize), which makes no keyframes");
  const Outcome outcome = Map(run + " --trajectory " + trajectory +
                              " --resolution 0.2 --raw --json --out " + Path("run_map"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["frames"], 2);
}

TEST_F(MapCommand, RefusesAResolutionThatDoesNotFitBeforeTheWork) {
  ExpectRefused(Dataset() + " --resolution 0.0005 --out " + Path("x"), 2, "--memory-limit");
  EXPECT_FALSE(std::filesystem::exists(Path("x")));
}

TEST_F(MapCommand, RefusesWrongUsage) {
  ExpectRefused(Dataset() + " --resolution 0 --out " + Path("x"), 1, "--resolution");
  ExpectRefused(Dataset() + " --resolution -0.05 --out " + Path("x"), 1, "--resolution");
  ExpectRefused(Dataset() + " --resolution nan --out " + Path("x"), 1, "--resolution");
  ExpectRefused(Dataset(), 1, "--out");
  ExpectRefused("--out " + Path("x"), 1, "source");
  ExpectRefused("compare only_one.ply", 1, "reference");
}

TEST_F(MapCommand, RefusesDataThatMakeNoMap) {
  ExpectRefused("/nowhere --out " + Path("x"), 2, "neither a run nor a dataset");
  ExpectRefused(Dataset() + " --trajectory /nowhere.txt --out " + Path("x"), 2, "/nowhere.txt");
  std::ofstream(Path("nan.txt")) << "1 0 0 nan 0 0 0 1\n";
  ExpectRefused(Dataset() + " --trajectory " + Path("nan.txt") + " --out " + Path("x"), 2,
                "nan.txt:1");
  std::ofstream(Path("late.txt")) << "1e6 0 0 0 0 0 0 1\n";
  ExpectRefused(Dataset() + " --trajectory " + Path("late.txt") + " --out " + Path("x"), 2,
                "no pose");
  // The depth factor is wrong by 1000: all depths are beyond the range.
  const std::string calibration = testing::ReadText(Dataset() + "/calibration.yaml");
  std::string wrong = calibration;
  wrong.replace(wrong.find("depth_factor: 5000"), 18, "depth_factor: 5");
  std::ofstream(Path("wrong.yaml")) << wrong;
  const Outcome outcome =
      Map(Dataset() + " --config " + Path("wrong.yaml") + " --out " + Path("x"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("depth"), std::string::npos) << outcome.err;
}

TEST_F(MapCommand, SaysOfVoxelsThatAreTooLargeThatTheyAre) {
  ExpectRefused(Dataset() + " --resolution 10 --out " + Path("x"), 2, "an octree of 10 m has no");
  EXPECT_FALSE(std::filesystem::exists(Path("x")));
}

TEST_F(MapCommand, RefusesFoldersInPlaceOfMaps) {
  for (const char* name : {"folder.ply", "folder.pcd"}) {
    std::filesystem::create_directory(Path(name));
    ExpectRefused("compare " + Path(name) + " " + Path(name), 2,
                  std::string(name) + ": is a folder");
  }
}

TEST_F(MapCommand, RefusesTruncatedMaps) {
  ASSERT_EQ(Build().exit_code, 0);
  for (const char* name : {"cloud.ply", "cloud.pcd", "map.bt", "map.ot"}) {
    const std::string bytes = testing::ReadText(Out() + "/" + name);
    const std::string cut = Path(std::string("cut_") + name);
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
    ExpectRefused("compare " + cut + " " + Out() + "/cloud.ply", 2, "cut_");
  }
  ExpectRefused("compare nothing.obj " + Out() + "/cloud.ply", 2, ".ply, .pcd, .bt or .ot");
}

}  // namespace
}  // namespace highwall::map_test
