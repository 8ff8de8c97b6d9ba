#include "system/keyframe_release.h"

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace highwall::keyframe_release_test {
namespace {

constexpr double kWait = 2.0;

class KeyframeReleaseTest : public ::testing::Test {
 protected:
  // Adds a keyframe with depth 1 at `seconds` to the map.
  KeyFrameId Add(double seconds, const cv::Mat& dynamic = {}) {
    Frame frame;
    frame.index = index_++;
    frame.stamp = FromSeconds(seconds);
    frame.features = std::make_shared<const FrameFeatures>();
    const KeyFrameId id = map_.AddKeyFrame(frame, Pose()).id;
    image_.stamp = frame.stamp;
    release_.Add(id, image_, dynamic);
    return id;
  }
  static cv::Mat Column(int u) {
    cv::Mat mask(6, 8, CV_8UC1, cv::Scalar(0));
    mask.col(u).setTo(255);
    return mask;
  }
  KeyframeEvent Event(double now) {
    return release_.Event(FromSeconds(now), map_, [this](KeyFrameId id) { return masks_[id]; });
  }
  // The views of an event that was emitted.
  std::vector<KeyframeView> Take(double now) {
    std::vector<KeyframeView> views = Event(now).added;
    release_.SetEmitted(FromSeconds(now));
    return views;
  }

  RgbdImage image_{.bgr = cv::Mat(6, 8, CV_8UC3, cv::Scalar(1, 2, 3)),
                   .depth = cv::Mat(6, 8, CV_32FC1, cv::Scalar(1.0))};
  Map map_;
  std::map<KeyFrameId, cv::Mat> masks_;  // the current estimate
  KeyframeRelease release_{kWait};

 private:
  std::int64_t index_ = 0;
};

TEST_F(KeyframeReleaseTest, ReleasesEachOnceWhenItHasWaited) {
  const KeyFrameId first = Add(1.0);
  Add(1.5);
  EXPECT_TRUE(Take(2.999).empty());
  const std::vector<KeyframeView> views = Take(3.0);
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].id, first.value());
  EXPECT_EQ(views[0].stamp, FromSeconds(1.0));
  EXPECT_EQ(Take(10.0).size(), 1u);
  EXPECT_TRUE(Take(20.0).empty());
}

TEST_F(KeyframeReleaseTest, AViewHoldsTheNoiseOfItsDepth) {
  Add(1.0);
  image_.noise_factor = cv::Mat(6, 8, CV_32FC1, cv::Scalar(2.0));
  Add(1.5);
  image_.noise_factor.setTo(3.0);
  const std::vector<KeyframeView> views = Take(10.0);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_TRUE(views[0].noise_factor->empty());
  EXPECT_EQ(views[1].noise_factor->at<float>(2, 3), 2.0F);
}

TEST_F(KeyframeReleaseTest, TheLastEventHoldsAllThatWaitAndAllPlaces) {
  Add(1.0);
  Add(1.5);
  const KeyframeRelease::MaskOf none = [](KeyFrameId) { return cv::Mat(); };
  const KeyframeEvent last = release_.LastEvent(map_, none);
  EXPECT_EQ(last.added.size(), 2u);
  EXPECT_EQ(last.places.value().size(), 2u);
  release_.SetLastEmitted();
  EXPECT_TRUE(release_.LastEvent(map_, none).added.empty());
}

TEST_F(KeyframeReleaseTest, AnEventThatWasNotEmittedIsHeldByTheNext) {
  Add(1.0);
  release_.Remove(Add(1.5));
  release_.Move();
  for (int i = 0; i < 2; ++i) {
    const KeyframeEvent event = Event(3.0 + i);
    EXPECT_EQ(event.added.size(), 1u);
    EXPECT_EQ(event.removed.size(), 1u);
    EXPECT_TRUE(event.places.has_value());
  }
  release_.SetEmitted(FromSeconds(4.0));
  EXPECT_TRUE(Event(9.0).empty());
}

TEST_F(KeyframeReleaseTest, PlacesThemWhereTheyAreByThen) {
  const KeyFrameId id = Add(1.0);
  map_.keyframe(id)->T_WC = Pose(Eigen::Quaterniond::Identity(), {5.0, 0.0, 0.0});
  const std::vector<KeyframeView> views = Take(3.0);
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].place.T_WC.p().x(), 5.0);
  EXPECT_EQ(views[0].place.world, map_.Root(kFirstSubmap).value());
}

TEST_F(KeyframeReleaseTest, MasksObjectsThatWereDynamicAtFirstOrByThen) {
  const KeyFrameId id = Add(1.0, Column(2));
  masks_[id] = Column(5);
  const std::vector<KeyframeView> views = Take(3.0);
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(cv::countNonZero(*views[0].dynamic != (Column(2) | Column(5))), 0);
}

TEST_F(KeyframeReleaseTest, KeepsImagesThatTheCallerOverwrites) {
  cv::Mat dynamic = Column(2);
  Add(1.0, dynamic);
  image_.depth.setTo(7.0);
  image_.bgr.setTo(0);
  dynamic.setTo(0);
  const std::vector<KeyframeView> views = Take(3.0);
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(cv::countNonZero(*views[0].dynamic != Column(2)), 0);
  EXPECT_EQ(views[0].depth->at<float>(0, 0), 1.0f);
  EXPECT_EQ(views[0].bgr->at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
}

TEST_F(KeyframeReleaseTest, ForgetsThoseThatAreRemovedOrNoLongerInTheMap) {
  const KeyFrameId removed = Add(1.0), gone = Add(1.1), kept = Add(1.2);
  release_.Remove(removed);
  map_.RemoveKeyFrame(gone, kept);
  const std::vector<KeyframeView> views = Take(9.0);
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].id, kept.value());
}

}  // namespace
}  // namespace highwall::keyframe_release_test
