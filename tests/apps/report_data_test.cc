// Tests the data in the report of a run.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/mapping/octomap_builder.h>

#include "report/base64.h"
#include "report/html_report.h"
#include "report/report_graph.h"
#include "report/report_motion.h"
#include "report/report_scene.h"
#include "report/report_words.h"

namespace highwall::apps::report_data_test {
namespace {

using nlohmann::json;

std::string Encoded(const std::string& text) {
  return Base64Of(std::span<const char>(text.data(), text.size()));
}

// RFC 4648, section 10.
TEST(Base64, EncodesTheExamplesOfItsStandard) {
  EXPECT_EQ(Encoded(""), "");
  EXPECT_EQ(Encoded("f"), "Zg==");
  EXPECT_EQ(Encoded("fo"), "Zm8=");
  EXPECT_EQ(Encoded("foo"), "Zm9v");
  EXPECT_EQ(Encoded("foob"), "Zm9vYg==");
  EXPECT_EQ(Encoded("\xff\xfe\xfd"), "//79");
}

std::vector<unsigned char> Decoded(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    group = (group << 6) | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) bytes.push_back(static_cast<unsigned char>(group >> (bits -= 8)));
  }
  return bytes;
}

std::vector<std::uint16_t> Words(const json& base64) {
  const std::vector<unsigned char> bytes = Decoded(base64.get<std::string>());
  std::vector<std::uint16_t> words(bytes.size() / 2);
  std::memcpy(words.data(), bytes.data(), bytes.size());
  return words;
}

// A square of 4 m with points 1 cm apart.
std::vector<ColoredPoint> Plane() {
  std::vector<ColoredPoint> points;
  for (int i = 0; i < 400; ++i) {
    for (int j = 0; j < 400; ++j) {
      points.push_back({{0.01f * static_cast<float>(i) - 2.0f, 0.01f * static_cast<float>(j), 1.0f},
                        {10, 20, 30}});
    }
  }
  return points;
}

TEST(ReportCloud, IsThinnedEvenlyToItsLimit) {
  const std::vector<ColoredPoint> thinned = ThinPoints(Plane(), 2000);
  EXPECT_LE(thinned.size(), 2000u);
  EXPECT_GE(thinned.size(), 1000u) << "no more is thrown away than has to be";
  std::array<int, 4> quarters{};
  for (const ColoredPoint& point : thinned) {
    ++quarters[(point.p.x() > 0.0f ? 1u : 0u) + (point.p.y() > 2.0f ? 2u : 0u)];
  }
  // Voxels are squares here: their counts differ by those along the edges, 45 of some 500.
  for (const int points : quarters) EXPECT_NEAR(points, static_cast<int>(thinned.size() / 4), 60);
}

TEST(ReportCloud, KeepsASmallCloudUnchanged) {
  const json cloud =
      CloudJson({{{1.0f, 2.0f, 3.0f}, {10, 20, 30}}, {{2.0f, 2.5f, 3.0f}, {40, 50, 60}}}, 100);
  EXPECT_EQ(cloud["count"], 2);
  EXPECT_EQ(cloud["of"], 2);
  const std::vector<std::uint16_t> at = Words(cloud["positions"]);
  ASSERT_EQ(at.size(), 6u);
  const auto value = [&](std::size_t i) {
    return cloud["low"][i % 3].get<double>() + cloud["step"].get<double>() * at[i];
  };
  const double half_a_step = 0.5 / 65535;  // of an extent of 1 m
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(value(i), (std::array{1.0, 2.0, 3.0, 2.0, 2.5, 3.0}[i]), half_a_step + 1e-9);
  }
  EXPECT_EQ(Decoded(cloud["colours"]), (std::vector<unsigned char>{10, 20, 30, 40, 50, 60}));
}

TEST(ReportCloud, WithoutPointsIsNone) {
  EXPECT_TRUE(CloudJson({}, 100).is_null());
  const float nan = std::nanf("");
  EXPECT_TRUE(CloudJson({{{nan, 0.0f, 0.0f}}}, 100).is_null());
}

OctomapBuilder Wall(int side) {
  OctomapBuilder octree({.resolution = 0.1});
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      points.emplace_back(2.05f, 0.1f * static_cast<float>(i) + 0.05f,
                          0.1f * static_cast<float>(j) + 0.05f);
    }
  }
  octree.Insert(points, Pose());
  return octree;
}

TEST(ReportOctree, HasTheCellsOfTheOctree) {
  const json octree = OctreeJson(Wall(3), 100);
  EXPECT_EQ(octree["count"], 9);
  EXPECT_DOUBLE_EQ(octree["size"], 0.1);
  EXPECT_NEAR(octree["low"][0], 2.05, 1e-6);
  EXPECT_NEAR(octree["low"][1], 0.05, 1e-6);
  EXPECT_EQ(Words(octree["cells"]),
            (std::vector<std::uint16_t>{0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 1, 0, 0, 1,
                                        1, 0, 1, 2, 0, 2, 0, 0, 2, 1, 0, 2, 2}));
}

TEST(ReportOctree, ThatIsTooFineIsDrawnCoarser) {
  const json octree = OctreeJson(Wall(20), 100);
  EXPECT_EQ(octree["count"], 100) << "400 cells, four of which are one";
  EXPECT_DOUBLE_EQ(octree["size"], 0.2);
  EXPECT_DOUBLE_EQ(octree["resolution"], 0.1);
}

// A circle of 2 m with lateral `noise` [m], 10 frames a second, 10 s.
Trajectory Circle(double noise) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, noise > 0.0 ? noise : 1.0);
  Trajectory trajectory;
  for (int i = 0; i < 100; ++i) {
    const double angle = 0.06 * i;
    Eigen::Vector3d p(2.0 * std::cos(angle), 2.0 * std::sin(angle), 0.1 * std::sin(3.0 * angle));
    if (noise > 0.0) p += Eigen::Vector3d(normal(random), normal(random), normal(random));
    trajectory.push_back({FromSeconds(100.0 + 0.1 * i), Pose(Eigen::Quaterniond::Identity(), p)});
  }
  return trajectory;
}

TEST(ReportMotion, TheTruthIsDrawnInTheWorldOfTheRun) {
  const Trajectory trajectory = Circle(0.0);
  const Pose T = Pose::FromTangent({3.0, -1.0, 2.0}, {0.4, -0.2, 1.0});
  Trajectory truth;
  for (const StampedPose& stamped : trajectory) truth.push_back({stamped.stamp, T * stamped.pose});
  const auto errors = CompareWithTruth(truth, trajectory);
  ASSERT_TRUE(errors);
  ASSERT_EQ(errors->truth_W.size(), trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    // Umeyama's singular values are accurate to some 1e-12 here.
    EXPECT_LT((errors->truth_W[i].pose.p() - trajectory[i].pose.p()).norm(), 1e-9);
  }
  EXPECT_EQ(errors->frames_per_second, 10);
}

TEST(ReportMotion, ErrorsOverTimeAreThoseOfEval) {
  const Trajectory truth = Circle(0.0), trajectory = Circle(0.01);
  const auto errors = CompareWithTruth(truth, trajectory);
  ASSERT_TRUE(errors);
  const json drawn = ErrorsJson(*errors, trajectory.front().stamp, 1000);
  EXPECT_EQ(drawn["ape"]["rmse"], AbsolutePoseError(truth, trajectory).statistics.rmse);
  EXPECT_EQ(drawn["rpe"]["rmse"],
            RelativePoseError(truth, trajectory, {.delta = 10, .all_pairs = true}).statistics.rmse);
  ASSERT_EQ(drawn["ape"]["error"].size(), 100u);
  ASSERT_EQ(drawn["rpe"]["error"].size(), 90u);
  EXPECT_DOUBLE_EQ(drawn["ape"]["t"][1], 0.1);
  EXPECT_DOUBLE_EQ(drawn["rpe"]["t"][0], 1.0) << "a second is over";
  const json path = PathJson(trajectory, trajectory.front().stamp, errors, 1000);
  EXPECT_EQ(path["error"], drawn["ape"]["error"]);
}

TEST(ReportMotion, LongRunsAreThinned) {
  const json path = PathJson(Circle(0.0), 0, std::nullopt, 30);
  EXPECT_EQ(path["t"].size(), 25u) << "each fourth of 100";
  EXPECT_FALSE(path.contains("error"));
}

TEST(ReportMotion, AnotherTimeIsNoTruth) {
  Trajectory later = Circle(0.0);
  for (StampedPose& stamped : later) stamped.stamp += FromSeconds(1000.0);
  EXPECT_FALSE(CompareWithTruth(later, Circle(0.0)));
}

TEST(ReportLoops, AreWhereTheirKeyframesAreByNow) {
  const Trajectory trajectory = Circle(0.0);
  const json events = {
      {{"keyframe_stamp", "109.000000"}, {"match_stamp", "100.000000"}, {"result", "refused"}},
      {{"keyframe_stamp", "200.000000"}, {"result", "closed"}}};
  const json loops = LoopsJson(trajectory, trajectory.front().stamp, events);
  EXPECT_DOUBLE_EQ(loops[0]["t"], 9.0);
  EXPECT_DOUBLE_EQ(loops[0]["t_match"], 0.0);
  EXPECT_EQ(loops[0]["to"], (json{2.0, 0.0, 0.0}));
  EXPECT_NEAR(loops[0]["from"][0], 2.0 * std::cos(5.4), 5.1e-5) << "rounded to a tenth of a mm";
  EXPECT_EQ(loops[0]["result"], "refused");
  EXPECT_TRUE(loops[1]["from"].is_null()) << "a frame of another map";
  EXPECT_TRUE(loops[1]["t_match"].is_null()) << "of a map that was loaded";
}

json RunOf(int frames, int lost) {
  return {{"frames", frames},
          {"lost_frames", lost},
          {"coverage", static_cast<double>(frames - lost) / frames},
          {"keyframes", 12},
          {"landmarks", {{"points", 3000}, {"lines", 1}}},
          {"loops", {{"closed", 1}, {"refused", 2}, {"merges", 0}}}};
}

std::string Joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& paragraph : words) text += paragraph + "\n";
  return text;
}

TEST(ReportWords, DescribeTrackingAndMapping) {
  const std::string text = Joined(SummaryInWords(RunOf(200, 0), nullptr));
  EXPECT_NE(text.find("200 of 200 frames have a pose, 100.0 % of the recording."),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("12 keyframes, 3\u202f000 points and 1 line."), std::string::npos) << text;
  EXPECT_NE(text.find("1 loop was closed, 2 rejected."), std::string::npos) << text;
  EXPECT_NE(text.find("there is no ground truth"), std::string::npos) << text;
  EXPECT_EQ(text.find("IMU"), std::string::npos) << text;
}

TEST(ReportWords, SayHowManyColourImagesHaveNoDepth) {
  json run = RunOf(5, 0);
  run["coverage"] = 5.0 / 30.0;
  run["without_depth"] = 25;
  const std::string text = Joined(SummaryInWords(run, nullptr));
  EXPECT_NE(text.find("5 of 5 frames have a pose, 16.7 % of the recording. "
                      "25 colour images have no depth image in time."),
            std::string::npos)
      << text;
}

TEST(ReportWords, ExplainLostFramesAndAdvise) {
  json run = RunOf(200, 8);
  run["loss_reasons"] = {{"dark", 6}, {"too fast", 2}};
  const std::string text = Joined(SummaryInWords(run, nullptr));
  EXPECT_NE(text.find("6 of 8 frames without a pose: the image is too dark"), std::string::npos)
      << text;
}

TEST(ReportWords, SayWhereTheImagesContradictedTheImu) {
  json run = RunOf(200, 0);
  run["imu"] = {{"initialized", "1.0"}, {"contradicted_intervals", 3}};
  const std::string text = Joined(SummaryInWords(run, nullptr));
  EXPECT_NE(text.find("contradicted its readings in 3 intervals: tracking did not use these."),
            std::string::npos)
      << text;
  run["imu"]["saturated_intervals"] = 1;
  EXPECT_NE(
      Joined(SummaryInWords(run, nullptr)).find("In 1 interval readings saturate the sensor."),
      std::string::npos);
  run["imu"]["contradicted_intervals"] = 0;
  EXPECT_EQ(Joined(SummaryInWords(run, nullptr)).find("contradicted"), std::string::npos);
}

TEST(ReportWords, NameRowTimesThatWereHardlyObservable) {
  json run = RunOf(200, 0);
  run["frame_timing_s"] = {
      {"value", {{"colour_readout", 0.02}, {"depth_readout", 0.001}, {"depth_delay", -0.01}}},
      {"sigma", {{"colour_readout", 0.0004}, {"depth_readout", 0.009}, {"depth_delay", 0.001}}}};
  const std::string text = Joined(SummaryInWords(run, nullptr));
  EXPECT_NE(text.find("20.0 ± 0.4 ms in colour and 1.0 ± 9.0 ms (hardly observed) in depth; depth "
                      "is 10.0 ± 1.0 ms earlier"),
            std::string::npos)
      << text;
}

TEST(ReportWords, GiveTheErrorInReadableUnits) {
  const json errors = {{"ape", {{"rmse", 0.0096}, {"max", 0.25}}},
                       {"rpe", {{"rmse", 0.014}, {"frames", 30}}},
                       {"time_covered", 0.5}};
  const std::string text = Joined(SummaryInWords(RunOf(10, 0), errors));
  EXPECT_NE(text.find("9.6 mm (RMSE, rigid alignment; the largest 0.250 m)"), std::string::npos)
      << text;
  EXPECT_NE(text.find("14.0 mm over a second (30 frames; RMSE)"), std::string::npos) << text;
  EXPECT_NE(text.find("50.0 % of the time of the ground truth"), std::string::npos) << text;
}

TEST(ReportPage, EscapesTheData) {
  const std::string evil = "</script><script>alert(1)</script><!-- scripts -->";
  const std::string page = HtmlPage("a </title> & b", {{"name", evil}});
  EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
  EXPECT_NE(page.find("<title>a &lt;/title> &amp; b</title>"), std::string::npos);
  const std::string begin = "id=\"data\">";
  const std::size_t at = page.find(begin) + begin.size();
  const json data = json::parse(page.substr(at, page.find("</script>", at) - at));
  EXPECT_EQ(data["name"], evil);
}

TEST(ReportPage, CarriesTheLicenceOfThreeJsWithIt) {
  const std::string page = HtmlPage("t", json::object());
  EXPECT_EQ(page.find("Copyright © 2010-2019 three.js authors") != std::string::npos, HasView3d());
}

TEST(ReportPage, NamesThatAreNoUtf8DoNotStopIt) {
  EXPECT_NO_THROW(HtmlPage("t", {{"name", "caf\xe9"}}));
}

TEST(ReportPage, AsksNoNetworkForAnything) {
  const std::string page = HtmlPage("t", json::object());
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos) << "a browser would refuse it";
  for (const char* forbidden : {"src=\"http", "href=\"http", "@import"}) {
    EXPECT_EQ(page.find(forbidden), std::string::npos) << forbidden;
  }
}

}  // namespace
}  // namespace highwall::apps::report_data_test
