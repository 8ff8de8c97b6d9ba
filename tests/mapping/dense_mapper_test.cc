// The dense map of a run, fed with keyframes of a room.
#include <highwall/mapping/dense_mapper.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/error.h>
#include <highwall/mapping/depth_camera.h>

#include "box_room.h"
#include "same_map.h"

namespace highwall::dense_mapper_test {
namespace {

using Poses = std::map<std::int64_t, KeyframePose>;

class DenseMapperOfARoom : public ::testing::Test {
 protected:
  Poses AllIn(std::int32_t layer) const {
    Poses poses;
    for (const KeyframeImage& keyframe : keyframes_) poses[keyframe.id] = {keyframe.T_WC, layer};
    return poses;
  }

  const DepthCamera camera_ = SmallCamera();
  const std::vector<KeyframeImage> keyframes_ = WalkThroughBox();
};

TEST_F(DenseMapperOfARoom, IsTheSameOnAThreadOfItsOwn) {
  std::vector<DenseMap> maps;
  for (const bool background : {false, true}) {
    DenseMapper mapper(BoxRoomOptions(background), camera_);
    for (const KeyframeImage& keyframe : keyframes_) mapper.AddKeyframe(keyframe);
    maps.push_back(std::move(mapper.Finish().at(0)));
    EXPECT_EQ(mapper.keyframe_ms().size(), keyframes_.size());
  }
  ExpectSameMap(maps[0], maps[1]);
}

TEST_F(DenseMapperOfARoom, FollowsItsKeyframesDuringTheRun) {
  DenseMapper mapper(BoxRoomOptions(true), camera_);
  for (const KeyframeImage& keyframe : keyframes_) {
    KeyframeImage drifted = keyframe;
    drifted.T_WC = Pose(keyframe.T_WC.q(), keyframe.T_WC.p() + Eigen::Vector3d(0.3, 0.0, 0.0));
    mapper.AddKeyframe(drifted);
  }
  mapper.SetPoses(AllIn(0));
  while (!mapper.IsCurrent()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const DenseMap map = std::move(mapper.Finish().at(0));
  // The walls are where the poses put them: the cloud is nearly that of the true poses, voxel by
  // voxel.
  DenseMapper truth(BoxRoomOptions(false), camera_);
  for (const KeyframeImage& keyframe : keyframes_) truth.AddKeyframe(keyframe);
  const DenseMap expected = std::move(truth.Finish().at(0));
  const auto mean = [](const DenseMap& dense) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ColoredPoint& point : dense.cloud) sum += point.p.cast<double>();
    return (sum / static_cast<double>(dense.cloud.size())).eval();
  };
  // The tolerance is a tenth of the drift, because the points in each voxel were chosen before.
  EXPECT_LT((mean(map) - mean(expected)).norm(), 0.03);
}

TEST_F(DenseMapperOfARoom, StatesWhatItHoldsWhileTheMapsMove) {
  DenseMapper mapper(BoxRoomOptions(true), camera_);
  EXPECT_EQ(mapper.memory().front().bytes, 0U);
  for (const KeyframeImage& keyframe : keyframes_) {
    KeyframeImage drifted = keyframe;
    drifted.T_WC = Pose(keyframe.T_WC.q(), keyframe.T_WC.p() + Eigen::Vector3d(0.3, 0.0, 0.0));
    mapper.AddKeyframe(drifted);
  }
  mapper.SetPoses(AllIn(0));
  do {
    for (const MemoryShare& share : mapper.memory()) EXPECT_GT(share.bytes, 0U) << share.holder;
  } while (!mapper.IsCurrent());
}

TEST_F(DenseMapperOfARoom, ForgetsRemovedKeyframes) {
  DenseMapper with(BoxRoomOptions(false), camera_), without(BoxRoomOptions(false), camera_);
  for (const KeyframeImage& keyframe : keyframes_) with.AddKeyframe(keyframe);
  for (std::size_t i = 1; i < keyframes_.size(); ++i) with.RemoveKeyframe(keyframes_[i].id);
  without.AddKeyframe(keyframes_[0]);
  const DenseMap one = std::move(with.Finish().at(0)), alone = std::move(without.Finish().at(0));
  EXPECT_GT(one.octree.LeafCount().occupied, 0u);
  // Points that the neighbour contradicted are missing.
  EXPECT_LE(one.cloud.size(), alone.cloud.size());
  EXPECT_GT(static_cast<double>(one.cloud.size()), 0.8 * static_cast<double>(alone.cloud.size()));
}

TEST_F(DenseMapperOfARoom, KnowsTheGround) {
  DenseMapOptions options = BoxRoomOptions(false);
  options.cloud.voxel_size = 0.02;
  options.octree.resolution = 0.05;
  DenseMapper mapper(options, camera_);
  for (const KeyframeImage& keyframe : keyframes_) mapper.AddKeyframe(keyframe);
  const DenseMap map = std::move(mapper.Finish().at(0));
  // The camera's y axis points down, and the floor is 0.8 m below. Two metres of it are visible,
  // and the position of a voxel is known to half its size.
  ASSERT_TRUE(map.ground_height);
  EXPECT_NEAR(*map.ground_height, -0.8, 0.1);
  EXPECT_LT((map.R_GW * Eigen::Vector3d(0, -1, 0) - Eigen::Vector3d::UnitZ()).norm(), 0.05);
  EXPECT_GT(map.grid.width, 0);
}

TEST_F(DenseMapperOfARoom, RethrowsAnErrorOfItsThreadAndContinues) {
  for (const bool background : {false, true}) {
    DenseMapper mapper(BoxRoomOptions(background), camera_);
    KeyframeImage bad = keyframes_[0];
    bad.depth = cv::Mat(3, 4, CV_32FC1, cv::Scalar(1.0));
    const auto until_it_throws = [&] {
      mapper.AddKeyframe(bad);
      mapper.Finish();
    };
    EXPECT_THROW(until_it_throws(), InvalidArgument) << background;
  }
  DenseMapper mapper(BoxRoomOptions(false), camera_);
  KeyframeImage bad = keyframes_[0];
  bad.depth = cv::Mat(3, 4, CV_32FC1, cv::Scalar(1.0));
  EXPECT_THROW(mapper.AddKeyframe(bad), InvalidArgument);
  mapper.AddKeyframe(keyframes_[1]);
  EXPECT_FALSE(mapper.Finish().at(0).cloud.empty());
}

TEST(DenseMapOptions, ReachAsFarInCloudAndOctree) {
  const DenseMapOptions options;
  EXPECT_EQ(options.cloud.max_depth, kDenseRange);
  EXPECT_EQ(options.octree.max_range, kDenseRange);
}

TEST(DenseMapOptions, RefusesInvalidValuesByField) {
  const auto refuses = [](const std::function<void(DenseMapOptions&)>& change, const char* field) {
    DenseMapOptions options;
    change(options);
    try {
      DenseMapper(options, SmallCamera());
      ADD_FAILURE() << field << " was accepted";
    } catch (const InvalidArgument& error) {
      EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
    }
  };
  refuses([](auto& o) { o.backlog = 0; }, "DenseMapOptions::backlog");
  refuses([](auto& o) { o.cloud.voxel_size = 0.0; }, "voxel_size");
  refuses([](auto& o) { o.octree.resolution = 0.0; }, "resolution");
  refuses([](auto& o) { o.grid.z_max = 0.0; }, "z_max");
  EXPECT_THROW(DenseMapper({}, {SmallCamera().pinhole, nullptr}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::dense_mapper_test
