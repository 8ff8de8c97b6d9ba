// Pose graphs with priors on poses and with partial measurements.
#include <highwall/core/pose_graph.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "support/temporary_directory.h"

namespace highwall::pose_graph_priors_test {
namespace {

constexpr std::array kInitializations = {
    PoseGraphInitialization::kGiven, PoseGraphInitialization::kOdometry,
    PoseGraphInitialization::kTree, PoseGraphInitialization::kChordal};

PoseInformation Information(double position, double rotation) {
  Eigen::Matrix<double, 6, 1> diagonal;
  diagonal << position, position, position, rotation, rotation, rotation;
  return PoseInformation(diagonal.asDiagonal());
}

// A walk with rotations in space, with exact edges and a loop closure from its end to its start.
PoseGraph Walk(int poses) {
  PoseGraph graph;
  for (int i = 0; i < poses; ++i) {
    const double t = 0.6 * i;
    graph.nodes.push_back(
        {i, Pose(so3::Exp({0.2 * std::sin(t), 0.1 * t, 0.3 * t}),
                 {2.0 * std::sin(t), 2.0 - 2.0 * std::cos(t), 0.3 * std::sin(2.0 * t)})});
  }
  const auto connect = [&](std::size_t i, std::size_t j, PoseGraphEdgeKind kind) {
    graph.edges.push_back({graph.nodes[i].id, graph.nodes[j].id, kind,
                           graph.nodes[i].pose.Inverse() * graph.nodes[j].pose,
                           Information(100.0, 400.0)});
  };
  for (std::size_t i = 1; i < graph.nodes.size(); ++i)
    connect(i - 1, i, PoseGraphEdgeKind::kOdometry);
  connect(graph.nodes.size() - 1, 0, PoseGraphEdgeKind::kLoop);
  return graph;
}

void AddPrior(std::int64_t id, const Pose& Z, const PoseInformation& information,
              PoseGraph* graph) {
  if (!graph->world) {
    graph->world = 1000;
    graph->nodes.push_back({1000, Pose(), /*fixed=*/true});
  }
  graph->edges.push_back(
      {*graph->world, id, PoseGraphEdgeKind::kLoop, Z, information, /*trusted=*/true});
}

PoseGraph Solved(PoseGraph graph, PoseGraphInitialization initialization) {
  // The graph is written to a file and read back, as if it came from another program.
  const testing::TemporaryDirectory folder;
  WriteG2o(folder / "graph.g2o", graph);
  graph = ReadG2o(folder / "graph.g2o");
  InitializePoseGraph(&graph, initialization);
  const PoseGraphSummary summary = SolvePoseGraph(&graph);
  EXPECT_EQ(summary.status, SolveStatus::kConverged) << summary.message;
  EXPECT_TRUE(summary.warnings.empty());
  return graph;
}

TEST(PoseGraphPriors, OneOfAWholePosePutsTheGraphThere) {
  PoseGraph graph = Walk(10);
  const Pose T(so3::Exp({0.1, -0.2, 0.4}), {3.0, -1.0, 0.5});
  AddPrior(3, T * graph.nodes[3].pose, Information(100.0, 400.0), &graph);
  for (const auto initialization : kInitializations) {
    const PoseGraph solved = Solved(graph, initialization);
    EXPECT_LT(Chi2(solved), 1e-12);
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_TRUE(solved.nodes[i].pose.Matrix().isApprox((T * graph.nodes[i].pose).Matrix(), 1e-6));
    }
  }
}

TEST(PoseGraphPriors, PositionsOfAGpsPutTheGraphAmongThem) {
  PoseGraph graph = Walk(10);
  const Pose T(so3::Exp({0.1, -0.2, 0.4}), {3.0, -1.0, 0.5});
  for (const std::size_t i : {0u, 2u, 5u, 8u}) {
    AddPrior(graph.nodes[i].id, Pose(Eigen::Quaterniond::Identity(), (T * graph.nodes[i].pose).p()),
             Information(4.0, 0.0), &graph);
  }
  for (const auto initialization : kInitializations) {
    const PoseGraph solved = Solved(graph, initialization);
    EXPECT_LT(Chi2(solved), 1e-10);
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_TRUE(solved.nodes[i].pose.Matrix().isApprox((T * graph.nodes[i].pose).Matrix(), 1e-5))
          << i;
    }
  }
}

TEST(PoseGraphPriors, AnEdgeWithoutRotationLeavesThatToTheOthers) {
  for (const bool position : {true, false}) {
    PoseGraph graph = Walk(10);
    const PoseGraph truth = graph;
    // The components that are not measured are still written to the file, with wrong values.
    graph.edges[4].information = position ? Information(100.0, 0.0) : Information(0.0, 400.0);
    const Pose& Z = graph.edges[4].Z;
    graph.edges[4].Z = position ? Pose(so3::Exp({1.0, 0.5, 0.0}), Z.p())
                                : Pose(Z.q(), Z.p() + Eigen::Vector3d(1.0, 2.0, 3.0));
    for (const auto initialization : kInitializations) {
      const PoseGraph solved = Solved(graph, initialization);
      EXPECT_LT(Chi2(solved), 1e-10);
      for (std::size_t i = 0; i < 10; ++i) {
        EXPECT_TRUE(solved.nodes[i].pose.Matrix().isApprox(truth.nodes[i].pose.Matrix(), 1e-5))
            << i;
      }
    }
  }
}

TEST(PoseGraphPriors, LoopsWithoutRotationAreJudgedByTheirPositions) {
  PoseGraph graph = Walk(12);
  const auto loop = [&](std::size_t i, std::size_t j, const Eigen::Vector3d& off) {
    const Pose Z = graph.nodes[i].pose.Inverse() * graph.nodes[j].pose;
    graph.edges.push_back({graph.nodes[i].id, graph.nodes[j].id, PoseGraphEdgeKind::kLoop,
                           Pose(Z.q(), Z.p() + off), Information(100.0, 0.0)});
  };
  loop(0, 10, Eigen::Vector3d::Zero());
  loop(1, 11, Eigen::Vector3d::Zero());
  loop(2, 9, {3.0, 0.0, 0.0});
  const PoseGraphSummary summary =
      SolvePoseGraph(&graph, {.robust = RobustLoops::kGnc, .estimate_variance_factor = false});
  ASSERT_EQ(summary.rejected.size(), 1u);
  EXPECT_EQ(graph.edges[summary.rejected[0].edge].i, 2);
}

}  // namespace
}  // namespace highwall::pose_graph_priors_test
