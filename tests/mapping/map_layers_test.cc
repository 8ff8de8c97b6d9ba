// Keyframes of several layers in one DenseMapper.
#include <highwall/mapping/dense_mapper.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/so3.h>

#include "box_room.h"
#include "same_map.h"

namespace highwall::map_layers_test {
namespace {

constexpr std::int32_t kFirst = 0, kSecond = 7;

// The first three keyframes of a walk are in the first layer, the others in the second, whose world
// frame is rotated and translated: in that of the first they would see through its walls.
class LayersOfARoom : public ::testing::TestWithParam<bool> {
 protected:
  LayersOfARoom() : mapper_(BoxRoomOptions(GetParam()), SmallCamera()) {
    const Pose T_second_first(so3::Exp(Eigen::Vector3d(0.1, 0.25, 0.0)), {0.2, 0.1, 1.0});
    for (std::size_t i = 0; i < walk_.size(); ++i) {
      keyframes_.push_back(walk_[i]);
      if (i < 3) continue;
      keyframes_[i].layer = kSecond;
      keyframes_[i].T_WC = T_second_first * walk_[i].T_WC;
    }
  }

  static std::map<std::int32_t, DenseMap> MapOf(const std::vector<KeyframeImage>& keyframes) {
    DenseMapper mapper(BoxRoomOptions(false), SmallCamera());
    for (const KeyframeImage& keyframe : keyframes) mapper.AddKeyframe(keyframe);
    return mapper.Finish();
  }
  static std::vector<KeyframeImage> Part(const std::vector<KeyframeImage>& keyframes,
                                         std::size_t begin, std::size_t end) {
    return {keyframes.begin() + static_cast<std::ptrdiff_t>(begin),
            keyframes.begin() + static_cast<std::ptrdiff_t>(end)};
  }
  static std::map<std::int64_t, KeyframePose> PosesOf(const std::vector<KeyframeImage>& keyframes,
                                                      std::int32_t layer) {
    std::map<std::int64_t, KeyframePose> poses;
    for (const KeyframeImage& keyframe : keyframes) poses[keyframe.id] = {keyframe.T_WC, layer};
    return poses;
  }
  void Add(const std::vector<KeyframeImage>& keyframes) {
    for (const KeyframeImage& keyframe : keyframes) mapper_.AddKeyframe(keyframe);
  }
  void WaitUntilCurrent() const {
    for (int ms = 0; !mapper_.IsCurrent(); ++ms) {
      ASSERT_LT(ms, 60'000);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  const std::vector<KeyframeImage> walk_ = WalkThroughBox();  // all in one world
  std::vector<KeyframeImage> keyframes_;
  DenseMapper mapper_;
};

INSTANTIATE_TEST_SUITE_P(HereAndOnAThread, LayersOfARoom, ::testing::Bool());

TEST_P(LayersOfARoom, HaveMapsAsIfTheOthersWereNotThere) {
  Add(keyframes_);
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 2u);
  ExpectSameMap(maps.at(kFirst), MapOf(Part(keyframes_, 0, 3)).at(kFirst));
  ExpectSameMap(maps.at(kSecond), MapOf(Part(keyframes_, 3, 6)).at(kSecond));
}

TEST_P(LayersOfARoom, FollowTheirKeyframesEachOnItsOwn) {
  Add(keyframes_);
  std::map<std::int64_t, KeyframePose> poses = PosesOf(Part(walk_, 3, 6), kSecond);
  poses.merge(PosesOf(Part(keyframes_, 0, 3), kFirst));
  mapper_.SetPoses(poses);
  const auto maps = mapper_.Finish();
  ExpectSameMap(maps.at(kFirst), MapOf(Part(keyframes_, 0, 3)).at(kFirst));
  ExpectSameLeaves(maps.at(kSecond).octree, MapOf(Part(walk_, 3, 6)).at(kFirst).octree);
}

// Points in full voxels were dropped per layer, so where both layers saw the same surface a voxel
// averages up to twice as many points: the voxels are equal, except where a mean is at a voxel
// border.
void ExpectNearlySameCloud(const DenseMap& a, const DenseMap& b) {
  using Voxel = std::tuple<long, long, long>;
  const auto voxels = [](const DenseMap& map) {
    std::set<Voxel> all;
    for (const ColoredPoint& point : map.cloud) {
      const auto index = [&](int axis) { return std::lround(std::floor(point.p[axis] / 0.05f)); };
      all.emplace(index(0), index(1), index(2));
    }
    return all;
  };
  const std::set<Voxel> in_a = voxels(a), in_b = voxels(b);
  std::size_t both = 0;
  for (const Voxel& voxel : in_a) both += in_b.count(voxel);
  EXPECT_EQ(both, in_a.size());
  EXPECT_EQ(both, in_b.size());
  EXPECT_EQ(a.cloud.size(), b.cloud.size());
}

TEST_P(LayersOfARoom, ThatBecomeOneEqualAMapThatAlwaysWas) {
  for (const std::int32_t joined : {kFirst, kSecond}) {
    DenseMapper mapper(BoxRoomOptions(GetParam()), SmallCamera());
    for (const KeyframeImage& keyframe : keyframes_) mapper.AddKeyframe(keyframe);
    mapper.SetPoses(PosesOf(walk_, joined));
    const auto maps = mapper.Finish();
    ASSERT_EQ(maps.size(), 1u);
    const auto always = MapOf(walk_);
    ExpectSameLeaves(maps.at(joined).octree, always.at(kFirst).octree);
    ExpectNearlySameCloud(maps.at(joined), always.at(kFirst));
    EXPECT_EQ(maps.at(joined).ground_height, always.at(kFirst).ground_height);
  }
}

TEST_P(LayersOfARoom, BecomeOneWhileKeyframesArrive) {
  Add(Part(keyframes_, 0, 5));
  mapper_.SetPoses(PosesOf(Part(walk_, 0, 5), kFirst));
  Add(Part(walk_, 5, 6));
  WaitUntilCurrent();
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 1u);
  const auto always = MapOf(walk_);
  ExpectSameLeaves(maps.at(kFirst).octree, always.at(kFirst).octree);
  ExpectNearlySameCloud(maps.at(kFirst), always.at(kFirst));
}

TEST_P(LayersOfARoom, ComeApartAgain) {
  Add(walk_);
  std::map<std::int64_t, KeyframePose> poses = PosesOf(Part(keyframes_, 3, 6), kSecond);
  poses.merge(PosesOf(Part(keyframes_, 0, 3), kFirst));
  mapper_.SetPoses(poses);
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 2u);
  for (const auto& [layer, map] : MapOf(keyframes_)) {
    ExpectSameLeaves(maps.at(layer).octree, map.octree);
  }
}

TEST_P(LayersOfARoom, LeaveNothingWhenTheirKeyframesAreNoMore) {
  const auto alone = MapOf(Part(keyframes_, 0, 3));
  // The last keyframe waits for the next one, with which it would be compared.
  Add(keyframes_);
  mapper_.SetPoses(PosesOf(Part(keyframes_, 0, 3), kFirst));
  WaitUntilCurrent();
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 1u);
  ExpectSameMap(maps.at(kFirst), alone.at(kFirst));
}

TEST_P(LayersOfARoom, LeaveNothingWhenTheirKeyframesAreRemovedOneByOne) {
  Add(keyframes_);
  for (const KeyframeImage& keyframe : Part(keyframes_, 0, 3)) mapper_.RemoveKeyframe(keyframe.id);
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 1u);
  ExpectSameMap(maps.at(kSecond), MapOf(Part(keyframes_, 3, 6)).at(kSecond));
}

TEST_P(LayersOfARoom, HoldAKeyframeOnceThatComesAgainInAnother) {
  Add(Part(keyframes_, 0, 2));
  KeyframeImage again = keyframes_[0];
  again.layer = kSecond;
  Add({again});
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 2u);
  ExpectSameLeaves(maps.at(kSecond).octree, MapOf({again}).at(kSecond).octree);
  EXPECT_FALSE(maps.at(kFirst).cloud.empty());
}

TEST_P(LayersOfARoom, WithoutKeyframesThereIsNoMap) {
  EXPECT_TRUE(mapper_.Finish().empty());
}

}  // namespace
}  // namespace highwall::map_layers_test
