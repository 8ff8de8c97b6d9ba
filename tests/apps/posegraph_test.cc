// Runs highwall posegraph in the same way as a user.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/pose_graph.h>

#include "support/false_loops.h"
#include "support/pose_graph_scenes.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::posegraph_test {
namespace {

using testing::Outcome;

class PosegraphCommand : public ::testing::Test {
 protected:
  PosegraphCommand() {
    WriteG2o(folder_ / "sphere.g2o", MakeSphere(1));
    PoseGraph field = MakeField(1);
    field.has_poses = false;
    WriteG2o(folder_ / "field.g2o", field);
  }

  void Write(const std::string& name, const std::string& text) const {
    testing::WriteText(folder_ / name, text);
  }

  // Runs in the folder, so that names need no path.
  Outcome Run(const std::string& arguments) const {
    return testing::RunProgram(testing::kHighwallProgram, "posegraph " + arguments, folder_.path());
  }

  nlohmann::json RunJson(const std::string& arguments) const {
    const Outcome outcome = Run(arguments + " --json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);  // fails if anything follows it
  }

  // Expects the exit code, one line on standard error that contains `text`, and no other output.
  void ExpectFailure(const std::string& arguments, int exit_code, const std::string& text) const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run(arguments);
    testing::ExpectRefused(outcome, exit_code, {text});
    EXPECT_TRUE(outcome.err.starts_with("highwall posegraph: ")) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.g2o"));
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(PosegraphCommand, JsonHasTheContractsKeysAndTheOutputItsChi2) {
  const nlohmann::json json = RunJson("sphere.g2o out.g2o");
  for (const char* key :
       {"initial_chi2", "final_chi2", "iterations", "solve_seconds", "total_seconds", "rejected"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["rejected"], nlohmann::json::array());
  EXPECT_GE(json["total_seconds"], json["solve_seconds"]);
  EXPECT_LT(json["final_chi2"], json["initial_chi2"]);
  EXPECT_NEAR(Chi2(ReadG2o(folder_ / "out.g2o")), json["final_chi2"], 1e-6);
}

TEST_F(PosegraphCommand, EveryInitializationReachesTheSameOptimum) {
  const double chi2 = RunJson("sphere.g2o out.g2o")["final_chi2"];
  const double planar = RunJson("field.g2o out.g2o")["final_chi2"];
  for (const std::string init : {"odometry", "tree", "chordal"}) {
    EXPECT_NEAR(RunJson("sphere.g2o out.g2o --init " + init)["final_chi2"], chi2, 1e-4 * chi2);
    EXPECT_NEAR(RunJson("field.g2o out.g2o --init " + init)["final_chi2"], planar, 1e-4 * planar);
  }
  EXPECT_NEAR(RunJson("sphere.g2o out.g2o --init given")["final_chi2"], chi2, 1e-4 * chi2);
}

TEST_F(PosegraphCommand, RobustMethodsReportEachRejectedLoop) {
  PoseGraph graph = MakeSphere(2);
  const std::size_t first = graph.edges.size();
  const std::size_t count = AddFalseLoops(0.2, FalseLoopKind::kRandom, 3, &graph).size();
  WriteG2o(folder_ / "false.g2o", graph);
  for (const std::string robust : {"gnc", "dcs", "switchable"}) {
    const nlohmann::json json = RunJson("false.g2o out.g2o --robust " + robust);
    EXPECT_EQ(json["rejected"].size(), count) << robust;
    for (const nlohmann::json& loop : json["rejected"]) {
      EXPECT_GE(loop["edge"], first);
      EXPECT_EQ(loop["i"], graph.edges[loop["edge"].get<std::size_t>()].i);
      EXPECT_FALSE(loop["reason"].get<std::string>().empty());
    }
  }
  const Outcome text = Run("false.g2o out.g2o --robust gnc");
  EXPECT_NE(text.out.find("rejected    " + std::to_string(count) + " of"), std::string::npos)
      << text.out;
}

TEST_F(PosegraphCommand, PlotIsAWholeSvg) {
  for (const std::string file : {"sphere.g2o", "field.g2o"}) {
    EXPECT_EQ(Run(file + " out.g2o --init odometry --plot graph.svg").exit_code, 0);
    const std::string svg = testing::ReadText(folder_ / "graph.svg");
    EXPECT_TRUE(svg.starts_with("<svg "));
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_NE(svg.find(file), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
  }
}

TEST_F(PosegraphCommand, APieceOfItsOwnIsSolvedWithAWarning) {
  Write("two.g2o", testing::ReadText(folder_ / "sphere.g2o") +
                       "VERTEX_SE3:QUAT 900 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 901 1 0 0 0 0 0 1\n"
                       "EDGE_SE3:QUAT 900 901 2 0 0 0 0 0 1 "
                       "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n");
  const Outcome outcome = Run("two.g2o out.g2o --json");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("warning: two.g2o: the graph is in 2 pieces"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["components"], 2);
  EXPECT_NEAR(ReadG2o(folder_ / "out.g2o").nodes.back().pose.p().x(), 2.0, 1e-9);
}

TEST_F(PosegraphCommand, WrongUsageExitsWithOne) {
  ExpectFailure("", 1, "input is required");
  ExpectFailure("sphere.g2o", 1, "output is required");
  ExpectFailure("sphere.g2o out.g2o --init magic", 1, "--init");
  ExpectFailure("sphere.g2o out.g2o --robust magic", 1, "--robust");
  ExpectFailure("sphere.g2o out.g2o --plot a.png", 1, ".svg");
  ExpectFailure("sphere.g2o out.g2o --max-loop-chi2 -1", 1, "--max-loop-chi2");
}

TEST_F(PosegraphCommand, BadDataExitsWithTwoAndSaysWhere) {
  const std::string sphere = testing::ReadText(folder_ / "sphere.g2o");
  const std::string identity = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const auto expect = [&](const std::string& text, const std::string& message) {
    Write("bad.g2o", text);
    ExpectFailure("bad.g2o out.g2o --json", 2, "bad.g2o" + message);
  };
  ExpectFailure("none.g2o out.g2o", 2, "none.g2o: cannot be opened");
  ExpectFailure("field.g2o out.g2o --init given", 2, "holds no vertices");
  ExpectFailure("sphere.g2o no/out.g2o", 2, "no/out.g2o");
  expect("", ": holds no pose graph");
  expect("VERTEX_SE2 0 0 0 0\n", ": holds no edges");
  expect("VERTEX_SE3:QUAT 0 0 0 0\n" + sphere, ":1: VERTEX_SE3:QUAT needs 7");
  expect("VERTEX_SE3:QUAT 3 0 0 0 0 0 0 1\n" + sphere, ":5: vertex 3 is there twice");
  expect("EDGE_SE3:QUAT 0 900 0 0 0 0 0 0 1" + identity + sphere, ":1: edge to vertex 900");
  expect("EDGE_SE3:QUAT 0 5 0 nan 0 0 0 0 1" + identity + sphere, ":1: EDGE_SE3:QUAT: 'nan'");
  expect("EDGE_SE3:QUAT 0 5 0 0 0 0 0 0 1 -1" + identity.substr(2) + sphere,
         ":1: the information matrix is not positive definite");
}

TEST_F(PosegraphCommand, HelpHasAnExample) {
  const Outcome help = Run("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("Example:"), std::string::npos);
}

}  // namespace
}  // namespace highwall::posegraph_test
