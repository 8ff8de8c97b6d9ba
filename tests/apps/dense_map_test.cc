// The dense map of a run, fed with keyframes of the generated room.
#include "dense_map.h"

#include <cmath>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "depth_filter.h"
#include "simulate/scenes/room.h"

namespace highwall::apps {
namespace {

// A wall at z [m] in front of a camera that stands still.
PosedImage Wall(std::int64_t id, float z) {
  const PinholeCamera camera = RgbdSensor().camera;
  RgbdImage image;
  image.depth = cv::Mat(camera.height, camera.width, CV_32FC1, cv::Scalar(z));
  image.bgr = cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar(10, 20, 30));
  return {id, image, Pose()};
}

TEST(DepthFilter, AFrameComesOutWhenTheNextHasComeIn) {
  DepthFilter filter(RgbdSensor(), 0.01);
  EXPECT_FALSE(filter.Push(Wall(4, 2.0f)));
  EXPECT_EQ(filter.Push(Wall(7, 2.0f))->id, 4);
  EXPECT_EQ(filter.Push(Wall(9, 2.0f))->id, 7);
  EXPECT_EQ(filter.Flush()->id, 9);
  EXPECT_FALSE(filter.Flush());
}

TEST(DepthFilter, DropsWhatBothNeighboursLookThrough) {
  DepthFilter filter(RgbdSensor(), 0.01);
  PosedImage ghost = Wall(2, 2.0f);
  ghost.image.depth.at<float>(100, 100) = 1.0f;
  filter.Push(Wall(1, 2.0f));
  filter.Push(ghost);
  const cv::Mat depth = filter.Push(Wall(3, 2.0f))->image.depth;
  EXPECT_EQ(depth.at<float>(100, 100), 0.0f);
  EXPECT_NEAR(depth.at<float>(200, 100), 2.0f, 1e-5);  // rounding of the inverse
}

TEST(DepthFilter, PutsNeighboursWhereTheyAreNow) {
  DepthFilter filter(RgbdSensor(), 0.01);
  filter.Push(Wall(1, 2.0f));
  filter.Push(Wall(2, 1.0f));
  // From a metre farther back the first sees the wall of the second where that sees it itself.
  filter.SetPose(1, Pose(Eigen::Quaterniond::Identity(), {0, 0, -1}));
  const cv::Mat depth = filter.Flush()->image.depth;
  EXPECT_NEAR(depth.at<float>(200, 200), 1.0f, 1e-5);
}

TEST(DepthFilter, ForgetsRemovedFrames) {
  DepthFilter filter(RgbdSensor(), 0.01);
  filter.Push(Wall(1, 2.0f));
  filter.Remove(1);
  EXPECT_FALSE(filter.Push(Wall(2, 2.0f)));
  filter.Remove(2);
  EXPECT_FALSE(filter.Flush());
}

class DenseMapperOfARoom : public ::testing::Test {
 protected:
  DenseMapperOfARoom() {
    simulate::SimulationOptions options;
    options.imu.enabled = false;
    options.camera = {
        .width = 160, .height = 120, .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5};
    options.duration = 0.5;
    sensor_.camera = options.camera;
    const simulate::Simulation room = simulate::SimulateRoom(options);
    for (int i = 0; i < 12; i += 2) {
      const auto frame = room.Render(i);
      frames_.push_back({i, {frame.stamp, frame.bgr, frame.depth}, frame.T_WC});
    }
  }

  static DenseMapOptions Options(bool background) {
    DenseMapOptions options;
    options.cloud.voxel_size = 0.05;
    options.octree.resolution = 0.1;
    options.background = background;
    options.backlog = 2;
    return options;
  }
  std::map<std::int64_t, Pose> Poses() const {
    std::map<std::int64_t, Pose> poses;
    for (const PosedImage& frame : frames_) poses[frame.id] = frame.T_WC;
    return poses;
  }

  RgbdSensor sensor_;
  std::vector<PosedImage> frames_;
};

void ExpectEqual(const DenseMap& a, const DenseMap& b) {
  ASSERT_FALSE(a.cloud.empty());
  ASSERT_EQ(a.cloud.size(), b.cloud.size());
  for (std::size_t i = 0; i < a.cloud.size(); ++i) ASSERT_EQ(a.cloud[i].p, b.cloud[i].p) << i;
  EXPECT_EQ(a.octree.NodeCount(), b.octree.NodeCount());
  EXPECT_EQ(a.octree.LeafCount().occupied, b.octree.LeafCount().occupied);
}

TEST_F(DenseMapperOfARoom, IsTheSameOnAThreadOfItsOwn) {
  std::vector<DenseMap> maps;
  for (const bool background : {false, true}) {
    DenseMapper mapper(Options(background), sensor_);
    for (const PosedImage& frame : frames_) mapper.AddKeyframe(frame.id, frame.image, frame.T_WC);
    maps.push_back(mapper.Finish());
  }
  EXPECT_EQ(maps[0].keyframe_ms.size(), frames_.size());
  ExpectEqual(maps[0], maps[1]);
}

TEST_F(DenseMapperOfARoom, FollowsItsKeyframesDuringTheRun) {
  DenseMapper mapper(Options(true), sensor_);
  for (const PosedImage& frame : frames_) {
    const Pose drifted(frame.T_WC.q(), frame.T_WC.p() + Eigen::Vector3d(0.3, 0.0, 0.0));
    mapper.AddKeyframe(frame.id, frame.image, drifted);
  }
  mapper.SetPoses(Poses());
  for (int i = 0; i < 2000 && !mapper.IsCurrent(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(mapper.IsCurrent()) << "the map did not follow within two seconds";
  const DenseMap map = mapper.Finish();
  // The walls stand where the poses put them: the cloud of true poses, voxel by voxel nearly.
  DenseMapper truth(Options(false), sensor_);
  for (const PosedImage& frame : frames_) truth.AddKeyframe(frame.id, frame.image, frame.T_WC);
  const DenseMap expected = truth.Finish();
  const auto mean = [](const DenseMap& dense) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ColoredPoint& point : dense.cloud) sum += point.p.cast<double>();
    return (sum / static_cast<double>(dense.cloud.size())).eval();
  };
  // A tenth of the drift at most: which points voxels took in was decided before.
  EXPECT_LT((mean(map) - mean(expected)).norm(), 0.03);
}

TEST_F(DenseMapperOfARoom, ForgetsRemovedKeyframes) {
  DenseMapper with(Options(false), sensor_), without(Options(false), sensor_);
  for (const PosedImage& frame : frames_) with.AddKeyframe(frame.id, frame.image, frame.T_WC);
  for (std::size_t i = 1; i < frames_.size(); ++i) with.RemoveKeyframe(frames_[i].id);
  without.AddKeyframe(frames_[0].id, frames_[0].image, frames_[0].T_WC);
  const DenseMap one = with.Finish(), alone = without.Finish();
  EXPECT_EQ(one.octree.LeafCount().occupied > 0, true);
  // What the neighbour spoke against is missing.
  EXPECT_LE(one.cloud.size(), alone.cloud.size());
  EXPECT_GT(static_cast<double>(one.cloud.size()), 0.8 * static_cast<double>(alone.cloud.size()));
}

}  // namespace
}  // namespace highwall::apps
