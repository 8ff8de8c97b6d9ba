// Each switch of `highwall slam` changes the run as documented, and nothing else.
#include "run/slam_arguments.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "run/run_report.h"
#include "support/temporary_directory.h"

namespace highwall::apps::slam_arguments_test {
namespace {

using nlohmann::json;

SlamArguments Parse(const std::string& switches) {
  SlamArguments arguments;
  CLI::App app;
  AddSlamOptions(&app, &arguments);
  app.parse("--dataset d --out o " + switches);
  CheckArguments(arguments);
  return arguments;
}

SlamRunOptions Options(const std::string& switches) {
  return MakeOptions(Parse(switches));
}

// Returns the options of run.json that differ from those of a run without switches.
json Difference(const std::string& switches) {
  const json before = ToJson(Options("")).flatten(), after = ToJson(Options(switches)).flatten();
  json difference = json::object();
  for (const auto& [key, value] : after.items()) {
    if (before.at(key) != value) difference[key.substr(1)] = value;
  }
  return difference;
}

// Writes the settings to a file and returns its path.
std::string SettingsFileOf(const std::string& settings) {
  const std::string path = ::testing::TempDir() + "highwall_settings.yaml";
  testing::WriteText(path, settings + "\n");
  return path;
}

struct Case {
  std::string switches;
  json reported;  // options of run.json that change
  std::function<bool(const SlamRunOptions&)> holds;
};

std::vector<Case> Cases() {
  const std::string map = (std::filesystem::current_path() / "a").string();
  using O = const SlamRunOptions&;
  return {
      {"--features points",
       {{"lines", false}},
       [](O o) { return o.slam.frame.use_points && !o.slam.frame.use_lines; }},
      {"--features lines",
       {{"points", false}},
       [](O o) { return !o.slam.frame.use_points && o.slam.frame.use_lines; }},
      {"--features both", json::object(),
       [](O o) { return o.slam.frame.use_points && o.slam.frame.use_lines; }},
      {"--point-detector sift",
       {{"point_detector", "sift"}},
       [](O o) { return o.slam.frame.point_detector == PointDetector::kSift; }},
      {"--point-detector orb", json::object(),
       [](O o) { return o.slam.frame.point_detector == PointDetector::kOrb; }},
      {"--line-detector lsd",
       {{"line_detector", "lsd"}},
       [](O o) { return o.slam.frame.lines.detector == LineDetector::kLsd; }},
      {"--line-detector edlines", json::object(),
       [](O o) { return o.slam.frame.lines.detector == LineDetector::kEdLines; }},
      {"--line-outliers paper",
       {{"line_outliers", "paper"}},
       [](O o) { return o.slam.measurement.mad_rule == MadRule::kPaper; }},
      {"--line-outliers median", json::object(),
       [](O o) { return o.slam.measurement.mad_rule == MadRule::kMedian; }},
      {"--weighting paper",
       {{"weighting", "paper"}},
       [](O o) { return o.slam.measurement.weighting == Weighting::kPaper; }},
      {"--resolution 0.2",
       {{"octree_resolution_m", 0.2}},
       [](O o) { return o.map.octree.resolution == 0.2; }},
      {"--moving-objects off",
       {{"moving_objects", false}},
       [](O o) { return !o.slam.tracker.moving.enabled; }},
      {"--frame-timing known",
       {{"frame_timing", "known"}},
       [](O o) { return o.slam.tracker.timing == FrameTimingMode::kKnown; }},
      {"--frame-timing ignored",
       {{"frame_timing", "ignored"}},
       [](O o) { return o.slam.tracker.timing == FrameTimingMode::kIgnored; }},
      {"--imu paper",
       json::object(),  // "imu" is "off" without readings
       [](O o) { return o.slam.inertial.weighting.policy == ImuWeighting::kPaper; }},
      {"--set inertial.coupling=loose", json::object(),
       [](O o) { return o.slam.inertial.coupling == InertialCoupling::kLoose; }},
      {"--imu fixed:3", json::object(),
       [](O o) {
         return o.slam.inertial.weighting.policy == ImuWeighting::kFixed &&
                o.slam.inertial.weighting.fixed_weight == 3.0;
       }},
      {"--deterministic",
       {{"mapping_in_background", false},
        {"loops_in_background", false},
        {"parallel_features", false},
        {"solver_threads", 1}},
       [](O o) { return o.prefetch == 0 && !o.map.background && o.slam.threads == 0; }},
      {"--live", {{"live", true}}, [](O o) { return o.live; }},
      {"--no-map", {{"dense_map", false}}, [](O o) { return !o.dense; }},
      {"--no-loops", {{"loops", false}}, [](O o) { return !o.slam.loops.enabled; }},
      {"--adjust-all", {{"adjust_all", true}}, [](O o) { return o.adjust_all; }},
      {"--load-map a", {{"loaded_map", map}}, [](O o) { return o.load_map == "a"; }},
      {"--save-map a", {{"saved_map", map}}, [](O o) { return o.save_map == "a"; }},
      {"--load-map a --localize",
       {{"loaded_map", map}, {"localize_only", true}, {"loops", false}, {"dense_map", false}},
       [](O o) { return o.slam.localize_only && !o.slam.loops.enabled && !o.dense; }},
      {"--trace a", json::object(), [](O o) { return o.trace == "a"; }},
      {"--json", json::object(), [](O) { return true; }},
      {"--covariances", json::object(), [](O) { return true; }},
      {"--memory-report", json::object(), [](O) { return true; }},
      {"--report", json::object(), [](O) { return true; }},
      {"--view", json::object(), [](O o) { return o.observer == nullptr; }},
      {"--view=0 --view-address 0.0.0.0", json::object(), [](O) { return true; }},
      {"--overwrite", json::object(), [](O) { return true; }},
      {"--strict", json::object(), [](O) { return true; }},
      {"--max-pair-difference 0.03", json::object(), [](O) { return true; }},
      {"--fps 15", json::object(), [](O) { return true; }},
      {"--topics imu=/a", json::object(), [](O) { return true; }},
      {"--set tracker.min_support=31 --set mapper.wait=false", json::object(),
       [](O o) { return o.slam.tracker.min_support == 31 && !o.slam.mapper.wait; }},
      {"--set frame.orb.features=500",
       {{"orb_features", 500}},
       [](O o) { return o.slam.frame.orb.features == 500; }},
      {"--settings " + SettingsFileOf("tracker: {min_support: 31}"), json::object(),
       [](O o) { return o.slam.tracker.min_support == 31; }},
      {"--print-settings", json::object(), [](O) { return true; }},
      {"--gps off", json::object(), [](O) { return true; }},
      {"--config tum1", json::object(), [](O) { return true; }},
  };
}

TEST(SlamArguments, EachSwitchChangesTheRunAndNothingElse) {
  for (const Case& c : Cases()) {
    SCOPED_TRACE(c.switches);
    EXPECT_TRUE(c.holds(Options(c.switches)));
    EXPECT_EQ(Difference(c.switches), c.reported);
  }
}

TEST(SlamArguments, EachSwitchOfTheCommandHasItsCase) {
  SlamArguments arguments;
  CLI::App app;
  AddSlamOptions(&app, &arguments);
  const std::vector<Case> cases = Cases();
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name();
    if (name == "--help" || name == "--dataset" || name == "--out") continue;
    const bool tested = std::ranges::any_of(
        cases, [&](const Case& c) { return c.switches.find(name) != std::string::npos; });
    EXPECT_TRUE(tested) << name;
  }
}

TEST(SlamArguments, OtherOptionsThanThoseOfTheRunReachTheArguments) {
  EXPECT_EQ(Parse("").dataset, "d");
  EXPECT_EQ(Parse("").out, "o");
  EXPECT_EQ(Parse("--config tum1").config, "tum1");
  EXPECT_EQ(Parse("--fps 15").frame_rate, 15.0);
  EXPECT_EQ(Parse("").frame_rate, 30.0);
  EXPECT_EQ(Parse("--topics colour=/a,imu=/b").topics, (BagTopics{.colour = "/a", .imu = "/b"}));
  EXPECT_EQ(Parse("").topics, BagTopics());
  EXPECT_TRUE(Parse("--json").json);
  EXPECT_TRUE(Parse("--overwrite").overwrite);
  EXPECT_FALSE(Parse("").overwrite);
  EXPECT_FALSE(Parse("").json);
  EXPECT_EQ(Parse("").view, "");
  EXPECT_EQ(Parse("--view").view, "8080");
  EXPECT_EQ(Parse("--view=9000").view, "9000");
  EXPECT_EQ(Parse("--view=0").view, "0");
  EXPECT_EQ(Parse("--view").view_address, "127.0.0.1");
  EXPECT_EQ(Parse("--view --view-address ::1").view_address, "::1");
  EXPECT_TRUE(Parse("").gps);
  EXPECT_FALSE(Parse("--gps off").gps);
}

TEST(SlamArguments, SwitchesGoBeforeTheFileOfSettingsAndSetBeforeBoth) {
  const std::string file =
      " --settings " + SettingsFileOf(
                           "frame: {use_lines: false, lines: {detector: lsd}}\n"
                           "inertial: {weighting: {policy: paper}}");
  EXPECT_FALSE(Options(file).slam.frame.use_lines);
  EXPECT_EQ(Options(file).slam.frame.lines.detector, LineDetector::kLsd);
  EXPECT_EQ(Options(file).slam.inertial.weighting.policy, ImuWeighting::kPaper);
  EXPECT_TRUE(Options("--features both" + file).slam.frame.use_lines);
  EXPECT_EQ(Options("--line-detector edlines" + file).slam.frame.lines.detector,
            LineDetector::kEdLines);
  EXPECT_EQ(Options("--imu fixed:2" + file).slam.inertial.weighting.policy, ImuWeighting::kFixed);
  EXPECT_EQ(Options("--set inertial.weighting.policy=consistent --imu paper" + file)
                .slam.inertial.weighting.policy,
            ImuWeighting::kConsistent);
  EXPECT_FALSE(Options("--set frame.use_lines=false --features both").slam.frame.use_lines);
  EXPECT_EQ(0, Options("--deterministic --set threads=4").slam.threads);
}

TEST(SlamArguments, PrintingTheSettingsNeedsNoDataset) {
  SlamArguments arguments;
  CLI::App app;
  AddSlamOptions(&app, &arguments);
  app.parse("--print-settings");
  EXPECT_TRUE(arguments.print_settings);
  CLI::App other;
  AddSlamOptions(&other, &arguments);
  EXPECT_THROW(other.parse("--json"), CLI::RequiredError);
}

TEST(SlamArguments, TheDefaultWeightOfTheImuAndTheCouplingHaveNoSwitch) {
  EXPECT_EQ(Options("").slam.inertial.weighting.policy, ImuWeighting::kConsistent);
  EXPECT_EQ(Options("").slam.inertial.coupling, InertialCoupling::kTight);
  EXPECT_EQ(Options("--imu paper").slam.inertial.coupling, InertialCoupling::kTight);
  EXPECT_THROW(Parse("--imu consistent"), CLI::ValidationError);
  EXPECT_THROW(Parse("--inertial loose"), CLI::ParseError);
  const std::string file =
      SettingsFileOf("inertial: {coupling: loose, weighting: {policy: consistent}}");
  EXPECT_EQ(Options("--settings " + file).slam.inertial.coupling, InertialCoupling::kLoose);
  EXPECT_EQ(Options("--settings " + file).slam.inertial.weighting.policy,
            ImuWeighting::kConsistent);
}

TEST(SlamArguments, TheViewNeedsAPortAndItsAddressTheView) {
  for (const char* switches : {"--view=70000", "--view=-1", "--view=x", "--view=0.5",
                               "--view-address 0.0.0.0", "--view --view-address ''"}) {
    EXPECT_THROW(Parse(switches), CLI::ParseError) << switches;
  }
}

TEST(SlamArguments, ASettingThatCannotBeIsWrongUsage) {
  for (const char* switches :
       {"--set tracker.min_suport=7", "--set tracker.min_support=3", "--set tracker.min_support",
        "--set frame.use_points=false --features points", "--set localize_only=true"}) {
    EXPECT_THROW(Parse(switches), CLI::ValidationError) << switches;
  }
}

TEST(SlamArguments, TheReadingsOfTheImuAreWantedUnlessTheyAreOffOrTheMapStaysAsItIs) {
  EXPECT_TRUE(WantsImu(Parse("")));
  EXPECT_TRUE(WantsImu(Parse("--imu fixed:1")));
  EXPECT_FALSE(WantsImu(Parse("--imu off")));
  EXPECT_FALSE(WantsImu(Parse("--load-map a --localize")));
  EXPECT_THROW(Parse("--load-map a --localize --imu paper"), CLI::ValidationError);
}

}  // namespace
}  // namespace highwall::apps::slam_arguments_test
