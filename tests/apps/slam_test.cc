// Runs `highwall slam` in the same way as a user: its output, accuracy and response to bad input.
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

#include "support/generated_tum.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::CountLines;
using testing::Outcome;
using testing::ReadText;
using testing::TemporaryDirectory;
using testing::Truncate;
using testing::WriteText;
using testing::WriteTum;

// Returns the names and contents of a folder's files.
std::map<std::string, std::string> Contents(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::directory_iterator(folder)) {
    contents[entry.path().filename().string()] = ReadText(entry.path());
  }
  return contents;
}

class SlamCommand : public ::testing::Test {
 protected:
  fs::path dataset() const { return folder_.path() / "dataset"; }
  fs::path run() const { return folder_.path() / "run"; }

  static Outcome Slam(const std::string& options) {
    return testing::RunProgram(testing::kHighwallProgram, "slam " + options);
  }
  Outcome SlamOnDataset(const std::string& options = "") const {
    return Slam("--dataset " + dataset().string() + " --out " + run().string() + " " + options);
  }

  void WriteSequence(int frames) const { testing::WriteSmallRoom(dataset(), frames); }

  // A dataset of 64 x 48 pixels whose files are valid; its images are blank.
  void WriteBlank(const testing::GeneratedTum& tum = {}) const {
    WriteTum(dataset(), tum);
    WriteText(dataset() / "calibration.yaml",
              "camera: {width: 64, height: 48, fx: 50, fy: 50, cx: 31.5, cy: 23.5}\n"
              "depth_factor: 5000\n");
  }

  // A wall before the camera, with the noise of its depth.
  void WriteBlankWall() const {
    WriteBlank();
    cv::RNG rng(1);
    for (const fs::path& file : Images("depth")) {
      cv::Mat depth(48, 64, CV_16UC1);
      rng.fill(depth, cv::RNG::UNIFORM, 9'900, 10'100);
      ASSERT_TRUE(cv::imwrite(file.string(), depth));
    }
  }

  std::vector<fs::path> Images(const std::string& kind) const {
    std::set<fs::path> files;
    for (const auto& entry : fs::directory_iterator(dataset() / kind)) files.insert(entry.path());
    return {files.begin(), files.end()};
  }

  // Expects one line that contains every part, exit code 2, no other output, and earlier results
  // untouched.
  void ExpectRefused(const std::vector<std::string>& parts, const std::string& options = "") const {
    fs::create_directories(run());
    WriteText(run() / "trajectory.txt", "earlier trajectory");
    WriteText(run() / "run.json", R"({"versions": {"highwall": "0.1.0"}})");
    const auto before = Contents(run());
    const Outcome outcome = SlamOnDataset(options);
    testing::ExpectRefused(outcome, 2, parts);
    EXPECT_TRUE(outcome.err.starts_with("highwall slam: ")) << outcome.err;
    EXPECT_EQ(Contents(run()), before);
    fs::remove_all(run());
    EXPECT_EQ(SlamOnDataset(options).exit_code, 2);
    EXPECT_FALSE(fs::exists(run())) << "a refused run leaves a folder";
  }

  // Expects a run that continues: exit code 0, one line for each skipped frame, all of them
  // counted.
  void ExpectSkipped(const std::vector<std::string>& reasons, std::size_t frames) const {
    const Outcome outcome = SlamOnDataset("--no-map --json");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(CountLines(outcome.err), reasons.size()) << outcome.err;
    for (const std::string& reason : reasons) {
      EXPECT_TRUE(Contains(outcome.err, reason)) << outcome.err;
    }
    const json report = json::parse(outcome.out);
    EXPECT_EQ(report["skipped_frames"], reasons.size());
    EXPECT_EQ(report["frames"], frames - reasons.size());
    EXPECT_DOUBLE_EQ(report["coverage"].get<double>(),
                     static_cast<double>(frames - reasons.size()) / static_cast<double>(frames));
    EXPECT_EQ(ReadTumTrajectory(run() / "trajectory.txt").size(), frames - reasons.size());
  }

 private:
  TemporaryDirectory folder_;
};

void ExpectStage(const json& milliseconds, const std::string& stage) {
  SCOPED_TRACE(stage);
  ASSERT_TRUE(milliseconds.contains(stage));
  const json& figures = milliseconds[stage];
  EXPECT_GT(figures["count"], 0);
  EXPECT_GT(figures["mean"], 0.0);
  EXPECT_GT(figures["median"], 0.0);
  EXPECT_GE(figures["p95"], figures["median"]);
  EXPECT_GE(figures["worst"], figures["p99"]);
}

void ExpectReport(const json& report, std::size_t frames) {
  for (const char* library : {"highwall", "ceres", "opencv", "eigen"}) {
    EXPECT_NE(report["versions"][library], "") << library;
  }
  EXPECT_EQ(report["options"]["points"], true);
  EXPECT_EQ(report["options"]["lines"], true);
  EXPECT_EQ(report["options"]["octree_resolution_m"], 0.1);
  EXPECT_EQ(report["frames"], frames);
  EXPECT_EQ(report["tracked_frames"], frames);
  EXPECT_EQ(report["lost_frames"], 0);
  EXPECT_TRUE(report["lost_stamps"].empty());
  EXPECT_EQ(report["skipped_frames"], 0);
  EXPECT_EQ(report["coverage"], 1.0);
  EXPECT_EQ(report["complete"], true);
  EXPECT_GE(report["keyframes"], 1);
  EXPECT_GT(report["landmarks"]["points"], 100);
  EXPECT_GT(report["landmarks"]["lines"], 10);
  for (const char* stage :
       {"points", "lines", "features", "pose", "tracking", "mapping", "frame", "dense"}) {
    ExpectStage(report["milliseconds"], stage);
  }
  EXPECT_GT(report["peak_memory_mib"], 1.0);
  const json& memory = report["memory_at_rest_mib"];
  double held = 0.0;
  for (const auto& [holder, mib] : memory["held"].items()) held += mib.get<double>();
  EXPECT_GT(held, 1.0);
  EXPECT_LT(held, memory["all"]);
}

// Reads grid.yaml as map_server does, and the size of the image that it names.
void ExpectGrid(const fs::path& run, const json& grid) {
  std::map<std::string, std::string> fields;
  std::istringstream yaml(ReadText(run / "grid.yaml"));
  for (std::string key, value; std::getline(yaml, key, ':') && std::getline(yaml, value);) {
    fields[key] = value.substr(value.find_first_not_of(' '));
  }
  EXPECT_EQ(fields["image"], "grid.pgm");
  EXPECT_EQ(std::stod(fields["resolution"]), 0.1);
  EXPECT_TRUE(fields["origin"].starts_with('['));
  std::istringstream pgm(ReadText(run / "grid.pgm"));
  std::string magic;
  int width = 0, height = 0, white = 0;
  pgm >> magic >> width >> height >> white;
  EXPECT_EQ(magic, "P5");
  EXPECT_EQ(white, 255);
  EXPECT_EQ(width, grid["width"]);
  EXPECT_EQ(height, grid["height"]);
  EXPECT_EQ(
      static_cast<std::uintmax_t>(width * height) + static_cast<std::uintmax_t>(pgm.tellg()) + 1,
      fs::file_size(run / "grid.pgm"));
}

// Factors on the prior noise model, of each kind, to a thousandth.
void ExpectNoise(const json& noise) {
  EXPECT_EQ(noise["point_px_by_level"].size(), 8U);
  EXPECT_EQ(noise["low_contrast_px_by_level"].size(), 8U);
  EXPECT_EQ(noise["refined_px_by_level"].size(), 8U);
  for (const char* bands : {"point_depth_by_depth", "edge_depth_by_depth", "line_px_by_length",
                            "line_depth_by_depth"}) {
    EXPECT_EQ(noise[bands].size(), 4U) << bands;
  }
  for (const auto& [kind, factors] : noise.items()) {
    for (const double factor : factors) {
      EXPECT_GT(factor, 0.1) << kind;
      EXPECT_LT(factor, 3.0) << kind;
    }
  }
  // Coarse corners are less than 1.2 times as noisy per level; without learning it would be 1.003.
  EXPECT_LT(noise["point_px_by_level"][7], 0.95);
}

TEST_F(SlamCommand, WritesEveryResultAndIsAccurate) {
  constexpr std::size_t kFrames = 40;
  WriteSequence(kFrames);
  const Outcome outcome = SlamOnDataset("--resolution 0.1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  // The suggested command can be run without changes.
  EXPECT_TRUE(Contains(outcome.out, "highwall eval ape " +
                                        (dataset() / "groundtruth.txt").string() + " " +
                                        (run() / "trajectory.txt").string()))
      << outcome.out;

  const Trajectory trajectory = ReadTumTrajectory(run() / "trajectory.txt");
  const Trajectory truth = ReadTumTrajectory(dataset() / "groundtruth.txt");
  ASSERT_EQ(trajectory.size(), kFrames);
  EXPECT_LT(AbsolutePoseError(truth, trajectory).statistics.rmse, 0.02);
  const json report = json::parse(ReadText(run() / "run.json"));
  ExpectReport(report, kFrames);
  const auto memory = std::lround(report["peak_memory_mib"].get<double>());
  EXPECT_TRUE(Contains(outcome.out, "memory      " + std::to_string(memory) + " MiB at its peak"))
      << memory << " in run.json, in the terminal:\n"
      << outcome.out;
  EXPECT_EQ(ReadTumTrajectory(run() / "keyframes.txt").size(), report["keyframes"]);
  ExpectNoise(report["noise"]);

  const json& map = report["map"];
  EXPECT_EQ(ReadPly(run() / "cloud.ply").size(), map["cloud"]["points"]);
  EXPECT_GT(map["cloud"]["points"], 1000);
  const cv::Mat sparse = cv::imread((run() / "sparse_map.png").string());
  EXPECT_EQ(std::max(sparse.cols, sparse.rows), 1200);
  cv::Mat way;
  cv::inRange(sparse, cv::Scalar(10, 80, 196), cv::Scalar(10, 80, 196), way);
  EXPECT_GT(cv::countNonZero(way), 20) << "orange";
  const OctomapBuilder octree = OctomapBuilder::Read(run() / "map.bt");
  EXPECT_EQ(octree.options().resolution, 0.1);
  EXPECT_GT(octree.LeafCount().occupied, 100U);
  EXPECT_GT(map["octree"]["occupied_leaves"], 100);
  EXPECT_GT(map["octree"]["free_leaves"], 100);
  ExpectGrid(run(), map["grid"]);
}

TEST_F(SlamCommand, DeterministicRunsAreEqualToTheByte) {
  WriteSequence(20);
  const std::string results[] = {"trajectory.txt", "keyframes.txt", "cloud.ply", "map.bt",
                                 "grid.pgm"};
  ASSERT_EQ(SlamOnDataset("--deterministic").exit_code, 0);
  std::map<std::string, std::string> first = Contents(run());
  ASSERT_EQ(SlamOnDataset("--deterministic").exit_code, 0);
  std::map<std::string, std::string> second = Contents(run());
  for (const std::string& result : results) {
    EXPECT_FALSE(first[result].empty()) << result;
    EXPECT_TRUE(first[result] == second[result]) << result;
  }
}

TEST_F(SlamCommand, LiveItKeepsThePaceOfTheStampsAndCountsWhatItDrops) {
  constexpr std::size_t kFrames = 20;
  WriteSequence(kFrames);
  const Outcome outcome = SlamOnDataset("--live --no-map --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["frames"].get<std::size_t>() + report["dropped_frames"].get<std::size_t>(),
            kFrames);
  EXPECT_EQ(report["skipped_frames"], 0);
  EXPECT_EQ(report["milliseconds"]["delay"]["count"], report["frames"]);
  EXPECT_GT(report["milliseconds"]["delay"]["median"].get<double>(), 0.0);
  EXPECT_LE(report["postponed"]["loop_searches"], report["keyframes_made"]);
  const Trajectory truth = ReadTumTrajectory(dataset() / "groundtruth.txt");
  EXPECT_GE(report["seconds"].get<double>(), ToSeconds(truth.back().stamp - truth.front().stamp));
  EXPECT_EQ(SlamOnDataset("--live --deterministic").exit_code, 1);
}

TEST_F(SlamCommand, ALaterRunContinuesASavedMap) {
  WriteSequence(30);
  const fs::path map = dataset().parent_path() / "room.hwmap";
  ASSERT_EQ(SlamOnDataset("--no-map --save-map " + map.string()).exit_code, 0);
  const Trajectory first = ReadTumTrajectory(run() / "trajectory.txt");
  const Outcome outcome = SlamOnDataset("--no-map --json --load-map " + map.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["relocalizations"], 1);
  EXPECT_EQ(report["lost_frames"], 0);
  EXPECT_EQ(report["options"]["loaded_map"], map.string());
  const Trajectory second = ReadTumTrajectory(run() / "trajectory.txt");
  ASSERT_EQ(second.size(), first.size());
  // Both are in the same world, to the accuracy of either run.
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_LT((second[i].pose.p() - first[i].pose.p()).norm(), 0.01) << i;
  }

  const std::string bytes = ReadText(map);
  WriteText(map, bytes.substr(0, bytes.size() / 2));
  ExpectRefused({"room.hwmap: is cut short"}, "--load-map " + map.string());
  ExpectRefused({"none.hwmap: cannot be read"}, "--load-map none.hwmap");
  WriteText(map, bytes);
  ExpectRefused({"room.hwmap: is a map of points by orb, this run finds them by sift"},
                "--point-detector sift --load-map " + map.string());
  ExpectRefused({"room.hwmap: is a map of points by orb in 8 levels of 1.2, this run finds them by "
                 "orb in 5 levels of 1.2: choose another frame.orb.pyramid"},
                "--set frame.orb.pyramid.levels=5 --load-map " + map.string());
  WriteText(dataset() / "other.yaml",
            "camera: {width: 320, height: 240, fx: 265, fy: 265, cx: 160, cy: 120}\n"
            "depth_factor: 5000\n");
  ExpectRefused({"room.hwmap: is a map of another camera"},
                "--load-map " + map.string() + " --config " + (dataset() / "other.yaml").string());
}

TEST_F(SlamCommand, LocalizesInASavedMapThatStaysAsItIs) {
  WriteSequence(30);
  const fs::path map = dataset().parent_path() / "room.hwmap";
  ASSERT_EQ(SlamOnDataset("--no-map --save-map " + map.string()).exit_code, 0);
  const Trajectory first = ReadTumTrajectory(run() / "trajectory.txt");
  const std::string bytes = ReadText(map);
  const Outcome outcome = SlamOnDataset("--json --localize --load-map " + map.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["lost_frames"], 0);
  EXPECT_EQ(report["keyframes"], 0);
  EXPECT_EQ(report["options"]["localize_only"], true);
  EXPECT_EQ(report["options"]["loops"], false);
  EXPECT_FALSE(fs::exists(run() / "cloud.ply"));
  EXPECT_TRUE(ReadText(map) == bytes);
  const std::string make_map = "map " + run().string() + " --out " + (run() / "map").string();
  testing::ExpectRefused(testing::RunProgram(testing::kHighwallProgram, make_map), 2,
                         {"is a localization", "give --trajectory"});
  const Trajectory second = ReadTumTrajectory(run() / "trajectory.txt");
  ASSERT_EQ(second.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_LT((second[i].pose.p() - first[i].pose.p()).norm(), 0.01) << i;
  }
  EXPECT_EQ(SlamOnDataset("--localize --imu off --load-map " + map.string()).exit_code, 0);
  EXPECT_EQ(SlamOnDataset("--localize").exit_code, 1);
  for (const std::string with : {"--save-map x.hwmap", "--adjust-all", "--imu paper"}) {
    EXPECT_EQ(SlamOnDataset("--localize --load-map " + map.string() + " " + with).exit_code, 1)
        << with;
  }
}

TEST_F(SlamCommand, WritesTheCausalAndTheAdjustedTrajectoryBesideTheFirst) {
  WriteSequence(20);
  ASSERT_EQ(SlamOnDataset("--no-map --adjust-all").exit_code, 0);
  const Trajectory truth = ReadTumTrajectory(dataset() / "groundtruth.txt");
  for (const char* name : {"trajectory.txt", "trajectory_causal.txt", "trajectory_adjusted.txt"}) {
    const Trajectory trajectory = ReadTumTrajectory(run() / name);
    EXPECT_EQ(trajectory.size(), 20U) << name;
    EXPECT_LT(AbsolutePoseError(truth, trajectory).statistics.rmse, 0.02) << name;
  }
  ASSERT_EQ(SlamOnDataset("--no-map").exit_code, 0);
  EXPECT_FALSE(fs::exists(run() / "trajectory_adjusted.txt")) << "of the earlier run";
}

TEST_F(SlamCommand, JsonIsOneObjectAndTheSameAsTheFile) {
  WriteSequence(5);
  const Outcome outcome = SlamOnDataset("--json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out), json::parse(ReadText(run() / "run.json")));
}

// The camera rotates by several bricks of a wall from frame to frame: without a prediction, many
// lines match one brick further along.
TEST_F(SlamCommand, AWallThatRepeatsItselfMovesNoCamera) {
  // The slower the sequence, the larger the error of the first prediction.
  for (const char* sequence : {"--duration 0.3 --fps 10", "--duration 0.5 --fps 8"}) {
    fs::remove_all(dataset());
    ASSERT_EQ(
        testing::RunProgram(testing::kHighwallProgram, "simulate room " + std::string(sequence) +
                                                           " --out " + dataset().string())
            .exit_code,
        0);
    for (const char* weighting : {"covariance", "paper"}) {
      ASSERT_EQ(
          SlamOnDataset("--no-map --deterministic --weighting " + std::string(weighting)).exit_code,
          0);
      const Outcome error = testing::RunProgram(
          testing::kHighwallProgram, "eval rpe --json " + (dataset() / "groundtruth.txt").string() +
                                         " " + (run() / "trajectory.txt").string());
      ASSERT_EQ(error.exit_code, 0) << error.err;
      // One brick further along is 0.25 m; the right pose is accurate to some millimetres.
      EXPECT_LT(json::parse(error.out)["stats"]["max"], 0.01) << sequence << ", " << weighting;
    }
  }
}

TEST_F(SlamCommand, AMapOfAnEarlierRunDoesNotStayBesideANewTrajectory) {
  WriteSequence(6);
  ASSERT_EQ(SlamOnDataset().exit_code, 0);
  ASSERT_TRUE(fs::exists(run() / "map.bt"));
  ASSERT_EQ(SlamOnDataset("--no-map").exit_code, 0);
  for (const char* name : {"cloud.ply", "map.bt", "grid.pgm", "grid.yaml"}) {
    EXPECT_FALSE(fs::exists(run() / name)) << name;
  }
}

TEST_F(SlamCommand, RefusesAMissingFolder) {
  ExpectRefused({dataset().string() + ": does not exist"});
  ExpectRefused({dataset().string() + ": does not exist"}, "--config tum1");
}

TEST_F(SlamCommand, RefusesAnEmptyFolder) {
  fs::create_directories(dataset());
  ExpectRefused({dataset().string() + ": is empty"});
  ExpectRefused({dataset().string() + ": is empty"}, "--config tum1");
}

TEST_F(SlamCommand, RefusesADatasetWithoutAList) {
  WriteBlank();
  fs::remove(dataset() / "depth.txt");
  ExpectRefused({"depth.txt: is missing"});
  fs::remove(dataset() / "rgb.txt");
  fs::remove_all(dataset() / "depth");
  ExpectRefused({dataset().string(), "holds no recording in a known format: EuRoC has mav0/",
                 "TUM RGB-D has rgb.txt and depth.txt"});
}

TEST_F(SlamCommand, RefusesMalformedLines) {
  WriteBlank();
  WriteText(dataset() / "rgb.txt", "# colour\n100.0 rgb/100.png\nsoon rgb/101.png\n");
  ExpectRefused({"rgb.txt:3: 'soon' is not a time stamp"});
  WriteText(dataset() / "rgb.txt", "100.0 rgb/100.png\n100.1\n");
  ExpectRefused({"rgb.txt:2: a file name is missing"});
}

TEST_F(SlamCommand, RefusesStampsThatNeverAssociate) {
  WriteBlank();
  WriteText(dataset() / "depth.txt", "200.0 depth/100.png\n200.1 depth/101.png\n");
  ExpectRefused({dataset().string(), "no stamp of rgb.txt has one of depth.txt within 0.02 s"});
}

TEST_F(SlamCommand, RefusesDepthThatIsAllZero) {
  WriteBlank({.raw_depth = 0});
  ExpectRefused({"none of its 6 frames can be used", "100.png: holds no depth: all zero"});
}

TEST_F(SlamCommand, RefusesAnUnknownYamlKey) {
  WriteBlank();
  const fs::path config = dataset() / "calibration.yaml";
  WriteText(config, ReadText(config) + "depth_nose: {offset: 0.001}\n");
  ExpectRefused({"calibration.yaml:3: unknown key 'depth_nose'", "'depth_noise'"});
  ExpectRefused({"calibration.yaml:3: unknown key 'depth_nose'"}, "--config " + config.string());
}

TEST_F(SlamCommand, RefusesAConfigurationThatIsNotThere) {
  WriteBlank();
  ExpectRefused({"none.yaml: is neither a file nor a preset (tum1, tum2, tum3)"},
                "--config none.yaml");
  fs::remove(dataset() / "calibration.yaml");
  ExpectRefused({"the camera is unknown"});
}

TEST_F(SlamCommand, RefusesImagesWithoutAnyTexture) {
  WriteBlankWall();
  ExpectRefused({dataset().string() + ": no frame could be tracked"});
}

TEST_F(SlamCommand, ARunThatTracksNothingKeepsTheMapOfAnEarlierOne) {
  WriteBlankWall();
  const fs::path map = dataset().parent_path() / "room.hwmap";
  WriteText(map, "precious");
  ExpectRefused({"no frame could be tracked"}, "--save-map " + map.string());
  EXPECT_EQ(ReadText(map), "precious");
}

TEST_F(SlamCommand, RefusesAFolderInPlaceOfAMapBeforeTheWork) {
  const std::string folder = dataset().parent_path().string();
  const Outcome outcome =
      Slam("--dataset /nowhere --out " + run().string() + " --save-map " + folder);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, folder + ": is not a file")) << outcome.err;
}

TEST_F(SlamCommand, RefusesAnOctreeThatWouldNotFitInMemory) {
  WriteSequence(2);
  const Outcome outcome = SlamOnDataset("--resolution 0.001");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "choose a coarser --resolution")) << outcome.err;
  EXPECT_FALSE(fs::exists(run() / "trajectory.txt"));
}

TEST_F(SlamCommand, RefusesAFileInPlaceOfTheResultsFolder) {
  WriteBlank();
  WriteText(run(), "precious");
  const Outcome outcome = SlamOnDataset();
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, run().string() + ": is a file")) << outcome.err;
  EXPECT_EQ(ReadText(run()), "precious");
}

TEST_F(SlamCommand, RefusesAFolderThatCannotBeMadeBeforeTheWork) {
  // If the dataset were read first, the error would refer to it.
  const fs::path file = dataset().parent_path() / "file";
  WriteText(file, "precious");
  const Outcome outcome = Slam("--dataset /nowhere --out " + (file / "a" / "b").string());
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "/a/b: cannot be made: ")) << outcome.err;
  EXPECT_EQ(ReadText(file), "precious");
}

TEST_F(SlamCommand, RefusesAFolderInPlaceOfAConfiguration) {
  WriteBlank();
  const Outcome outcome = SlamOnDataset("--config " + dataset().string());
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "is a folder")) << outcome.err;
}

TEST_F(SlamCommand, QuotesNoControlCharactersOfAFile) {
  WriteBlank();
  WriteText(dataset() / "rgb.txt", "\033[31mred\r rgb/a.png\n");
  const Outcome outcome = SlamOnDataset();
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "'?[31mred' is not a time stamp")) << outcome.err;
}

TEST_F(SlamCommand, SkipsUnreadableImagesAndContinues) {
  WriteSequence(8);
  WriteText(Images("rgb")[3], "no picture");
  fs::remove(Images("depth")[5]);
  ExpectSkipped({Images("rgb")[3].string() + ": is not an image", ": cannot be read"}, 8);
}

TEST_F(SlamCommand, SkipsTruncatedImagesAndContinues) {
  WriteSequence(8);
  Truncate(Images("rgb")[2]);
  Truncate(Images("depth")[6]);
  ExpectSkipped({Images("rgb")[2].string() + ": is truncated",
                 Images("depth")[6].string() + ": is truncated"},
                8);
}

TEST_F(SlamCommand, SkipsDepthOfAnotherSizeAndContinues) {
  WriteSequence(8);
  cv::imwrite(Images("depth")[4].string(), cv::Mat(48, 64, CV_16UC1, cv::Scalar(5000)));
  ExpectSkipped({Images("depth")[4].string() + ": is 64 x 48, but its colour image is 320 x 240"},
                8);
}

TEST_F(SlamCommand, SkipsAFrameWithoutDepthAndContinues) {
  WriteSequence(8);
  cv::imwrite(Images("depth")[4].string(), cv::Mat::zeros(240, 320, CV_16UC1));
  ExpectSkipped({Images("depth")[4].string() + ": holds no depth: all zero"}, 8);
}

TEST_F(SlamCommand, WarnsOfADepthFactorThatIsUnlikely) {
  WriteSequence(5);
  std::string calibration = ReadText(dataset() / "calibration.yaml");
  const std::size_t at = calibration.find("depth_factor: 5000");
  ASSERT_NE(at, std::string::npos);
  calibration.replace(at, 18, "depth_factor: 100 #");
  WriteText(dataset() / "calibration.yaml", calibration);
  const Outcome outcome = SlamOnDataset();
  EXPECT_TRUE(outcome.err.starts_with("highwall slam: warning: " + dataset().string() +
                                      ": the median depth is "))
      << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "with depth factor 100; the factor is likely 5000"))
      << outcome.err;
  // All depths are beyond the range of the sensor: no map, no results.
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_FALSE(fs::exists(run()));
}

TEST_F(SlamCommand, WrongUsageExitsWithOneAndHelpHasAnExample) {
  for (const std::string& options :
       {std::string(), std::string("--dataset x"),
        std::string("--dataset x --out y --resolution -1"),
        std::string("--dataset x --out y --resolution nan"), std::string("--dataset x --out ''"),
        std::string("--dataset x --out y --features planes"),
        std::string("--dataset x --out y --colour")}) {
    const Outcome outcome = Slam(options);
    EXPECT_EQ(outcome.exit_code, 1) << options;
    EXPECT_EQ(CountLines(outcome.err), 1U) << outcome.err;
  }
  const Outcome help = Slam("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_TRUE(Contains(help.out, "Example:"));
}

}  // namespace
}  // namespace highwall::slam_test
