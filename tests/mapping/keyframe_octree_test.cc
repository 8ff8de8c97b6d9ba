#include <highwall/mapping/keyframe_octree.h>

#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall::keyframe_octree_test {
namespace {

using Points = std::vector<Eigen::Vector3f>;
using Poses = std::vector<Pose>;

constexpr double kNoTime = 0.0;      // [s] one keyframe per call
constexpr double kEnoughTime = 1e3;  // [s]

std::chrono::duration<double> Seconds(double seconds) {
  return std::chrono::duration<double>(seconds);
}

// Keyframes along a corridor, each of which sees its own section and those of its neighbours.
Points Scan(int index) {
  std::mt19937 rng(static_cast<unsigned>(index) + 1u);
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  Points points_C;
  for (int i = 0; i < 600; ++i) points_C.emplace_back(u(rng), 0.8f * u(rng), 1.5f + 0.3f * u(rng));
  return points_C;
}

Poses Corridor(int count, double shift = 0.0) {
  Poses poses;
  for (int i = 0; i < count; ++i) {
    poses.emplace_back(so3::Exp(Eigen::Vector3d(0.02 * i, shift, 0.01 * i)),
                       Eigen::Vector3d(0.7 * i + shift, 0.3 * shift, 0.05));
  }
  return poses;
}

OctomapBuilderOptions Options() {
  return {.resolution = 0.1};
}

void Fill(const Poses& poses, KeyframeOctree& octree) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    octree.SetKeyframe(static_cast<std::int64_t>(i), Scan(static_cast<int>(i)), poses[i]);
  }
}

void Move(const Poses& poses, std::size_t begin, std::size_t end, KeyframeOctree& octree) {
  for (std::size_t i = begin; i < end; ++i) {
    octree.SetPose(static_cast<std::int64_t>(i), poses[i]);
  }
}

struct Leaf {
  Eigen::Vector3d center_W;
  double size;
  float log_odds;
  bool operator==(const Leaf&) const = default;
};

std::vector<Leaf> Leaves(const KeyframeOctree& octree) {
  std::vector<Leaf> leaves;
  octree.map().ForEachLeaf([&](const OctreeLeaf& leaf) {
    leaves.push_back({leaf.center_W, leaf.size, leaf.log_odds});
  });
  return leaves;
}

// Compares all leaves bit for bit.
void ExpectEqualsFromScratch(const KeyframeOctree& octree, const Poses& poses) {
  KeyframeOctree fresh(Options());
  Fill(poses, fresh);
  EXPECT_TRUE(Leaves(octree) == Leaves(fresh));
  EXPECT_EQ(octree.map().NodeCount(), fresh.map().NodeCount());
}

TEST(KeyframeOctree, EqualsAMapFromScratchAfterAFewKeyframesMoved) {
  const Poses before = Corridor(12), after = Corridor(12, 0.13);
  Poses mixed = before;
  std::copy(after.begin() + 4, after.begin() + 7, mixed.begin() + 4);
  KeyframeOctree octree(Options());
  Fill(before, octree);
  EXPECT_TRUE(octree.IsCurrent());
  const auto old_leaves = Leaves(octree);
  Move(mixed, 4, 7, octree);
  EXPECT_FALSE(octree.IsCurrent());
  EXPECT_TRUE(Leaves(octree) == old_leaves);
  EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  EXPECT_FALSE(Leaves(octree) == old_leaves);
  ExpectEqualsFromScratch(octree, mixed);
}

TEST(KeyframeOctree, EqualsAMapFromScratchAfterAllKeyframesMoved) {
  const Poses after = Corridor(12, -0.4);
  KeyframeOctree octree(Options());
  Fill(Corridor(12), octree);
  Move(after, 0, 12, octree);
  EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  ExpectEqualsFromScratch(octree, after);
}

TEST(KeyframeOctree, ComesBackWhenTheKeyframesDo) {
  const Poses poses = Corridor(12);
  KeyframeOctree octree(Options());
  Fill(poses, octree);
  for (const Poses& target : {Corridor(12, 0.2), poses}) {
    Move(target, 2, 5, octree);
    EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  }
  ExpectEqualsFromScratch(octree, poses);
}

TEST(KeyframeOctree, ShowsTheOldMapUntilTheNewOneIsComplete) {
  const Poses after = Corridor(12, 0.3);
  for (const std::size_t moved : {3, 12}) {
    Poses mixed = Corridor(12);
    std::copy_n(after.begin(), moved, mixed.begin());
    KeyframeOctree octree(Options());
    Fill(Corridor(12), octree);
    Move(mixed, 0, moved, octree);
    const auto old_leaves = Leaves(octree);
    int calls = 1;
    while (!octree.Rebuild(Seconds(kNoTime))) {
      ++calls;
      ASSERT_TRUE(Leaves(octree) == old_leaves);
    }
    EXPECT_GE(calls, static_cast<int>(moved));
    ExpectEqualsFromScratch(octree, mixed);
  }
}

TEST(KeyframeOctree, KeyframesThatJoinDuringARoundAreNotLost) {
  Poses poses = Corridor(14);
  const Poses after = Corridor(14, 0.2);
  KeyframeOctree octree(Options());
  Fill(Poses(poses.begin(), poses.begin() + 12), octree);
  std::copy(after.begin() + 9, after.begin() + 12, poses.begin() + 9);
  Move(poses, 9, 12, octree);
  EXPECT_FALSE(octree.Rebuild(Seconds(kNoTime)));
  octree.SetKeyframe(12, Scan(12), poses[12]);
  EXPECT_FALSE(octree.Rebuild(Seconds(kNoTime)));
  octree.SetKeyframe(13, Scan(13), poses[13]);
  EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  ExpectEqualsFromScratch(octree, poses);
}

TEST(KeyframeOctree, APoseThatChangesDuringARoundWaitsForTheNext) {
  Poses poses = Corridor(12);
  KeyframeOctree octree(Options());
  Fill(poses, octree);
  poses[3] = Corridor(12, 0.2)[3];
  octree.SetPose(3, poses[3]);
  EXPECT_FALSE(octree.Rebuild(Seconds(kNoTime)));
  poses[3] = Corridor(12, -0.2)[3];
  octree.SetPose(3, poses[3]);
  EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  ExpectEqualsFromScratch(octree, poses);
}

TEST(KeyframeOctree, ForgetsRemovedKeyframesAndTakesReplacedAndLateOnes) {
  Poses poses = Corridor(12);
  KeyframeOctree octree(Options());
  Fill(poses, octree);
  octree.RemoveKeyframe(5);
  octree.RemoveKeyframe(5);
  octree.RemoveKeyframe(11);
  EXPECT_FALSE(octree.Rebuild(Seconds(kNoTime)));
  octree.RemoveKeyframe(0);  // during a round
  EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  EXPECT_EQ(octree.KeyframeCount(), 9u);
  KeyframeOctree fresh(Options());
  for (const int id : {1, 2, 3, 4, 6, 7, 8, 9, 10}) {
    fresh.SetKeyframe(id, Scan(id), poses[static_cast<std::size_t>(id)]);
  }
  EXPECT_TRUE(Leaves(octree) == Leaves(fresh));
  octree.SetKeyframe(0, Scan(0), poses[0]);
  octree.SetKeyframe(5, Scan(1), poses[5]);
  octree.SetKeyframe(5, Scan(5), poses[5]);
  octree.SetKeyframe(11, Scan(11), poses[11]);
  EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  ExpectEqualsFromScratch(octree, poses);
  for (std::int64_t id = 0; id < 12; ++id) octree.RemoveKeyframe(id);
  EXPECT_TRUE(octree.Rebuild(Seconds(kEnoughTime)));
  EXPECT_EQ(octree.map().NodeCount(), 0u);
}

TEST(KeyframeOctree, KeyframesThatMoveOverFromAnotherEqualAMapFromScratch) {
  const Poses poses = Corridor(12), elsewhere = Corridor(12, -0.4);
  for (const std::size_t first : {0, 7, 10}) {  // older ones, newer ones, and only a few
    const auto moves = [&](std::size_t i) { return first == 0 ? i < 5 : i >= first; };
    KeyframeOctree octree(Options()), other(Options());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      (moves(i) ? other : octree)
          .SetKeyframe(static_cast<std::int64_t>(i), Scan(static_cast<int>(i)),
                       moves(i) ? elsewhere[i] : poses[i]);
    }
    const auto old_leaves = Leaves(octree);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (moves(i)) other.MoveKeyframe(static_cast<std::int64_t>(i), poses[i], octree);
    }
    EXPECT_FALSE(octree.IsCurrent());
    EXPECT_FALSE(other.IsCurrent());
    int calls = 1;
    for (; !octree.Rebuild(Seconds(kNoTime)); ++calls) ASSERT_TRUE(Leaves(octree) == old_leaves);
    EXPECT_GE(calls, 3);
    ExpectEqualsFromScratch(octree, poses);
    EXPECT_TRUE(other.Rebuild());
    EXPECT_EQ(other.map().NodeCount(), 0u);
    EXPECT_EQ(other.KeyframeCount(), 0u);
  }
}

TEST(KeyframeOctree, IgnoresMovesBelowTheThreshold) {
  KeyframeOctree octree(Options());
  Fill(Corridor(2), octree);
  Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
  step[0] = 0.009;  // [m]
  step[4] = 0.008;  // [rad] 0.46 deg
  octree.SetPose(1, Corridor(2)[1].Plus(step));
  EXPECT_TRUE(octree.IsCurrent());
  step[4] = 0.009;  // 0.52 deg
  octree.SetPose(1, Corridor(2)[1].Plus(step));
  EXPECT_FALSE(octree.IsCurrent());
}

TEST(KeyframeOctree, StoresSixBytesAPointAndNoMorePointsThanHalfVoxels) {
  KeyframeOctree octree(Options());
  // 100 x 100 points over 1 m x 1 m: 21 x 21 half voxels of 0.05 m.
  Points wall;
  for (int i = 0; i < 10000; ++i) {
    wall.emplace_back(0.01f * static_cast<float>(i % 100), 0.01f * static_cast<float>(i / 100), 1);
  }
  octree.SetKeyframe(1, wall, Pose());
  EXPECT_LT(octree.ScanBytes(), 21u * 21u * 6u + 2000u);
}

TEST(KeyframeOctree, RefusesPosesThatAreNotFiniteAndUnknownKeyframes) {
  KeyframeOctree octree(Options());
  Pose pose;
  pose.data()[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(octree.SetKeyframe(1, Scan(1), pose), InvalidArgument);
  EXPECT_THROW(octree.SetPose(1, Pose()), InvalidArgument);
  EXPECT_EQ(octree.KeyframeCount(), 0u);
  octree.SetKeyframe(1, Points{}, Pose());
  EXPECT_THROW(octree.SetPose(1, pose), InvalidArgument);
  EXPECT_TRUE(octree.IsCurrent());
  KeyframeOctree other(Options()), finer({.resolution = 0.05});
  EXPECT_THROW(octree.MoveKeyframe(1, pose, other), InvalidArgument);
  EXPECT_THROW(octree.MoveKeyframe(2, Pose(), other), InvalidArgument);
  EXPECT_THROW(octree.MoveKeyframe(1, Pose(), finer), InvalidArgument);
  EXPECT_EQ(octree.KeyframeCount(), 1u);
  EXPECT_THROW(KeyframeOctree({.resolution = -1.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::keyframe_octree_test
