#include <highwall/core/pose_graph.h>

#include <filesystem>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/internal/se3.h>

#include "support/pose_graph_scenes.h"
#include "support/temporary_directory.h"

namespace highwall::g2o_io_test {
namespace {

namespace fs = std::filesystem;

const std::string kVertices =
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 1 1 2 3 0 0 0.6 0.8\n";
const std::string kEdge =
    "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1 "
    "11 1 2 3 4 5 12 0 0 0 0 13 0 0 0 14 0 0 15 0 16\n";
const std::string kPlanar =
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 2 3\nEDGE_SE2 0 1 1 2 3 11 1 2 12 3 13\n";

const std::string kDiagonal = "1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6\n";

class G2oFile : public ::testing::Test {
 protected:
  PoseGraph Read(const std::string& text) const {
    testing::WriteText(folder_ / "graph.g2o", text);
    return ReadG2o(folder_ / "graph.g2o");
  }
  void ExpectError(const std::string& text, const std::string& message) const {
    try {
      Read(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const IoError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("graph.g2o" + message), std::string::npos) << what;
      EXPECT_EQ(what.find('\n'), std::string::npos);
    }
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(G2oFile, HoldsVerticesAndEdgesOfSpace) {
  const PoseGraph graph = Read(kVertices + kEdge + "FIX 1\n");
  EXPECT_EQ(graph.space, PoseGraphSpace::kSe3);
  EXPECT_TRUE(graph.has_poses);
  ASSERT_EQ(graph.nodes.size(), 2u);
  EXPECT_FALSE(graph.nodes[0].fixed);
  EXPECT_TRUE(graph.nodes[1].fixed);
  EXPECT_EQ(graph.nodes[1].pose.p(), Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(graph.nodes[1].pose.q().z(), 0.6, 1e-15);
  ASSERT_EQ(graph.edges.size(), 1u);
  const PoseInformation& information = graph.edges[0].information;
  ASSERT_EQ(information.rows(), 6);
  EXPECT_TRUE(information.isApprox(information.transpose()));
  for (int k = 0; k < 6; ++k) EXPECT_EQ(information(k, k), 11.0 + k);
  for (int k = 1; k < 6; ++k) EXPECT_EQ(information(0, k), k);
}

TEST_F(G2oFile, HoldsVerticesAndEdgesOfThePlane) {
  const PoseGraph graph = Read(kPlanar);
  EXPECT_EQ(graph.space, PoseGraphSpace::kSe2);
  EXPECT_EQ(graph.nodes[1].pose.p(), Eigen::Vector3d(1, 2, 0));
  EXPECT_NEAR(graph.nodes[1].pose.Angle(), 3.0, 1e-15);
  Eigen::Matrix3d expected;
  expected << 11, 1, 2, 1, 12, 3, 2, 3, 13;
  EXPECT_EQ(Eigen::Matrix3d(graph.edges[0].information), expected);
}

TEST_F(G2oFile, MayBeWrittenInManyWays) {
  const PoseGraph graph = Read(
      "# a comment\r\n\r\n   \t\nFIX 7 3 # both\r\n"
      "EDGE_SE2 7 3   +1.5 -2e0 3.0e-1\t1 0 0 1 0 1   \r\n"
      "PARAMS_SE2OFFSET 0 0 0 0\n"
      "VERTEX_SE2 3 0 0 1e-400\nVERTEX_SE2 7 1 1 1");
  ASSERT_EQ(graph.nodes.size(), 2u);
  EXPECT_EQ(graph.nodes[0].id, 3);
  EXPECT_TRUE(graph.nodes[0].fixed && graph.nodes[1].fixed);
  EXPECT_EQ(graph.edges[0].i, 7);
  EXPECT_EQ(graph.edges[0].Z.p(), Eigen::Vector3d(1.5, -2, 0));
}

TEST_F(G2oFile, WithoutVerticesNamesNodesByItsEdges) {
  const PoseGraph graph =
      Read("EDGE_SE2 9 2 1 2 3 1 0 0 1 0 1\nEDGE_SE2 2 5 1 2 3 1 0 0 1 0 1\nFIX 5");
  EXPECT_FALSE(graph.has_poses);
  ASSERT_EQ(graph.nodes.size(), 3u);
  EXPECT_EQ(graph.nodes[0].id, 2);
  EXPECT_EQ(graph.nodes[1].id, 5);
  EXPECT_EQ(graph.nodes[2].id, 9);
  EXPECT_TRUE(graph.nodes[1].fixed);
}

TEST_F(G2oFile, QuaternionsAreNormalised) {
  const PoseGraph graph =
      Read("VERTEX_SE3:QUAT 0 0 0 0 0 0 0.999902 0.0108\n" + kVertices.substr(32) + kEdge);
  EXPECT_NEAR(graph.nodes[0].pose.q().norm(), 1.0, 1e-15);
}

TEST_F(G2oFile, ComesBackEqualAfterWriting) {
  for (PoseGraph graph : {MakeSphere(1), MakeField(1)}) {
    graph.nodes[4].fixed = true;
    WriteG2o(folder_ / "graph.g2o", graph);
    const PoseGraph back = ReadG2o(folder_ / "graph.g2o");
    EXPECT_EQ(back.space, graph.space);
    ASSERT_EQ(back.nodes.size(), graph.nodes.size());
    ASSERT_EQ(back.edges.size(), graph.edges.size());
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      EXPECT_EQ(back.nodes[n].id, graph.nodes[n].id);
      EXPECT_EQ(back.nodes[n].fixed, n == 4);
      EXPECT_EQ(back.nodes[n].pose.p(), graph.nodes[n].pose.p());
      EXPECT_LT((back.nodes[n].pose.Inverse() * graph.nodes[n].pose).Angle(), 1e-15);
    }
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      EXPECT_EQ(back.edges[e].i, graph.edges[e].i);
      EXPECT_EQ(back.edges[e].information, graph.edges[e].information);
      EXPECT_LT((back.edges[e].Z.Inverse() * graph.edges[e].Z).Angle(), 1e-15);
    }
  }
}

TEST_F(G2oFile, MalformedLinesAreNamed) {
  ExpectError(kVertices + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0\n" + kEdge, ":3: VERTEX_SE3:QUAT needs 7");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0 1 5\n",
              ":3: VERTEX_SE3:QUAT has more than 7");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 2 0 nan 0 0 0 0 1\n",
              ":3: VERTEX_SE3:QUAT: 'nan' is not a finite");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 2 0 1e999 0 0 0 0 1\n", ":3: VERTEX_SE3:QUAT: '1e999'");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 2 0 1,5 0 0 0 0 1\n", ":3: VERTEX_SE3:QUAT: '1,5'");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0 0\n", ":3: the quaternion");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0 64e222\n", ":3: the quaternion");
  ExpectError(kVertices + "VERTEX_SE3:QUAT two 0 0 0 0 0 0 1\n",
              ":3: VERTEX_SE3:QUAT: 'two' is no id");
  ExpectError(kVertices + "VERTEX_SE3:QUAT -2 0 0 0 0 0 0 1\n",
              ":3: VERTEX_SE3:QUAT: '-2' is no id");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 99999999999999999999 0 0 0 0 0 0 1\n",
              ":3: VERTEX_SE3:QUAT: '9999");
  ExpectError(kVertices + "VERTEX_SE3:QUAT\n", ":3: VERTEX_SE3:QUAT lacks an id");
  ExpectError(kVertices + "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\n", ":3: vertex 1 is there twice");
  ExpectError(kVertices + "VERTEX_XY 2 0 0\n", ":3: 'VERTEX_XY' is not understood");
  ExpectError(kVertices + kPlanar, ":3: SE(2) and SE(3) are mixed");
  ExpectError(kVertices + kEdge.substr(0, 40) + "\n", ":3: EDGE_SE3:QUAT needs 28");
  ExpectError(kVertices + "EDGE_SE3:QUAT 1 1" + kEdge.substr(17),
              ":3: edge from vertex 1 to itself");
  ExpectError(kVertices + "FIX\n", ":3: FIX lacks an id");
}

TEST_F(G2oFile, EdgesAndFixesOfMissingVerticesAreNamedByTheirLines) {
  ExpectError(kEdge + kVertices.substr(0, 32), ":1: edge to vertex 1, which is not there");
  ExpectError(kVertices + kEdge + "FIX 4711\n", ":4: FIX of vertex 4711, which is not there");
}

TEST_F(G2oFile, InformationMustNotBeNegative) {
  ExpectError("\nEDGE_SE2 0 1 1 2 3 1 2 0 1 0 1\n", ":2: the information matrix is not positive");
  ExpectError("EDGE_SE2 0 1 1 2 3 1 0 0 -1e-6 0 1\n", ":1: the information matrix is not positive");
  EXPECT_EQ(Read("EDGE_SE2 0 1 1 2 3 1 0 0 0 0 1\n").edges[0].information(1, 1), 0.0);
  EXPECT_TRUE(Read("EDGE_SE2 0 1 1 2 3 0 0 0 0 0 0\n").edges[0].information.isZero(0.0));
}

TEST_F(G2oFile, MayBeginWithAByteOrderMark) {
  EXPECT_EQ(Read("\xef\xbb\xbf" + kVertices + kEdge).nodes.size(), 2u);
}

TEST_F(G2oFile, EdgesBetweenConsecutiveIdsAreReadAsOdometry) {
  const std::string rest = " 1 0 0 1 0 0 1 0 1\n";
  const PoseGraph graph =
      Read("EDGE_SE2 4 5" + rest + "EDGE_SE2 6 5" + rest + "EDGE_SE2 4 6" + rest);
  ASSERT_EQ(graph.edges.size(), 3u);
  EXPECT_EQ(graph.edges[0].kind, PoseGraphEdgeKind::kOdometry);
  EXPECT_EQ(graph.edges[1].kind, PoseGraphEdgeKind::kOdometry);
  EXPECT_EQ(graph.edges[2].kind, PoseGraphEdgeKind::kLoop);
}

TEST_F(G2oFile, PriorsAreTrustedEdgesFromTheWorld) {
  const std::string prior = "EDGE_SE3_PRIOR 1 0 4 5 6 0 0 0.6 0.8 " + kDiagonal;
  const PoseGraph graph = Read(kVertices + kEdge + prior);
  ASSERT_TRUE(graph.world);
  ASSERT_EQ(graph.nodes.size(), 3u);
  EXPECT_EQ(graph.nodes[2].id, *graph.world);
  EXPECT_TRUE(graph.nodes[2].fixed);
  EXPECT_TRUE(graph.nodes[2].pose.Matrix().isIdentity(0.0));
  ASSERT_EQ(graph.edges.size(), 2u);
  EXPECT_EQ(graph.edges[1].i, *graph.world);
  EXPECT_EQ(graph.edges[1].j, 1);
  EXPECT_FALSE(graph.edges[1].IsLoop());
  EXPECT_FALSE(graph.edges[1].IsOdometry());
  EXPECT_EQ(graph.edges[1].Z.p(), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(graph.edges[1].information(3, 3), 4.0);

  WriteG2o(folder_ / "again.g2o", graph);
  const PoseGraph again = ReadG2o(folder_ / "again.g2o");
  EXPECT_EQ(again.nodes.size(), 3u);
  EXPECT_EQ(again.world, graph.world);
  EXPECT_EQ(again.edges[1].information, graph.edges[1].information);
  EXPECT_TRUE(again.edges[1].Z.Matrix().isApprox(graph.edges[1].Z.Matrix(), 1e-15));

  ExpectError(kVertices + kEdge + "EDGE_SE3_PRIOR 7 0 4 5 6 0 0 0 1 " + kDiagonal,
              ":4: prior of vertex 7, which is not there");
  ExpectError(kVertices + "EDGE_SE3_PRIOR 1 0 4 5 6 0 0 0 1 1\n", ":3: EDGE_SE3_PRIOR needs 28");
  ExpectError(kPlanar + "EDGE_SE3_PRIOR 1 0 4 5 6 0 0 0 1 " + kDiagonal, ":4: SE(2) and SE(3)");
}

// r = Log(Z^-1 T P) of the pose T of the vertex and the offset P of the sensor.
TEST_F(G2oFile, PriorsOfASensorBesideTheBodyHaveItsError) {
  const PoseGraph graph =
      Read(kVertices +
           "EDGE_SE3_PRIOR 1 3 4 5 6 0.1 0.2 0.3 0.9 11 1 2 3 4 5 12 0 0 0 0 13 "
           "0 0 0 14 0 0 15 0 16\n"
           "PARAMS_SE3OFFSET 3 0.5 -1 2 0.3 0 0 1\n");
  const Pose P(Eigen::Quaterniond(1, 0.3, 0, 0), {0.5, -1, 2});
  const Pose Z(Eigen::Quaterniond(0.9, 0.1, 0.2, 0.3), {4, 5, 6});
  const se3::Tangent r = se3::Log(Z.Inverse() * graph.nodes[1].pose * P);
  const PoseInformation information = Read(kVertices + kEdge).edges[0].information;
  EXPECT_NEAR(EdgeChi2(graph)[0], r.dot(information * r), 1e-10 * r.dot(information * r));
}

TEST_F(G2oFile, PriorsOfThePlaneAreReadAndWritten) {
  const PoseGraph graph = Read(kPlanar +
                               "EDGE_PRIOR_SE2 1 1 2 0.5 1 0 0 2 0 3\n"
                               "EDGE_PRIOR_SE2_XY 0 3 4 5 1 6\n");
  ASSERT_EQ(graph.edges.size(), 3u);
  EXPECT_EQ(graph.edges[2].Z.p(), Eigen::Vector3d(3, 4, 0));
  EXPECT_EQ(graph.edges[2].information,
            (Eigen::Matrix3d() << 5, 1, 0, 1, 6, 0, 0, 0, 0).finished());
  WriteG2o(folder_ / "again.g2o", graph);
  EXPECT_EQ(ReadG2o(folder_ / "again.g2o").edges[1].information, graph.edges[1].information);
  EXPECT_EQ(ReadG2o(folder_ / "again.g2o").world, graph.world);
}

TEST_F(G2oFile, WithoutAGraphIsRefused) {
  ExpectError("", ": holds no pose graph");
  ExpectError("# nothing\n\n", ": holds no pose graph");
  EXPECT_THROW(ReadG2o(folder_ / "none.g2o"), IoError);
  EXPECT_THROW(ReadG2o(folder_.path()), IoError);
  EXPECT_THROW(WriteG2o(folder_ / "no" / "graph.g2o", MakeField(1)), IoError);
}

TEST_F(G2oFile, ABadGraphIsNotWritten) {
  PoseGraph graph = MakeField(1);
  graph.nodes[1].id = 0;
  EXPECT_THROW(WriteG2o(folder_ / "graph.g2o", graph), InvalidArgument);
  EXPECT_FALSE(fs::exists(folder_ / "graph.g2o"));
}

}  // namespace
}  // namespace highwall::g2o_io_test
