#include <highwall/core/keyframe_event.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include <gtest/gtest.h>
#include <highwall/core/error.h>
#include <highwall/mapping/dense_mapper.h>
#include <opencv2/core.hpp>

#include "box_room.h"

namespace highwall::keyframe_event_test {
namespace {

DenseMapOptions Options() {
  DenseMapOptions options;
  options.cloud.voxel_size = 0.05;
  options.octree.resolution = 0.1;
  options.background = false;
  return options;
}

std::shared_ptr<const cv::Mat> Shared(const cv::Mat& image) {
  return std::make_shared<const cv::Mat>(image);
}

KeyframeView View(std::int64_t id, const KeyframePlace& place = {}) {
  const KeyframeImage image = ViewOfBox(id, 0.5 * static_cast<double>(id), Pose());
  return {.id = id,
          .stamp = image.stamp,
          .depth = Shared(image.depth),
          .bgr = Shared(image.bgr),
          .dynamic = nullptr,
          .place = place};
}

KeyframePlace At(double x, std::int32_t world = 0) {
  return {Pose(Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}), world};
}

class ApplyKeyframeEvent : public ::testing::Test {
 protected:
  std::size_t FinishAndCountKeyframes() {
    mapper_.Finish();
    return mapper_.keyframe_ms().size();
  }

  DenseMapper mapper_{Options(), SmallCamera()};
};

TEST_F(ApplyKeyframeEvent, GivesTheMapOfTheSameCallsByHand) {
  mapper_.Apply({.added = {View(1), View(2, At(0.1))}});
  mapper_.Apply({.places = {{{1, At(0.0)}, {2, At(0.2)}}}});
  const DenseMap followed = std::move(mapper_.Finish().at(0));

  DenseMapper by_hand(Options(), SmallCamera());
  KeyframeImage first = ViewOfBox(1, 0.5, Pose()), second = ViewOfBox(2, 1.0, Pose());
  second.T_WC = At(0.1).T_WC;
  by_hand.AddKeyframe(first);
  by_hand.AddKeyframe(second);
  by_hand.SetPoses({{1, {At(0.0).T_WC}}, {2, {At(0.2).T_WC}}});
  const DenseMap expected = std::move(by_hand.Finish().at(0));
  ASSERT_EQ(followed.cloud.size(), expected.cloud.size());
  for (std::size_t i = 0; i < expected.cloud.size(); ++i) {
    ASSERT_EQ(followed.cloud[i].p, expected.cloud[i].p);
  }
  EXPECT_EQ(followed.grid.cells, expected.grid.cells);
}

TEST_F(ApplyKeyframeEvent, PutsEachWorldIntoALayerOfItsOwn) {
  mapper_.Apply({.added = {View(1), View(2, At(100.0, 3))}});
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 2u);
  for (const ColoredPoint& point : maps.at(0).cloud) ASSERT_LT(point.p.x(), 10.0f);
  for (const ColoredPoint& point : maps.at(3).cloud) ASSERT_GT(point.p.x(), 90.0f);
}

TEST_F(ApplyKeyframeEvent, LeavesDynamicObjectsOutAndTheImageAsItIs) {
  KeyframeView view = View(1);
  const cv::Mat before = view.depth->clone();
  cv::Mat left(before.size(), CV_8UC1, cv::Scalar(0));
  left.colRange(0, left.cols / 2).setTo(255);
  view.dynamic = Shared(left);
  mapper_.Apply({.added = {view}});
  const DenseMap map = std::move(mapper_.Finish().at(0));
  ASSERT_FALSE(map.cloud.empty());
  for (const ColoredPoint& point : map.cloud) ASSERT_GT(point.p.x(), 0.0f);
  EXPECT_EQ(cv::countNonZero(*view.depth != before), 0) << "the pixels belong to others too";
}

TEST_F(ApplyKeyframeEvent, RemovesKeyframesThatAreNamedAndThatHaveNoPlace) {
  mapper_.Apply({.added = {View(1), View(2), View(3, At(100.0))}});
  mapper_.Apply({.removed = {1, 7}, .places = {{{3, At(100.0)}}}});
  const auto maps = mapper_.Finish();
  ASSERT_EQ(maps.size(), 1u);
  for (const ColoredPoint& point : maps.at(0).cloud) ASSERT_GT(point.p.x(), 90.0f);
}

TEST_F(ApplyKeyframeEvent, AddsWhatItHasPlacedBefore) {
  mapper_.Apply({.removed = {1}, .places = {{{2, At(0.0)}}}, .added = {View(1)}});
  EXPECT_EQ(FinishAndCountKeyframes(), 1u);
}

TEST_F(ApplyKeyframeEvent, SmoothsNoisierDepthOverLargerWindows) {
  KeyframeView view = View(1);
  cv::Mat step = view.depth->clone();
  step.at<float>(step.rows / 2, step.cols / 2) *= 1.01F;
  view.depth = Shared(step);
  view.noise_factor = Shared(cv::Mat(step.size(), CV_32FC1, cv::Scalar(10.0)));
  mapper_.Apply({.added = {view}});
  const DenseMap smoothed = std::move(mapper_.Finish().at(0));
  DenseMapper usual(Options(), SmallCamera());
  view.noise_factor = nullptr;
  usual.Apply({.added = {view}});
  const DenseMap as_usual = std::move(usual.Finish().at(0));
  ASSERT_FALSE(smoothed.cloud.empty());
  EXPECT_FALSE(
      std::ranges::equal(smoothed.cloud, as_usual.cloud, {}, &ColoredPoint::p, &ColoredPoint::p));
}

TEST_F(ApplyKeyframeEvent, RefusesNoDepthOrAForeignMaskAndAppliesNothingOfTheEvent) {
  KeyframeView bare = View(2), small = View(2), wide = View(2), noise = View(2);
  bare.depth = nullptr;
  small.dynamic = Shared(cv::Mat(2, 2, CV_8UC1, cv::Scalar(0)));
  wide.dynamic = Shared(cv::Mat(wide.depth->size(), CV_32FC1, cv::Scalar(0)));
  noise.noise_factor = Shared(cv::Mat(2, 2, CV_32FC1, cv::Scalar(1.0)));
  for (const KeyframeView& bad : {bare, small, wide, noise}) {
    EXPECT_THROW(mapper_.Apply({.added = {View(1), bad}}), InvalidArgument);
  }
  EXPECT_EQ(FinishAndCountKeyframes(), 0u);
}

TEST_F(ApplyKeyframeEvent, AnEmptyEventChangesNothing) {
  EXPECT_TRUE(KeyframeEvent().empty());
  mapper_.Apply({});
  EXPECT_EQ(FinishAndCountKeyframes(), 0u);
}

}  // namespace
}  // namespace highwall::keyframe_event_test
