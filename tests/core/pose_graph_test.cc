#include <highwall/core/pose_graph.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/internal/se3.h>

#include "support/false_loops.h"
#include "support/pose_graph_scenes.h"
#include "support/position_in_frame.h"

namespace highwall::pose_graph_test {
namespace {

using Initialization = PoseGraphInitialization;
constexpr Initialization kAllComposed[] = {Initialization::kOdometry, Initialization::kTree,
                                           Initialization::kChordal};

// Returns the largest difference of positions [m] or rotations [rad].
double Distance(const PoseGraph& a, const PoseGraph& b) {
  double largest = 0.0;
  for (std::size_t n = 0; n < a.nodes.size(); ++n) {
    const Pose& p = a.nodes[n].pose;
    const Pose& q = b.nodes[n].pose;
    largest = std::max({largest, (p.p() - q.p()).norm(), (p.Inverse() * q).Angle()});
  }
  return largest;
}

PoseGraph Scrambled(PoseGraph graph) {
  for (std::size_t n = 1; n < graph.nodes.size(); ++n) graph.nodes[n].pose = Pose();
  return graph;
}

void ExpectInvalid(const PoseGraph& graph, const std::string& text) {
  for (const auto& use : std::initializer_list<std::function<void(PoseGraph)>>{
           [](PoseGraph g) { g.Validate(); }, [](PoseGraph g) { SolvePoseGraph(&g); },
           [](PoseGraph g) { InitializePoseGraph(&g, Initialization::kChordal); },
           [](PoseGraph g) { Chi2(g); }, [](PoseGraph g) { PoseGraphCovariance(g, {}); }}) {
    try {
      use(graph);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InvalidArgument& error) {
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  }
}

TEST(PoseGraph, Chi2InSpaceIsThatOfTheLogarithmComputedByHand) {
  // As in RelativePose: the logarithm of a quarter turn about z that ends at (1, 1, 0).
  const double quarter = 0.5 * M_PI;
  PoseGraph graph;
  graph.nodes = {{0, Pose()}, {1, Pose::FromTangent({1, 1, 0}, {0, 0, quarter})}};
  Eigen::Matrix<double, 6, 1> weights;
  weights << 1, 2, 3, 4, 5, 6;
  graph.edges = {{0, 1, PoseGraphEdgeKind::kOdometry, Pose(), weights.asDiagonal()}};
  EXPECT_NEAR(Chi2(graph), 7.0 * quarter * quarter, 1e-13);
}

TEST(PoseGraph, Chi2InThePlaneIsThatOfTheDifferenceComputedByHand) {
  // Z = (1, 0, quarter turn): in the frame of Z, j at (1, 2) in i lies 2 along x, with 5 too much
  // rotation.
  PoseGraph graph;
  graph.space = PoseGraphSpace::kSe2;
  const auto turn = [](double angle) {
    return Eigen::Quaterniond(std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle));
  };
  graph.nodes = {{0, Pose(turn(0.5), {3, 4, 0})}, {1, Pose()}};
  graph.nodes[1].pose = graph.nodes[0].pose * Pose(turn(0.5 * M_PI + 5.0), {1, 2, 0});

  graph.edges = {{0, 1, PoseGraphEdgeKind::kOdometry, Pose(turn(0.5 * M_PI), {1, 0, 0}),
                  Eigen::Vector3d(1, 10, 100).asDiagonal()}};
  const double wrapped = 5.0 - 2.0 * M_PI;
  EXPECT_NEAR(Chi2(graph), 4.0 + 100.0 * wrapped * wrapped, 1e-11);
}

TEST(PoseGraph, EveryInitializationIsExactOnExactEdges) {
  for (const PoseGraph& truth : {MakeSphere(1, 0.0), MakeField(1, 0.0)}) {
    for (const Initialization initialization : kAllComposed) {
      PoseGraph graph = Scrambled(truth);
      graph.has_poses = false;
      InitializePoseGraph(&graph, initialization);
      EXPECT_TRUE(graph.has_poses);
      EXPECT_LT(Distance(graph, truth), 1e-10) << static_cast<int>(initialization);
    }
  }
}

TEST(PoseGraph, ChordalInitializationIsCloseToTheOptimum) {
  for (const PoseGraph& truth : {MakeSphere(2), MakeField(2)}) {
    PoseGraph graph = Scrambled(truth), odometry = graph;
    InitializePoseGraph(&graph, Initialization::kChordal);
    InitializePoseGraph(&odometry, Initialization::kOdometry);
    PoseGraph solved = graph;
    SolvePoseGraph(&solved);
    EXPECT_LT(Chi2(graph), 1.5 * Chi2(solved));
    EXPECT_GT(Chi2(odometry), 3.0 * Chi2(graph));
  }
}

TEST(PoseGraph, OdometryIsFollowedBeforeLoopsAndTheTreeHasFewestEdges) {
  // A chain 0-1-2-3 along x with an inconsistent loop 0-3.
  PoseGraph graph = MakeField(1, 0.0, 1);
  graph.nodes.resize(4);
  graph.edges.resize(3);
  PoseGraphEdge loop = graph.edges.front();
  loop.j = 3;
  loop.kind = PoseGraphEdgeKind::kLoop;
  loop.Z = Pose(Eigen::Quaterniond::Identity(), {9, 0, 0});
  graph.edges.push_back(loop);
  InitializePoseGraph(&graph, Initialization::kOdometry);
  EXPECT_NEAR(graph.nodes[3].pose.p().x(), 3.0, 1e-12);
  InitializePoseGraph(&graph, Initialization::kTree);
  EXPECT_NEAR(graph.nodes[3].pose.p().x(), 9.0, 1e-12);
  graph.edges.erase(graph.edges.begin() + 2);  // without odometry 2-3 only the loop reaches 3
  InitializePoseGraph(&graph, Initialization::kOdometry);
  EXPECT_NEAR(graph.nodes[3].pose.p().x(), 9.0, 1e-12);
}

TEST(PoseGraph, SolvingExactEdgesRecoversTheTruth) {
  for (const PoseGraph& truth : {MakeSphere(3, 0.0), MakeField(3, 0.0)}) {
    PoseGraph graph = truth;
    for (std::size_t n = 1; n < graph.nodes.size(); ++n) {
      const double x = 0.1 * std::sin(static_cast<double>(n));
      graph.nodes[n].pose =
          graph.nodes[n].pose * Pose::FromTangent({x, -x, 0.0}, {0.0, 0.0, 0.5 * x});
      if (graph.space == PoseGraphSpace::kSe2) graph.nodes[n].pose.data()[2] = 0.0;
    }
    const PoseGraphSummary summary = SolvePoseGraph(&graph);
    EXPECT_EQ(summary.status, SolveStatus::kConverged) << summary.message;
    EXPECT_GT(summary.initial_chi2, 1.0);
    EXPECT_LT(summary.final_chi2, 1e-9);
    EXPECT_LT(Distance(graph, truth), 1e-5);
  }
}

TEST(PoseGraph, TheOptimumIsTheSameFromEveryStartAndInsideItsChi2Band) {
  for (const PoseGraph& truth : {MakeSphere(4), MakeField(4)}) {
    const double dimension = truth.space == PoseGraphSpace::kSe2 ? 3.0 : 6.0;
    const double freedom =
        dimension * static_cast<double>(truth.edges.size() + 1 - truth.nodes.size());
    PoseGraph reference = truth;
    const double chi2 = SolvePoseGraph(&reference).final_chi2;
    // Five standard deviations of the chi-squared distribution.
    EXPECT_NEAR(chi2, freedom, 5.0 * std::sqrt(2.0 * freedom));
    for (const Initialization initialization : kAllComposed) {
      PoseGraph graph = Scrambled(truth);
      InitializePoseGraph(&graph, initialization);
      const PoseGraphSummary summary = SolvePoseGraph(&graph);
      EXPECT_NEAR(summary.final_chi2, chi2, 1e-5 * chi2);
      EXPECT_NEAR(Chi2(graph), summary.final_chi2, 1e-9 * chi2);
    }
  }
}

TEST(PoseGraph, FixedNodesKeepTheirPosesInEveryStep) {
  PoseGraph graph = MakeSphere(5);
  graph.nodes[30].fixed = graph.nodes[100].fixed = true;
  const PoseGraph before = graph;
  for (const Initialization initialization : kAllComposed) {
    InitializePoseGraph(&graph, initialization);
    SolvePoseGraph(&graph);
    for (const std::size_t n : {30u, 100u}) {
      EXPECT_EQ((graph.nodes[n].pose.p() - before.nodes[n].pose.p()).norm(), 0.0);
    }
    // The first node is not fixed.
    EXPECT_GT((graph.nodes[0].pose.p() - before.nodes[0].pose.p()).norm(), 1e-4);
    EXPECT_LT(Distance(graph, before), 1.0);
  }
}

TEST(PoseGraph, PiecesAreSolvedEachByItselfWithAWarning) {
  PoseGraph whole = MakeField(6), other = MakeField(7);
  const double separate = SolvePoseGraph(&whole).final_chi2 + SolvePoseGraph(&other).final_chi2;
  for (PoseGraphNode& node : other.nodes) node.id += 1000;
  for (PoseGraphEdge& edge : other.edges) edge.i += 1000, edge.j += 1000;
  PoseGraph both = whole;
  both.nodes.insert(both.nodes.end(), other.nodes.begin(), other.nodes.end());
  both.nodes.push_back({5000, Pose()});  // has no edges
  both.edges.insert(both.edges.end(), other.edges.begin(), other.edges.end());
  for (const RobustLoops robust : {RobustLoops::kNone, RobustLoops::kGnc}) {
    PoseGraph graph = both;
    InitializePoseGraph(&graph, Initialization::kChordal);
    const PoseGraphSummary summary = SolvePoseGraph(&graph, {.robust = robust});
    EXPECT_EQ(summary.status, SolveStatus::kConverged);
    EXPECT_EQ(summary.components, 3);
    ASSERT_EQ(summary.warnings.size(), 1u);
    EXPECT_NE(summary.warnings[0].find("3 pieces"), std::string::npos);
    EXPECT_NEAR(summary.final_chi2, separate, 1e-5 * separate);
  }
}

TEST(PoseGraph, RobustMethodsFindFalseLoopsAndKeepTrueOnes) {
  for (const PoseGraph& truth : {MakeSphere(8), MakeField(8)}) {
    PoseGraph clean = truth;
    const double clean_chi2 = SolvePoseGraph(&clean).final_chi2;
    for (const RobustLoops robust :
         {RobustLoops::kGnc, RobustLoops::kDcs, RobustLoops::kSwitchable}) {
      PoseGraph graph = truth;
      const auto places = AddFalseLoops(0.3, FalseLoopKind::kRandom, 9, &graph);
      InitializePoseGraph(&graph, Initialization::kChordal);
      const PoseGraphSummary summary = SolvePoseGraph(&graph, {.robust = robust});
      std::size_t false_rejected = 0;
      for (const RejectedLoop& loop : summary.rejected) {
        false_rejected += loop.edge >= places.front();
        EXPECT_LT(loop.weight, 0.5);
        EXPECT_GT(loop.chi2, 16.0);
        EXPECT_NE(loop.reason.find("exceeds"), std::string::npos);
      }
      EXPECT_EQ(false_rejected, places.size()) << static_cast<int>(robust);
      EXPECT_LE(summary.rejected.size() - false_rejected, CountLoops(truth) / 100);
      graph.edges.resize(places.front());
      EXPECT_NEAR(Chi2(graph), clean_chi2, 0.05 * clean_chi2) << static_cast<int>(robust);
      EXPECT_NEAR(summary.final_chi2, clean_chi2, 0.05 * clean_chi2);
    }
  }
}

TEST(PoseGraph, WithoutARobustMethodFalseLoopsBendTheGraph) {
  PoseGraph truth = MakeSphere(8), graph = truth;
  AddFalseLoops(0.3, FalseLoopKind::kRandom, 9, &graph);
  const PoseGraphSummary summary = SolvePoseGraph(&graph);
  EXPECT_TRUE(summary.rejected.empty());
  EXPECT_GT(Distance(graph, truth), 1.0);
}

TEST(PoseGraph, ASingleTrueLoopAfterLongDriftIsKept) {
  // No other constraint confirms the loop, but the uncertainty of the odometry makes it plausible.
  for (const RobustLoops robust :
       {RobustLoops::kGnc, RobustLoops::kDcs, RobustLoops::kSwitchable}) {
    PoseGraph graph = MakeSphere(10);
    const auto loop = std::find_if(graph.edges.begin(), graph.edges.end(),
                                   [](const auto& e) { return e.IsLoop(); });
    graph.edges.erase(loop + 1, graph.edges.end());
    InitializePoseGraph(&graph, Initialization::kOdometry);
    EXPECT_GT(EdgeChi2(graph).back(), 22.46);
    EXPECT_TRUE(SolvePoseGraph(&graph, {.robust = robust}).rejected.empty());
  }
}

// Replaces the id of every node, in nodes and edges.
template <class NewId>
PoseGraph Renumbered(PoseGraph graph, const NewId& new_id) {
  for (PoseGraphNode& node : graph.nodes) node.id = new_id(node.id);
  for (PoseGraphEdge& edge : graph.edges) edge.i = new_id(edge.i), edge.j = new_id(edge.j);
  return graph;
}

TEST(PoseGraph, IdsWithGapsKeepTheirOdometry) {
  PoseGraph whole = MakeSphere(8);
  AddFalseLoops(0.3, FalseLoopKind::kRandom, 9, &whole);
  PoseGraph gaps = Renumbered(whole, [](std::int64_t id) { return 10 * id + 3; });
  EXPECT_EQ(CountLoops(gaps), CountLoops(whole));
  std::vector<PoseGraphSummary> summaries;
  for (PoseGraph* graph : {&whole, &gaps}) {
    InitializePoseGraph(graph, Initialization::kOdometry);
    summaries.push_back(SolvePoseGraph(graph, {.robust = RobustLoops::kGnc}));
  }
  EXPECT_EQ(Distance(whole, gaps), 0.0);
  ASSERT_EQ(summaries[0].rejected.size(), summaries[1].rejected.size());
  EXPECT_GT(summaries[0].rejected.size(), 0u);
  for (std::size_t k = 0; k < summaries[0].rejected.size(); ++k) {
    EXPECT_EQ(summaries[0].rejected[k].edge, summaries[1].rejected[k].edge);
  }
}

TEST(PoseGraph, InterleavedIdsOfTwoMotionsKeepTheirOdometry) {
  // Nodes of the second half get the odd ids, so that neighbours in id are of different motions.
  PoseGraph whole = MakeSphere(8);
  const auto half = static_cast<std::int64_t>(whole.nodes.size()) / 2;
  std::erase_if(whole.edges,
                [&](const PoseGraphEdge& edge) { return edge.IsOdometry() && edge.i == half - 1; });
  AddFalseLoops(0.3, FalseLoopKind::kRandom, 9, &whole);
  PoseGraph mixed =
      Renumbered(whole, [&](std::int64_t id) { return id < half ? 2 * id : 2 * (id - half) + 1; });
  const auto summary = SolvePoseGraph(&whole, {.robust = RobustLoops::kGnc});
  const auto mixed_summary = SolvePoseGraph(&mixed, {.robust = RobustLoops::kGnc});
  // The ids are the same up to their order, in which sums of the solver round differently.
  EXPECT_LT(Distance(whole, mixed), 1e-12);
  EXPECT_EQ(summary.rejected.size(), mixed_summary.rejected.size());
}

TEST(PoseGraph, TwoSessionsNumberedThroughDoNotBecomeOne) {
  // Three poses each; a false loop joins the last of the first session and the first of the second,
  // two true ones put the second session 10 m beside the first.
  const auto at = [](double x, double y) {
    return Pose(Eigen::Quaterniond::Identity(), {x, y, 0});
  };
  PoseGraph graph;
  for (int i = 0; i < 6; ++i) graph.nodes.push_back({i, at(i % 3, i < 3 ? 0.0 : 10.0)});
  const PoseInformation information = 100.0 * PoseInformation::Identity(6, 6);
  for (const std::int64_t i : {0, 1, 3, 4}) {
    graph.edges.push_back({i, i + 1, PoseGraphEdgeKind::kOdometry, at(1, 0), information});
  }
  for (const std::int64_t i : {0, 1}) {
    graph.edges.push_back({i, i + 3, PoseGraphEdgeKind::kLoop, at(0, 10), information});
  }
  graph.edges.push_back({2, 3, PoseGraphEdgeKind::kLoop, at(1, 0), information});
  EXPECT_FALSE(graph.edges.back().IsOdometry());
  EXPECT_TRUE(graph.edges.back().IsLoop());
  const PoseGraphSummary summary = SolvePoseGraph(&graph, {.robust = RobustLoops::kGnc});
  ASSERT_EQ(summary.rejected.size(), 1u);
  EXPECT_EQ(summary.rejected[0].edge, graph.edges.size() - 1);
  EXPECT_NEAR(graph.nodes[3].pose.p().y(), 10.0, 1e-6);
}

// A straight walk in which each node has edges to the next one and the one after it that agree with
// the poses, and an edge to a fixed node with almost no information. The last edge is a loop over
// the whole walk with an error of `metres`.
PoseGraph MakePresentWalk(double metres) {
  constexpr int kNodes = 200;
  PoseGraph graph;
  const auto tie = [&](std::int64_t i, std::int64_t j, double sigma) {
    const auto kind = j == i + 1 ? PoseGraphEdgeKind::kOdometry : PoseGraphEdgeKind::kLoop;
    const auto& pose = [&](std::int64_t id) {
      return graph.nodes[static_cast<std::size_t>(id)].pose;
    };
    graph.edges.push_back({i, j, kind, pose(i).Inverse() * pose(j),
                           Eigen::Matrix<double, 6, 6>::Identity() / (sigma * sigma)});
    graph.edges.back().trusted = true;
  };
  for (int i = 0; i <= kNodes; ++i) {
    graph.nodes.push_back({i, Pose(Eigen::Quaterniond::Identity(), {0.25 * i, 0.0, 0.0})});
  }
  graph.nodes.back().fixed = true;
  for (int i = 1; i < kNodes; ++i) {
    tie(i - 1, i, 0.01);
    if (i > 1) tie(i - 2, i, 0.01);
  }
  for (int i = 0; i < kNodes - 1; ++i) tie(kNodes, i, 1e3);
  tie(0, kNodes - 1, 0.01);
  graph.edges.back().trusted = false;
  graph.edges.back().Z =
      graph.edges.back().Z * Pose(Eigen::Quaterniond::Identity(), {0, metres, 0});
  return graph;
}

TEST(PoseGraph, TheFitOfTrustedEdgesIsNoEvidenceAboutALoop) {
  for (const RobustLoops robust :
       {RobustLoops::kGnc, RobustLoops::kDcs, RobustLoops::kSwitchable}) {
    // The rotation uncertainty of the path gives its end a lateral uncertainty of 4 m.
    PoseGraph graph = MakePresentWalk(5.0);
    EXPECT_EQ(CountLoops(graph), 1u);
    const PoseGraphOptions options{.robust = robust, .estimate_variance_factor = false};
    EXPECT_TRUE(SolvePoseGraph(&graph, options).rejected.empty());
  }
}

TEST(PoseGraph, ANodeWithoutInformationMakesNoLoopPlausible) {
  for (const bool estimate : {false, true}) {
    PoseGraph graph = MakePresentWalk(50.0);
    const PoseGraphSummary summary =
        SolvePoseGraph(&graph, {.robust = RobustLoops::kGnc, .estimate_variance_factor = estimate});
    ASSERT_EQ(summary.rejected.size(), 1u);
    EXPECT_EQ(summary.rejected[0].edge, graph.edges.size() - 1);
  }
}

TEST(PoseGraph, TheThresholdOfLoopsIsAnOption) {
  PoseGraph graph = MakeSphere(11);
  InitializePoseGraph(&graph, Initialization::kChordal);
  PoseGraph strict = graph;
  EXPECT_TRUE(SolvePoseGraph(&graph, {.robust = RobustLoops::kGnc}).rejected.empty());
  const PoseGraphSummary summary =
      SolvePoseGraph(&strict, {.robust = RobustLoops::kGnc, .max_loop_chi2 = 5.0});
  EXPECT_GT(summary.rejected.size(), 5u);
  EXPECT_LT(summary.rejected.size(), CountLoops(strict));
  for (const RejectedLoop& loop : summary.rejected) EXPECT_GT(loop.chi2, 5.0);
}

TEST(PoseGraph, CovarianceOfAChainIsTheSumOfItsSteps) {
  PoseGraph chain = MakeField(12, 0.0, 1);  // straight along x
  const std::int64_t ids[] = {2, 0};
  const Eigen::MatrixXd covariance = *PoseGraphCovariance(chain, ids);
  ASSERT_EQ(covariance.rows(), 6);
  // Two steps of 1 m: the rotation error of the first one moves the second one sideways.
  const double p2 = 0.05 * 0.05, a2 = 0.02 * 0.02;
  Eigen::Matrix3d expected;
  expected << 2 * p2, 0, 0, 0, 2 * p2 + a2, a2, 0, a2, 2 * a2;
  EXPECT_TRUE((covariance.topLeftCorner<3, 3>().isApprox(expected, 1e-9))) << covariance;
  EXPECT_EQ(covariance.bottomRightCorner(3, 3).norm(), 0.0) << "the first node is known";
}

TEST(PoseGraph, CovarianceShrinksByLoopsAndCanLeaveThemOut) {
  PoseGraph graph = MakeSphere(13);
  const std::int64_t ids[] = {159};
  const Eigen::MatrixXd with = *PoseGraphCovariance(graph, ids);
  std::vector<std::size_t> loops;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (graph.edges[e].IsLoop()) loops.push_back(e);
  }
  const Eigen::MatrixXd without = *PoseGraphCovariance(graph, ids, loops);
  ASSERT_EQ(with.rows(), 6);
  EXPECT_GT(without.trace(), 5.0 * with.trace());
  const std::size_t last_step[] = {158};
  EXPECT_TRUE(PoseGraphCovariance(graph, ids, last_step));
  std::vector<std::size_t> all(graph.edges.size());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_FALSE(PoseGraphCovariance(graph, ids, all)) << "nothing determines the node";
}

TEST(PoseGraph, CovarianceRefusesNodesEdgesAndPosesThatAreNotThere) {
  PoseGraph graph = MakeSphere(13);
  const std::int64_t ids[] = {159}, unknown[] = {4711};
  const std::size_t beyond[] = {graph.edges.size()};
  EXPECT_THROW(PoseGraphCovariance(graph, unknown), InvalidArgument);
  EXPECT_THROW(PoseGraphCovariance(graph, ids, beyond), InvalidArgument);
  graph.has_poses = false;
  EXPECT_THROW(PoseGraphCovariance(graph, ids), InvalidArgument);
}

// A chain of nodes whose odometry rotates a little too much at each step, with factors that fix the
// positions in a separate frame.
TEST(PoseGraph, FactorsOnNodesConstrainAFrameThatNoEdgeReaches) {
  const Pose step = Pose::FromTangent({1, 0, 0}, {0, 0, 0.05});
  const Pose drifted = Pose::FromTangent({1.02, 0, 0}, {0, 0, 0.055});
  const Pose T_GW = Pose::FromTangent({100, -50, 7}, {0, 0, 2.0});
  constexpr std::int64_t kFrame = 100;
  PoseGraph graph;
  std::vector<Pose> truth = {Pose()};
  graph.nodes.push_back({0, Pose(), true});
  for (std::int64_t i = 1; i <= 30; ++i) {
    truth.push_back(truth.back() * step);
    graph.nodes.push_back({i, graph.nodes.back().pose * drifted});
    graph.edges.push_back(
        {i - 1, i, PoseGraphEdgeKind::kOdometry, drifted, 1e4 * PoseInformation::Identity(6, 6)});
  }
  graph.nodes.push_back({kFrame, T_GW * Pose::FromTangent({1, 1, 1}, {0.05, 0.02, 0.1})});
  for (std::size_t i = 0; i < truth.size(); ++i) {
    graph.factors.push_back({{static_cast<std::int64_t>(i), kFrame},
                             testing::PositionInFrame(T_GW * truth[i].p(), 1e-3)});
  }
  const PoseGraphSummary summary = SolvePoseGraph(&graph);
  EXPECT_EQ(summary.components, 1);
  EXPECT_TRUE(summary.warnings.empty());
  const Pose& solved = graph.nodes.back().pose;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // Only the frame has absolute information: the odometry drift is 0.6 m along the path and 9
    // degrees, and the positions are known to 1 mm.
    EXPECT_LT((solved * graph.nodes[i].pose.p() - T_GW * truth[i].p()).norm(), 3e-3) << i;
  }
  // The first node is fixed, and the others determine its heading by odometry of 0.01 rad a step.
  EXPECT_LT((solved.Inverse() * T_GW).Angle(), 0.01);

  const std::int64_t last[] = {30};
  const auto uncertainty = [&] {
    return std::sqrt(PoseGraphCovariance(graph, last)->topLeftCorner(3, 3).trace());
  };
  graph.nodes.front().fixed = false;
  graph.nodes.back().fixed = true;
  EXPECT_LT(uncertainty(), 2e-3);
  graph.factors.clear();
  graph.nodes.pop_back();
  EXPECT_GT(uncertainty(), 0.1);
}

TEST(PoseGraph, BadFactorsAreRefused) {
  PoseGraph graph;
  graph.nodes = {{0, Pose(), true}, {1, Pose()}};
  graph.edges = {{0, 1, PoseGraphEdgeKind::kOdometry, Pose(), PoseInformation::Identity(6, 6)}};
  const auto cost = testing::PositionInFrame(Eigen::Vector3d::Zero(), 1.0);
  graph.factors = {{{0, 7}, cost}};
  ExpectInvalid(graph, "node 7 is not there");
  graph.factors = {{{0, 1}, nullptr}};
  ExpectInvalid(graph, "a factor has no cost");
  graph.factors = {{{0, 1}, cost}};
  EXPECT_THROW(InitializePoseGraph(&graph, Initialization::kChordal), InvalidArgument);
  EXPECT_NO_THROW(graph.Validate());
}

TEST(PoseGraph, ProgressIsReportedAndAStopIsHeeded) {
  PoseGraph graph = MakeSphere(14);
  InitializePoseGraph(&graph, Initialization::kOdometry);
  std::vector<PoseGraphProgress> seen;
  std::atomic<bool> stop = false;
  PoseGraphOptions options{.robust = RobustLoops::kGnc};
  options.on_progress = [&](const PoseGraphProgress& progress) {
    seen.push_back(progress);
    stop = seen.size() == 2;
  };
  options.solver.stop = &stop;
  const PoseGraphSummary summary = SolvePoseGraph(&graph, options);
  EXPECT_EQ(summary.status, SolveStatus::kStopped);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_LT(seen[1].chi2, seen[0].chi2);
}

TEST(PoseGraph, ProgressBeginsAndEndsAtTheChi2OfTheSummary) {
  PoseGraph graph = MakeSphere(14);
  InitializePoseGraph(&graph, Initialization::kOdometry);
  std::vector<PoseGraphProgress> seen;
  PoseGraphOptions options;
  options.on_progress = [&](const PoseGraphProgress& progress) { seen.push_back(progress); };
  const PoseGraphSummary summary = SolvePoseGraph(&graph, options);
  ASSERT_EQ(summary.status, SolveStatus::kConverged) << summary.message;
  ASSERT_GT(seen.size(), 2u);
  EXPECT_NEAR(seen.front().chi2, summary.initial_chi2, 1e-9 * summary.initial_chi2);
  EXPECT_NEAR(seen.back().chi2, summary.final_chi2, 1e-6 * summary.final_chi2);
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i].iterations, static_cast<int>(i));
}

TEST(PoseGraph, BadGraphsAreRefusedByName) {
  const PoseGraph good = MakeSphere(15);
  PoseGraph bad;
  ExpectInvalid(bad, "no edges");
  bad = good;
  bad.edges.clear();
  ExpectInvalid(bad, "no edges");
  bad = good;
  bad.nodes[7].id = 6;
  ExpectInvalid(bad, "node 6 is there twice");
  bad = good;
  bad.nodes[7].id = -7;
  ExpectInvalid(bad, "node id -7 is negative");
  bad = good;
  bad.edges[3].j = 4711;
  ExpectInvalid(bad, "node 4711 is not there");
  bad = good;
  bad.edges[3].j = bad.edges[3].i;
  ExpectInvalid(bad, "to itself");
  bad = good;
  bad.nodes[5].pose.data()[1] = std::numeric_limits<double>::quiet_NaN();
  ExpectInvalid(bad, "node 5 has a pose that is not finite");
  bad = good;
  bad.edges[5].Z.data()[1] = std::numeric_limits<double>::infinity();
  ExpectInvalid(bad, "edge 5 6 has a pose that is not finite");
  bad = good;
  bad.edges[5].information(2, 2) = -1.0;
  ExpectInvalid(bad, "edge 5 6 has an information matrix that is not positive definite");
  bad.edges[5].information(2, 2) = std::numeric_limits<double>::quiet_NaN();
  ExpectInvalid(bad, "not finite");
  bad = good;
  bad.edges[5].information(0, 1) = 1.0;
  ExpectInvalid(bad, "not symmetric");
  bad = good;
  bad.edges[5].information = Eigen::Matrix3d::Identity();
  ExpectInvalid(bad, "wrong size");
  bad = MakeField(15);
  bad.nodes[5].pose.data()[2] = 0.1;
  ExpectInvalid(bad, "node 5 has a pose that leaves the plane");
}

TEST(PoseGraph, AGraphWithoutPosesMustBeInitializedFirst) {
  PoseGraph graph = MakeSphere(16);
  graph.has_poses = false;
  EXPECT_THROW(SolvePoseGraph(&graph), InvalidArgument);
  EXPECT_THROW(InitializePoseGraph(&graph, Initialization::kGiven), InvalidArgument);
  InitializePoseGraph(&graph, Initialization::kTree);
  EXPECT_NO_THROW(InitializePoseGraph(&graph, Initialization::kGiven));
  EXPECT_THROW(SolvePoseGraph(&graph, {.max_loop_chi2 = -1.0}), InvalidArgument);
}

TEST(PoseGraph, NothingMovesWhereEverythingIsFixed) {
  for (PoseGraph graph : {MakeSphere(17), MakeField(17)}) {
    for (PoseGraphNode& node : graph.nodes) node.fixed = true;
    const PoseGraph before = graph;
    for (const Initialization initialization : kAllComposed) {
      InitializePoseGraph(&graph, initialization);
      for (const RobustLoops robust : {RobustLoops::kNone, RobustLoops::kGnc, RobustLoops::kDcs}) {
        const PoseGraphSummary summary = SolvePoseGraph(&graph, {.robust = robust});
        EXPECT_NE(summary.status, SolveStatus::kFailed) << summary.message;
        EXPECT_GE(summary.iterations, 0);
        EXPECT_EQ(Distance(graph, before), 0.0);
      }
    }
  }
}

}  // namespace
}  // namespace highwall::pose_graph_test
