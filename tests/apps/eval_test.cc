// Runs the highwall executable in the same way as a user.
#include <cmath>
#include <cstdio>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::eval_test {
namespace {

using testing::Outcome;

// Returns a line of a TUM file on a curved path; the estimate has an error of `error` metres along
// z, alternately up and down.
std::string TumLine(int i, double error) {
  const double t = 0.1 * i;
  char line[200];
  std::snprintf(line, sizeof(line), "%.6f %.9f %.9f %.9f 0 0 0 1\n", 1305031102.0 + t, t,
                std::sin(t), std::cos(t) + (i % 2 == 0 ? error : -error));
  return line;
}

class EvalCommand : public ::testing::Test {
 protected:
  EvalCommand() {
    for (int i = 0; i < 100; ++i) {
      reference_lines_ += TumLine(i, 0.0);
      estimate_lines_ += TumLine(i, 0.25);
    }
    Write("reference.txt", reference_lines_);
    Write("estimate.txt", estimate_lines_);
  }

  void Write(const std::string& name, const std::string& text) const {
    testing::WriteText(folder_ / name, text);
  }

  // Runs in the folder, so that names need no path.
  Outcome Run(const std::string& arguments) const {
    return testing::RunProgram(testing::kHighwallProgram, arguments, folder_.path());
  }

  // Expects the exit code, one line on standard error that contains `text`, and no standard output.
  void ExpectFailure(const std::string& arguments, int exit_code, const std::string& text) const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run(arguments);
    testing::ExpectRefused(outcome, exit_code, {text});
    EXPECT_TRUE(outcome.err.starts_with("highwall eval: ")) << outcome.err;
  }

  const testing::TemporaryDirectory folder_;
  std::string reference_lines_;
  std::string estimate_lines_;
};

TEST_F(EvalCommand, JsonIsOneObjectWithTheContractsKeysAndNothingElse) {
  const Outcome outcome = Run("eval ape reference.txt estimate.txt --align none --json");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  const nlohmann::json json = nlohmann::json::parse(outcome.out);  // fails if anything follows it
  std::set<std::string> keys, statistics;
  for (const auto& item : json.items()) keys.insert(item.key());
  for (const auto& item : json["stats"].items()) statistics.insert(item.key());
  EXPECT_EQ(keys, (std::set<std::string>{"stats", "associated", "scale", "time_covered"}));
  EXPECT_EQ(statistics,
            (std::set<std::string>{"max", "mean", "median", "min", "rmse", "sse", "std"}));
  EXPECT_EQ(json["associated"], 100);
  EXPECT_NEAR(json["stats"]["rmse"], 0.25, 1e-8);  // the files have nine decimals
  EXPECT_NEAR(json["time_covered"], 1.0, 1e-9);
  EXPECT_EQ(json["scale"], 1.0);
}

TEST_F(EvalCommand, RelativeErrorCountsPairsAsAsked) {
  const auto rmse = [&](const std::string& options) {
    const Outcome outcome = Run("eval rpe reference.txt estimate.txt --json " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["stats"]["rmse"].get<double>();
  };
  EXPECT_NEAR(rmse(""), 0.5, 1e-8);           // up to down
  EXPECT_NEAR(rmse("--delta 2"), 0.0, 1e-8);  // up to up
  EXPECT_NEAR(rmse("--delta 3 --delta-unit f --all-pairs"), 0.5, 1e-8);
  EXPECT_NEAR(rmse("--relation angle_deg"), 0.0, 1e-5);
  EXPECT_NEAR(rmse("--relation full"), 0.5, 1e-8);
  EXPECT_GT(rmse("--delta 1.5 --delta-unit m"), 0.0);
}

TEST_F(EvalCommand, AlignsAbsoluteErrorsBySe3ByDefault) {
  const auto out = [&](const std::string& options) {
    return Run("eval ape reference.txt estimate.txt --json " + options).out;
  };
  EXPECT_EQ(out(""), out("--align se3"));
  EXPECT_NE(out(""), out("--align none"));
  EXPECT_NE(nlohmann::json::parse(out("--align sim3"))["scale"], 1.0);
  EXPECT_NE(out("--align origin"), out("--align none"));
}

TEST_F(EvalCommand, TextShowsTheFigures) {
  const Outcome outcome = Run("eval ape reference.txt estimate.txt --align none");
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* text :
       {"rmse", "0.250000", "over 100.0 % of the time", "100 poses", "estimate.txt"}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << outcome.out;
  }
}

// 10 s at 30 Hz of a body that rotates, observed 20 ms late and 1 % too large.
TEST_F(EvalCommand, ExplainsTheError) {
  std::string reference, estimate;
  const auto line = [](double stamp, double t, double scale) {
    char text[200];
    std::snprintf(text, sizeof(text), "%.6f %.9f %.9f %.9f 0 0 %.9f %.9f\n", stamp,
                  scale * std::sin(t), scale * std::cos(1.3 * t), scale * std::sin(0.7 * t),
                  std::sin(0.4 * t), std::cos(0.4 * t));
    return std::string(text);
  };
  for (int i = -60; i < 660; ++i) {
    const double t = i / 60.0;
    reference += line(1000.0 + t, t, 1.0);
    if (i >= 0 && i < 600 && i % 2 == 0) estimate += line(1000.02 + t, t, 1.01);
  }
  Write("moving.txt", reference);
  Write("late.txt", estimate);
  const Outcome text = Run("eval ape moving.txt late.txt --explain --plot explained.svg");
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_TRUE(testing::Contains(text.out, "-20.0")) << text.out;
  EXPECT_TRUE(testing::Contains(text.out, "0.9901 +- ")) << text.out;
  EXPECT_TRUE(testing::Contains(text.out, "slow part")) << text.out;
  EXPECT_TRUE(
      testing::Contains(testing::ReadText(folder_ / "explained.svg"), "without shift, scale"));
  const Outcome outcome = Run("eval ape moving.txt late.txt --explain --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json explanation = nlohmann::json::parse(outcome.out)["explanation"];
  const nlohmann::json both = explanation["time_shift_and_scale"];
  // Positions have nine decimals, and the reference is interpolated linearly.
  EXPECT_NEAR(both["time_shift_s"].get<double>(), -0.02, 1e-4);
  EXPECT_NEAR(both["scale"].get<double>(), 1.0 / 1.01, 1e-4);
  EXPECT_LT(both["rmse_m"].get<double>(), 0.01 * explanation["rmse_m"].get<double>());
  ExpectFailure("eval rpe moving.txt late.txt --explain", 1, "--explain");
  ExpectFailure("eval ape moving.txt late.txt --explain --align sim3", 1, "--explain");
  Write("short.txt", estimate.substr(0, estimate.find('\n', estimate.size() / 10) + 1));
  ExpectFailure("eval ape moving.txt short.txt --explain", 2,
                "short.txt: 31 poses at stamps that the reference covers without a hole are too "
                "few to explain the error: it takes 80 (leave --explain out)");
}

// A walk along the x axis, and an estimate that is alternately 0.1 m to the left and to the right
// of it, rotated by half a radian about y.
TEST_F(EvalCommand, AStraightTrackHasAFigureAndNamesTheUnobservableDirection) {
  std::string track, estimate;
  for (int i = 0; i < 100; ++i) {
    char text[200];
    const double x = 0.01 * i * i, side = i % 4 == 0 || i % 4 == 3 ? 0.1 : -0.1;
    std::snprintf(text, sizeof(text), "%d %.9f 0 0 0 0 0 1\n", i, x);
    track += text;
    std::snprintf(text, sizeof(text), "%d %.12f %.12f %.12f 0 %.12f 0 %.12f\n", i,
                  std::cos(0.5) * x, side, -std::sin(0.5) * x, std::sin(0.25), std::cos(0.25));
    estimate += text;
  }
  Write("track.txt", track);
  Write("estimate.txt", estimate);
  for (const std::string file : {"track.txt", "estimate.txt"}) {
    for (const std::string relation : {"trans_part", "angle_deg"}) {
      const Outcome outcome = Run("eval ape track.txt " + file + " --json --relation " + relation);
      ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
      EXPECT_EQ(testing::CountLines(outcome.err), 1u) << outcome.err;
      EXPECT_TRUE(testing::Contains(outcome.err, file + ": all matched positions lie on a straight "
                                                        "line: the rotation about it"));
      const nlohmann::json json = nlohmann::json::parse(outcome.out);
      const bool off = file == "estimate.txt" && relation == "trans_part";
      // The sides tilt the track only in second order: side * x is nearly balanced.
      EXPECT_NEAR(json["stats"]["rmse"], off ? 0.1 : 0.0, 1e-3) << file << relation;
      EXPECT_TRUE(json.contains("undetermined"));
    }
  }
  EXPECT_EQ(Run("eval ape track.txt estimate.txt --explain").exit_code, 0);
  EXPECT_EQ(Run("eval ape track.txt estimate.txt --align sim3").exit_code, 0);
}

// A character is 0.6 times as wide as its font is high, in the default fonts of browsers.
void ExpectTextsInside(const std::string& svg) {
  double width = 0.0;
  std::sscanf(svg.c_str() + svg.find(" width=\"") + 8, "%lf", &width);
  ASSERT_GT(width, 0.0);
  std::size_t texts = 0;
  for (std::size_t at = svg.find("<text "); at != std::string::npos; at = svg.find("<text ", at)) {
    const std::string tag = svg.substr(at, svg.find('>', at) - at);
    at += tag.size() + 1;
    const std::string text = svg.substr(at, svg.find('<', at) - at);
    double x = 0.0, size = 0.0;
    std::sscanf(tag.c_str() + tag.find("x=\"") + 3, "%lf", &x);
    std::sscanf(tag.c_str() + tag.find("font-size=\"") + 11, "%lf", &size);
    if (tag.find("\"start\"") == std::string::npos || tag.find("rotate") != std::string::npos)
      continue;
    EXPECT_LE(x + 0.6 * size * static_cast<double>(text.size()), width) << text;
    ++texts;
  }
  EXPECT_GE(texts, 4u);
}

TEST_F(EvalCommand, PlotsHoldTheirTexts) {
  const std::string name = std::string(130, 'n') + ".txt";
  Write(name, estimate_lines_);
  for (const std::string& arguments :
       {"ape reference.txt " + name + " --explain",
        "rpe reference.txt " + name + " --delta 0.123456 --delta-unit m --relation angle_deg",
        "ape reference.txt estimate.txt " + name}) {
    ASSERT_EQ(Run("eval " + arguments + " --plot e.svg").exit_code, 0) << arguments;
    const std::string svg = testing::ReadText(folder_ / "e.svg");
    ExpectTextsInside(svg);
    EXPECT_TRUE(testing::Contains(svg, "nnn.txt")) << "the end of the name";
  }
}

TEST_F(EvalCommand, WrongUsageExitsWithOne) {
  ExpectFailure("eval", 1, "metric is required");
  ExpectFailure("eval ate reference.txt estimate.txt", 1, "must be ape or rpe, is ate");
  ExpectFailure("eval ape reference.txt", 1, "estimate is required");
  ExpectFailure("eval ape reference.txt estimate.txt --colour", 1, "--colour");
  ExpectFailure("eval ape reference.txt estimate.txt --align icp", 1, "--align");
  ExpectFailure("eval ape reference.txt estimate.txt --relation yaw", 1, "--relation");
  ExpectFailure("eval ape reference.txt estimate.txt --t-max-diff -1", 1, "--t-max-diff");
  ExpectFailure("eval ape reference.txt estimate.txt --t-max-diff nan", 1, "--t-max-diff");
  ExpectFailure("eval ape reference.txt estimate.txt --delta 2", 1, "rpe only");
  ExpectFailure("eval rpe reference.txt estimate.txt --delta 0", 1, "--delta");
  ExpectFailure("eval rpe reference.txt estimate.txt --delta 1.5", 1, "whole number");
  ExpectFailure("eval rpe reference.txt estimate.txt --delta many", 1, "--delta");
  ExpectFailure("eval ape reference.txt estimate.txt --plot a.pdf", 1, ".svg or .png");
  ExpectFailure("eval ape reference.txt estimate.txt --evo-results a.tar", 1, ".zip");
  ExpectFailure("eval ape reference.txt estimate.txt --json --csv", 1, "--csv");
  ExpectFailure("eval ape reference.txt estimate.txt estimate.txt --explain", 1, "one estimate");
}

TEST_F(EvalCommand, BadDataExitsWithTwoAndSaysWhere) {
  ExpectFailure("eval ape none.txt estimate.txt --json", 2, "none.txt: cannot be opened");
  ExpectFailure("eval ape . estimate.txt", 2, "folder");
  Write("empty.txt", "# nothing\n");
  ExpectFailure("eval ape reference.txt empty.txt --json", 2, "empty.txt: holds no pose");
  Write("short.txt", estimate_lines_ + "1305031200.0 1 2 3\n");
  ExpectFailure("eval ape reference.txt short.txt --json", 2, "short.txt:101: expected the 8");
  Write("nan.txt", estimate_lines_ + "1305031200.0 1 nan 3 0 0 0 1\n");
  ExpectFailure("eval ape reference.txt nan.txt --json", 2, "nan.txt:101: ty 'nan'");
  Write("other.txt", "1.0 0 0 0 0 0 0 1\n2.0 0 1 0 0 0 0 1\n");
  ExpectFailure("eval ape reference.txt other.txt --json", 2, "no stamps match");
  ExpectFailure("eval rpe reference.txt estimate.txt --delta 100", 2, "frames apart");
  Write("far.txt", "1305031102.0 1e200 0 0 0 0 0 1\n1305031102.1 0 1e200 0 0 0 0 1\n");
  ExpectFailure("eval ape reference.txt far.txt --align none --json", 2, "too large");
  Write("two.txt", TumLine(0, 0.0) + TumLine(1, 0.0));
  ExpectFailure("eval ape reference.txt two.txt --align se3", 2, "three matched poses");
}

TEST_F(EvalCommand, PlotIsAWholeSvg) {
  for (const std::string metric : {"ape", "rpe"}) {
    const Outcome outcome =
        Run("eval " + metric + " reference.txt estimate.txt --json --plot error.svg");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(nlohmann::json::accept(outcome.out));
    const std::string svg = testing::ReadText(folder_ / "error.svg");
    EXPECT_TRUE(svg.starts_with("<svg "));
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_NE(svg.find("estimate.txt against reference.txt"), std::string::npos);
    for (const char* axis : {"x [m]", "time [s]", "translation error [m]"}) {
      EXPECT_NE(svg.find(axis), std::string::npos) << axis;
    }
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
  }
}

TEST_F(EvalCommand, PlotOfAPerfectOrSinglePoseIsDrawnToo) {
  Write("one.txt", TumLine(3, 0.0));
  for (const std::string estimate : {"reference.txt", "one.txt"}) {
    EXPECT_EQ(Run("eval ape reference.txt " + estimate + " --align none --plot e.svg").exit_code,
              0);
    const std::string svg = testing::ReadText(folder_ / "e.svg");
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_EQ(svg.find("nan"), std::string::npos);
  }
  EXPECT_EQ(Run("eval ape one.txt one.txt --align none --plot e.svg").exit_code, 0);
  EXPECT_EQ(testing::ReadText(folder_ / "e.svg").find("nan"), std::string::npos);
}

TEST_F(EvalCommand, AFailureLeavesAnOldPlotAloneAndNothingBeside) {
  Write("error.svg", "old");
  ExpectFailure("eval ape reference.txt none.txt --plot error.svg", 2, "none.txt");
  EXPECT_EQ(testing::ReadText(folder_ / "error.svg"), "old");
  ExpectFailure("eval ape reference.txt estimate.txt --json --plot no/error.svg", 2,
                "no/error.svg");
  EXPECT_EQ(folder_.FileCount(), 3U);
}

TEST_F(EvalCommand, HelpHasAnExampleAndTheProgramAVersion) {
  const Outcome help = Run("eval --help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("Example:"), std::string::npos);
  const Outcome version = Run("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_TRUE(version.out.starts_with("highwall ")) << version.out;
  const Outcome bare = Run("");
  EXPECT_EQ(bare.exit_code, 1);
  EXPECT_NE(bare.err.find("eval"), std::string::npos) << "says how to begin";
  EXPECT_EQ(Run("evil").exit_code, 1);
}

}  // namespace
}  // namespace highwall::eval_test
