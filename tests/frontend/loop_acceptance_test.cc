// Acceptance of loops as the map grows, by the criterion of the system.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "loops/loop_correction.h"
#include "support/ring_map.h"

namespace highwall::loop_acceptance_test {
namespace {

using testing::OdometryDrift;
using testing::RingMap;

const MeasurementModel kModel(testing::IdealSensor(), {});

class LoopAcceptance : public ::testing::Test {
 protected:
  // Works on a copy of the map.
  bool Accepts(const RingMap& ring, const LoopEdge& loop,
               const std::vector<LoopEdge>& before = {}) const {
    Map map = ring.map.Clone();
    return CorrectLoop(before, {.edge = loop}, kModel, {}, {}, &map).accepted;
  }
  static double Chi2(const RingMap& ring, const LoopEdge& loop) {
    return *LoopChi2(MakeKeyFrameGraph(ring.map, kModel, {}), loop);
  }
  static LoopEdge Off(LoopEdge loop, const Eigen::Vector3d& metres) {
    loop.Z = loop.Z * Pose(Eigen::Quaterniond::Identity(), metres);
    return loop;
  }
};

TEST_F(LoopAcceptance, AcceptsATrueLoopHoweverLongThePathIs) {
  constexpr unsigned kWalks = 20;
  for (const int keyframes : {100, 500}) {
    RingMap ring(keyframes);
    for (const bool levelled : {false, true}) {
      unsigned taken = 0;
      for (unsigned seed = 1; seed <= kWalks / 2; ++seed) {
        ring.Drift({.seed = seed}, levelled);
        taken += Accepts(ring, ring.Loop(KeyFrameId(0), ring.last()));
      }
      EXPECT_EQ(taken, kWalks / 2) << keyframes << (levelled ? " with gravity" : "");
    }
  }
}

TEST_F(LoopAcceptance, ParallelEdgesKnowNoMoreOfALongPathThanOdometry) {
  RingMap ring(200);
  const LoopEdge off = Off(ring.Loop(KeyFrameId(0), ring.last()), {1.0, 1.0, 1.0});
  const KeyFrameGraphOptions chain{.neighbours = 0}, sides{.neighbours = 3};
  const KeyFrameGraph graph = MakeKeyFrameGraph(ring.map, kModel, {}, sides);
  ASSERT_GT(graph.graph.edges.size(), 3u * 199u);
  const double alone = *LoopChi2(MakeKeyFrameGraph(ring.map, kModel, {}, chain), off, chain);
  // The bias of the motion adds up along a bent path a little less than along a straight one.
  EXPECT_NEAR(*LoopChi2(graph, off, sides), alone, 0.1 * alone);
}

TEST_F(LoopAcceptance, AllowsForABiasCommonToAllStepsOfALongPath) {
  constexpr double kMaxChi2 = KeyFrameGraphOptions().max_loop_chi2;
  RingMap ring(1000);
  int within = 0, unbiased = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ring.Drift({.seed = seed}, false);
    const KeyFrameGraph graph = MakeKeyFrameGraph(ring.map, kModel, {});
    const LoopEdge loop = ring.Loop(KeyFrameId(0), ring.last());
    within += *LoopChi2(graph, loop) < kMaxChi2;
    unbiased += *LoopChi2(graph, loop, {.drift_bias = 0.0}) < kMaxChi2;
  }
  EXPECT_EQ(within, 10);
  EXPECT_LT(unbiased, 10) << "else there is nothing to allow for";
}

TEST_F(LoopAcceptance, ManyLoopsThatTheMapHasClosedDoNotSpeakAgainstANewOne) {
  RingMap ring(300);
  ring.Drift({.noise_rotation = 0.004, .seed = 3}, false);  // the largest drift assumed possible
  const LoopEdge loop = ring.Loop(KeyFrameId(0), ring.last());
  ASSERT_GT(Chi2(ring, loop), 1.0) << "a drift that is to be seen";
  std::vector<LoopEdge> closed;
  for (int i = 100; i < 200; ++i) {  // within the middle of the walk
    const KeyFrameId match(i - 20), id(i);
    closed.push_back(
        {match, id, ring.map.keyframe(match)->T_WC.Inverse() * ring.map.keyframe(id)->T_WC});
  }
  EXPECT_TRUE(Accepts(ring, loop, closed));
}

TEST_F(LoopAcceptance, ALoopBeyondTheDriftIsRefusedWithGravityAsWithout) {
  for (const int keyframes : {50, 200}) {
    RingMap ring(keyframes);
    for (const bool levelled : {false, true}) {
      ring.Drift({.seed = 1}, levelled);
      const LoopEdge loop = ring.Loop(KeyFrameId(0), ring.last());
      EXPECT_TRUE(Accepts(ring, loop));
      for (const int axis : {0, 1, 2}) {
        const LoopEdge off = Off(loop, 3.0 * Eigen::Vector3d::Unit(axis));
        EXPECT_FALSE(Accepts(ring, off))
            << keyframes << (levelled ? " with gravity" : "") << ", chi2 " << Chi2(ring, off);
      }
    }
  }
}

TEST_F(LoopAcceptance, OnlyTheDriftOfThePathBoundsTheErrorOfALoop) {
  // The error grows along one axis, from the map's pose to a tenth below and above the bound.
  constexpr double kMaxChi2 = KeyFrameGraphOptions().max_loop_chi2;
  RingMap ring(500);
  for (const bool levelled : {false, true}) {
    ring.Drift({.seed = 2}, levelled);
    const Pose& T = ring.map.keyframe(ring.last())->T_WC;
    const LoopEdge none{KeyFrameId(0), ring.last(), ring.truth.front().Inverse() * T};
    for (const int axis : {0, 1, 2}) {
      const double farthest =
          std::sqrt(kMaxChi2 / Chi2(ring, Off(none, Eigen::Vector3d::Unit(axis))));
      EXPECT_TRUE(Accepts(ring, Off(none, 0.9 * farthest * Eigen::Vector3d::Unit(axis))));
      EXPECT_FALSE(Accepts(ring, Off(none, 1.1 * farthest * Eigen::Vector3d::Unit(axis))));
    }
  }
}

}  // namespace
}  // namespace highwall::loop_acceptance_test
