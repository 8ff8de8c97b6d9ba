#include <algorithm>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/pose_graph.h>

#include "loops/keyframe_graph.h"
#include "support/id_literals.h"
#include "support/loop_scene.h"

namespace highwall::keyframe_graph_test {
namespace {

using testing::LoopScene;
using testing::operator""_kf;

class KeyFrameGraphTest : public ::testing::Test {
 protected:
  KeyFrameGraphTest() {
    for (int i = 0; i < 20; ++i) scene.Add(i);
  }
  Map& map() { return scene.map; }
  const MeasurementModel& model() const { return scene.model; }

  // Lets a keyframe and those after it share no landmark with those before it, and know their poses
  // to sigma [m], [rad].
  void WeakenFrom(KeyFrameId first, double sigma) {
    ForEachKind([&]<class Landmark>() {
      for (int i = 0; i < first.value(); ++i) {
        const KeyFrameId older(i);
        const LandmarkIds<Landmark> ids = PartOf<Landmark>(*map().keyframe(older));
        for (const Id<Landmark> id : ids) {
          const auto sees = [&](const Observation& o) { return o.keyframe >= first; };
          if (id != kNoId && std::ranges::any_of(map().Find<Landmark>(id)->observations, sees)) {
            map().Forget(older, id);
          }
        }
      }
    });
    for (const KeyFrameId id : {KeyFrameId(first.value() - 1), first}) {
      map().keyframe(id)->covariance =
          static_cast<float>(sigma * sigma) * Eigen::Matrix<float, 6, 6>::Identity();
    }
  }

  static constexpr KeyFrameGraphOptions kChain{.neighbours = 0};
  LoopScene scene{{}};
};

TEST_F(KeyFrameGraphTest, OdometryAndCovisibilityHoldTheMapAsItIs) {
  const KeyFrameGraph graph =
      MakeKeyFrameGraph(map(), model(), {}, {.min_shared = 20, .neighbours = 2});
  EXPECT_EQ(graph.graph.nodes.size(), 20u);
  EXPECT_TRUE(graph.graph.nodes[0].fixed);
  EXPECT_GT(graph.graph.edges.size(), 19u + 17u);
  EXPECT_LE(graph.graph.edges.size(), 3u * 19u);
  EXPECT_NO_THROW(graph.graph.Validate());
  EXPECT_LT(Chi2(graph.graph), 1e-12);  // rounding
  for (const PoseGraphEdge& edge : graph.graph.edges) EXPECT_FALSE(edge.IsLoop());
}

TEST_F(KeyFrameGraphTest, AGravityPriorIsNotALoop) {
  map().SetGravity(Eigen::Vector3d(0, 0, -9.81));
  const std::vector<LoopEdge> loops{{0_kf, 19_kf, Pose()}};
  const KeyFrameGraph graph = MakeKeyFrameGraph(map(), model(), loops);
  EXPECT_EQ(graph.graph.nodes.size(), 21u);
  std::size_t count = 0;
  for (const PoseGraphEdge& edge : graph.graph.edges) count += edge.IsLoop();
  EXPECT_EQ(count, 1u);
}

TEST_F(KeyFrameGraphTest, SeveralEdgesOfAKeyFrameShareTheInformationOfOne) {
  const KeyFrameGraphOptions alone{.neighbours = 0}, shared{.min_shared = 20, .neighbours = 1};
  const auto odometry = [&](const KeyFrameGraphOptions& options) {
    const KeyFrameGraph graph = MakeKeyFrameGraph(map(), model(), {}, options);
    double information = 0.0;
    for (const PoseGraphEdge& edge : graph.graph.edges) {
      if (edge.i == 9 && edge.j == 10) information = edge.information(0, 0);
    }
    return information;
  };
  EXPECT_NEAR(odometry(shared), odometry(alone) / 2.0, 1e-9 * odometry(alone));
}

TEST_F(KeyFrameGraphTest, NodesCountOnAcrossRemovedKeyFrames) {
  map().RemoveKeyFrame(5_kf, 4_kf);
  const std::vector<LoopEdge> loops{{0_kf, 19_kf, Pose()}, {5_kf, 19_kf, Pose()}};
  const KeyFrameGraph graph = MakeKeyFrameGraph(map(), model(), loops, {.neighbours = 0});
  EXPECT_EQ(graph.NodeOf(6_kf), 5);
  EXPECT_THROW(graph.NodeOf(5_kf), InvalidArgument);
  ASSERT_EQ(graph.loop_edges.size(), 2u);
  EXPECT_EQ(graph.graph.edges[graph.loop_edges[0]].j, 18);
  EXPECT_EQ(graph.graph.edges.size(), 18u + 2u);
}

TEST_F(KeyFrameGraphTest, ALoopOfRemovedKeyFramesConnectsTheirAnchors) {
  const auto T_WC = [&](KeyFrameId id) { return map().ResolvePose(id); };
  const LoopEdge loop{5_kf, 18_kf, T_WC(5_kf).Inverse() * T_WC(18_kf)};
  map().RemoveKeyFrame(5_kf, 4_kf);
  map().RemoveKeyFrame(4_kf, 3_kf);
  map().RemoveKeyFrame(18_kf, 19_kf);
  const std::vector<LoopEdge> loops{loop};
  const KeyFrameGraph graph = MakeKeyFrameGraph(map(), model(), loops, {.neighbours = 0});
  ASSERT_EQ(graph.loop_edges.size(), 1u);
  const PoseGraphEdge& edge = graph.graph.edges[graph.loop_edges[0]];
  EXPECT_EQ(edge.i, graph.NodeOf(3_kf));
  EXPECT_EQ(edge.j, graph.NodeOf(19_kf));
  const Pose expected = T_WC(3_kf).Inverse() * T_WC(19_kf);
  EXPECT_LT((edge.Z.p() - expected.p()).norm(), 1e-12);
  EXPECT_LT(edge.Z.q().angularDistance(expected.q()), 1e-7);
}

TEST_F(KeyFrameGraphTest, LeavesOutALoopBetweenKeyFramesThatOdometryNowConnects) {
  const std::vector<LoopEdge> loops{{5_kf, 7_kf, Pose()}, {5_kf, 8_kf, Pose()}};
  map().RemoveKeyFrame(5_kf, 6_kf);
  const KeyFrameGraph graph = MakeKeyFrameGraph(map(), model(), loops, {.neighbours = 0});
  ASSERT_EQ(graph.loop_edges.size(), 1u);
  EXPECT_EQ(graph.graph.edges[graph.loop_edges[0]].j, graph.NodeOf(8_kf));
}

TEST_F(KeyFrameGraphTest, JudgesALoopByThePathBetweenItsKeyFrames) {
  const Pose truth = map().keyframe(0_kf)->T_WC.Inverse() * map().keyframe(19_kf)->T_WC;
  const Pose off = truth * Pose::FromTangent({0.05, 0.0, 0.0}, {0.0, 0.0, 0.0});
  const double chi2 = *LoopChi2(MakeKeyFrameGraph(map(), model(), {}), {0_kf, 19_kf, off});
  EXPECT_LT(*LoopChi2(MakeKeyFrameGraph(map(), model(), {}), {0_kf, 19_kf, truth}), 1e-9);
  EXPECT_GT(chi2, 0.01);
  // An error twice as large has four times the chi-squared: the covariance does not depend on the
  // measurement.
  const Pose twice = truth * Pose::FromTangent({0.1, 0.0, 0.0}, {0.0, 0.0, 0.0});
  EXPECT_NEAR(*LoopChi2(MakeKeyFrameGraph(map(), model(), {}), {0_kf, 19_kf, twice}), 4.0 * chi2,
              1e-6 * chi2);
  // Less drift is possible over a shorter path.
  const Pose near = map().keyframe(15_kf)->T_WC.Inverse() * map().keyframe(19_kf)->T_WC *
                    Pose::FromTangent({0.05, 0.0, 0.0}, {0.0, 0.0, 0.0});
  EXPECT_GT(*LoopChi2(MakeKeyFrameGraph(map(), model(), {}), {15_kf, 19_kf, near}), 2.0 * chi2);
  // Nor is much drift possible where a loop has connected both ends before.
  const std::vector<LoopEdge> before{{0_kf, 19_kf, truth}};
  EXPECT_GT(*LoopChi2(MakeKeyFrameGraph(map(), model(), before), {0_kf, 19_kf, off}), 2.0 * chi2);
}

// Keyframe 10 shares no landmark with those before it, and its image knew little.
TEST_F(KeyFrameGraphTest, AWeakKeyFrameYieldsToALoopWhereTheOthersHold) {
  const Pose off = map().keyframe(0_kf)->T_WC.Inverse() * map().keyframe(19_kf)->T_WC *
                   Pose::FromTangent({0.3, 0.0, 0.0}, {0.0, 0.0, 0.0});
  const LoopEdge loop{0_kf, 19_kf, off};
  const double before = *LoopChi2(MakeKeyFrameGraph(map(), model(), {}, kChain), loop, kChain);
  WeakenFrom(10_kf, 0.2);
  KeyFrameGraph graph = MakeKeyFrameGraph(map(), model(), {}, kChain);
  EXPECT_LT(*LoopChi2(graph, loop, kChain), 0.25 * before);
  graph.Add(loop, kChain);
  ASSERT_TRUE(SolvePoseGraph(&graph.graph).status != SolveStatus::kFailed);
  const auto moved = [&](std::size_t i) {
    const Pose was =
        map().keyframe(KeyFrameId(i - 1))->T_WC.Inverse() * map().keyframe(KeyFrameId(i))->T_WC;
    const Pose is = graph.graph.nodes[i - 1].pose.Inverse() * graph.graph.nodes[i].pose;
    return (is.p() - was.p()).norm();
  };
  for (std::size_t i = 1; i < 20; ++i) {
    if (i != 10) {
      EXPECT_LT(moved(i), 0.1 * moved(10)) << i;
    }
  }
}

TEST_F(KeyFrameGraphTest, WhatAKeyFrameKnewOfItsPoseHoldsItWithoutCommonLandmarks) {
  WeakenFrom(10_kf, 0.002);
  // Along the optical axis of 9 alone; the axes of 10 are turned against them about y.
  Eigen::Matrix<float, 6, 6> along_z = 1e-10F * Eigen::Matrix<float, 6, 6>::Identity();
  along_z(2, 2) = 1e-4F;
  map().keyframe(9_kf)->covariance = along_z;
  const Eigen::Vector3d axis_10 =
      (map().keyframe(10_kf)->T_WC.Inverse() * map().keyframe(9_kf)->T_WC).R().col(2);
  ASSERT_LT(axis_10.z(), 0.995);
  const PoseCovariance covariance = RelativeCovariance(map(), model(), 9_kf, 10_kf);
  const Eigen::Matrix3d expected =
      4e-6 * Eigen::Matrix3d::Identity() + 1e-4 * axis_10 * axis_10.transpose();
  // The rotation of 9 to 1e-5 rad adds less, as do single precision and a metre of no information.
  EXPECT_LT((covariance.topLeftCorner<3, 3>() - expected).norm(), 1e-7);
  map().keyframe(9_kf)->covariance.reset();
  EXPECT_GT(RelativeCovariance(map(), model(), 9_kf, 10_kf)(0, 0), 0.9);  // no more is known
}

TEST_F(KeyFrameGraphTest, WhatAKeyFrameKnewOfItsPoseDoesNotReachAcrossASeam) {
  WeakenFrom(10_kf, 0.002);
  map().keyframe(10_kf)->submap = SubmapId(1);
  EXPECT_GT(RelativeCovariance(map(), model(), 9_kf, 10_kf)(0, 0), 0.9);
}

// Tracking is lost at 9, and found again at the place of 0 and 1.
TEST_F(KeyFrameGraphTest, WhatAKeyFrameKnewOfItsPoseDoesNotReachToWhereTrackingWasLost) {
  WeakenFrom(10_kf, 0.002);
  WeakenFrom(2_kf, 0.002);
  ASSERT_LT(RelativeCovariance(map(), model(), 9_kf, 10_kf)(0, 0), 1e-4);
  const LandmarkIds<MapPoint>& of_1 = map().keyframe(1_kf)->points;
  const auto free = std::ranges::find(of_1, PointId(kNoId));
  ASSERT_NE(free, of_1.end());
  map().Observe(1_kf, static_cast<int>(free - of_1.begin()), map().keyframe(10_kf)->points[0]);
  EXPECT_GT(RelativeCovariance(map(), model(), 9_kf, 10_kf)(0, 0), 0.9);
}

TEST_F(KeyFrameGraphTest, AWholeImageHoldsAKeyFrameWithoutCommonLandmarks) {
  WeakenFrom(10_kf, 10.0);
  ImageMotion motion;
  motion.reference = 8_kf;
  motion.sqrt_information = 100.0 * Eigen::Matrix<double, 6, 6>::Identity();
  map().keyframe(10_kf)->image_motion = motion;
  EXPECT_GT(RelativeCovariance(map(), model(), 9_kf, 10_kf)(0, 0), 0.9);
  // Its reference is replaced by 9.
  map().RemoveKeyFrame(8_kf, 9_kf);
  // Four times 1e-4: neighbouring pixels share errors as landmarks do.
  EXPECT_NEAR(RelativeCovariance(map(), model(), 9_kf, 10_kf)(0, 0), 4e-4, 1e-6);
}

TEST_F(KeyFrameGraphTest, ALoopWithAnOpenDirectionDoesNotHoldThere) {
  LoopEdge loop{0_kf, 19_kf,
                map().keyframe(0_kf)->T_WC.Inverse() * map().keyframe(19_kf)->T_WC *
                    Pose::FromTangent({0.5, 0.0, 0.0}, {0.0, 0.0, 0.0})};
  const KeyFrameGraph graph = MakeKeyFrameGraph(map(), model(), {});
  EXPECT_GT(*LoopChi2(graph, loop), 20.0);
  loop.covariance(0, 0) = 1.0;  // a metre: the error is half of it
  EXPECT_LT(*LoopChi2(graph, loop), 0.25);
}

TEST_F(KeyFrameGraphTest, NeedsTwoKeyFrames) {
  EXPECT_THROW(MakeKeyFrameGraph(Map(), model(), {}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::keyframe_graph_test
