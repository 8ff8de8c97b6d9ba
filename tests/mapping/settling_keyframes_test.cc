#include <highwall/mapping/dense_mapper.h>

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/error.h>
#include <opencv2/core.hpp>

#include "box_room.h"

namespace highwall::settling_keyframes_test {
namespace {

constexpr double kWait = 2.0;

class SettlingKeyframesOfARoom : public ::testing::Test {
 protected:
  static DenseMapOptions Options() {
    DenseMapOptions options;
    options.cloud.voxel_size = 0.05;
    options.octree.resolution = 0.1;
    options.background = false;
    return options;
  }

  // The left half of the image.
  static cv::Mat LeftHalf() {
    const PinholeCamera camera = SmallCamera().pinhole;
    cv::Mat mask(camera.height, camera.width, CV_8UC1, cv::Scalar(0));
    mask(cv::Rect(0, 0, camera.width / 2, camera.height)).setTo(255);
    return mask;
  }

  static void ExpectNothingOnTheLeft(const DenseMap& map) {
    ASSERT_FALSE(map.cloud.empty());
    for (const ColoredPoint& point : map.cloud) ASSERT_GT(point.p.x(), 0.0f);
  }

  // What the system would know by now; a keyframe that is not here is no more.
  std::map<std::int64_t, SettledKeyframe> known_;
  DenseMapper mapper_{Options(), SmallCamera()};
  SettlingKeyframes settling_{mapper_,
                              [this](std::int64_t id) -> std::optional<SettledKeyframe> {
                                const auto known = known_.find(id);
                                if (known == known_.end()) return std::nullopt;
                                return known->second;
                              },
                              kWait};
};

TEST_F(SettlingKeyframesOfARoom, AreHandedOverWhenTheyHaveWaited) {
  known_[1] = known_[2] = {};
  settling_.Add(ViewOfBox(1, 0.0, Pose()), {});
  settling_.Add(ViewOfBox(2, 0.5, Pose()), {});
  settling_.HandOver(FromSeconds(kWait));
  mapper_.Finish();
  EXPECT_EQ(mapper_.keyframe_ms().size(), 1u);
}

TEST_F(SettlingKeyframesOfARoom, DoNotComeBeforeTheirTime) {
  known_[1] = {};
  settling_.Add(ViewOfBox(1, 0.0, Pose()), {});
  settling_.HandOver(FromSeconds(kWait) - 1);
  mapper_.Finish();
  EXPECT_EQ(mapper_.keyframe_ms().size(), 0u);
}

TEST_F(SettlingKeyframesOfARoom, AllComeInTheEnd) {
  known_[1] = known_[2] = {};
  settling_.Add(ViewOfBox(1, 0.0, Pose()), {});
  settling_.Add(ViewOfBox(2, 0.5, Pose()), {});
  settling_.HandOverAll();
  settling_.HandOverAll();
  mapper_.Finish();
  EXPECT_EQ(mapper_.keyframe_ms().size(), 2u);
}

TEST_F(SettlingKeyframesOfARoom, StandWhereTheyAreByThen) {
  known_[1].pose.T_WC = Pose(Eigen::Quaterniond::Identity(), {100.0, 0.0, 0.0});
  settling_.Add(ViewOfBox(1, 0.0, Pose()), {});
  settling_.HandOverAll();
  const DenseMap map = std::move(mapper_.Finish().at(0));
  ASSERT_FALSE(map.cloud.empty());
  for (const ColoredPoint& point : map.cloud) ASSERT_GT(point.p.x(), 90.0f);
}

TEST_F(SettlingKeyframesOfARoom, AreInTheLayerThatTheyAreInByThen) {
  known_[1].pose.layer = 3;
  settling_.Add(ViewOfBox(1, 0.0, Pose()), {});
  settling_.HandOverAll();
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_FALSE(maps.at(3).cloud.empty());
}

TEST_F(SettlingKeyframesOfARoom, LeaveOutWhatMovedAsSeenAtOnce) {
  known_[1] = {};
  settling_.Add(ViewOfBox(1, 0.0, Pose()), LeftHalf());
  settling_.HandOverAll();
  ExpectNothingOnTheLeft(mapper_.Finish().at(0));
}

TEST_F(SettlingKeyframesOfARoom, LeaveOutWhatMovedAsSeenLater) {
  const KeyframeImage image = ViewOfBox(1, 0.0, Pose());
  const cv::Mat before = image.depth.clone();
  settling_.Add(image, {});
  known_[1].moving = LeftHalf();
  settling_.HandOverAll();
  ExpectNothingOnTheLeft(mapper_.Finish().at(0));
  EXPECT_EQ(cv::countNonZero(image.depth != before), 0) << "the pixels belong to others too";
}

TEST_F(SettlingKeyframesOfARoom, AreForgottenWhereTheyAreNoMore) {
  known_[2] = {};
  settling_.Add(ViewOfBox(1, 0.0, Pose()), {});
  settling_.Add(ViewOfBox(2, 0.0, Pose()), {});
  settling_.Add(ViewOfBox(3, 0.0, Pose()), {});
  known_[3] = {};
  settling_.Remove(3);
  settling_.HandOverAll();
  mapper_.Finish();
  EXPECT_EQ(mapper_.keyframe_ms().size(), 1u);
}

TEST_F(SettlingKeyframesOfARoom, LeaveTheMapWhereTheyAreInItAlready) {
  known_[1] = {};
  settling_.Add(ViewOfBox(1, 0.0, Pose()), {});
  settling_.HandOverAll();
  settling_.Remove(1);
  EXPECT_TRUE(mapper_.Finish().empty());
}

TEST_F(SettlingKeyframesOfARoom, RefuseNobodyToAskAndTimeThatRunsBackwards) {
  EXPECT_THROW(SettlingKeyframes(mapper_, nullptr), InvalidArgument);
  const SettledKeyframeOf nothing = [](std::int64_t) { return std::nullopt; };
  EXPECT_THROW(SettlingKeyframes(mapper_, nothing, -1.0), InvalidArgument);
}

}  // namespace
}  // namespace highwall::settling_keyframes_test
