#include "system/uncertainty_estimator.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

namespace highwall::uncertainty_estimator_test {
namespace {

using Covariance = UncertaintyEstimator::Covariance;

constexpr Stamp kFrame = 33'000'000;  // [ns]
constexpr KeyFrameId kReference{0};

// An image that knows its pose to 1 mm and 1 mrad, with landmarks that are exact to a part in 1e9.
UncertaintyEstimator::Image Good() {
  return {.information_C = 1e6 * Covariance::Identity(), .observers = 1e9};
}

AnchoredPose At(const Pose& T_reference_C) {
  return {kReference, T_reference_C};
}

TEST(UncertaintyEstimator, AFrameThatBeginsAMapIsExact) {
  UncertaintyEstimator estimator({});
  const PoseUncertainty origin = estimator.OfOrigin(0);
  EXPECT_EQ(origin.reference, kNoId);
  EXPECT_TRUE(origin.in_map.isZero(0.0));
}

TEST(UncertaintyEstimator, AnImageThatIsConstrainedKnowsItsPoseByItself) {
  UncertaintyEstimator estimator({});
  estimator.OfOrigin(0);
  const PoseUncertainty frame = estimator.OfImage(kFrame, At({}), Good());
  EXPECT_EQ(frame.reference, kReference);
  EXPECT_NEAR(frame.in_keyframe(0, 0), 1e-6, 1e-14);
  EXPECT_NEAR(frame.in_keyframe(3, 3), 1e-6, 1e-14);
}

// The pose is that of the image alone: a prediction as good as the image must not halve its
// variance.
TEST(UncertaintyEstimator, FramesInQuickSuccessionAreNoMoreCertainThanTheirImages) {
  UncertaintyEstimator estimator({});
  for (int i = 0; i < 50; ++i) {
    const Covariance now = estimator.OfImage(i * kFrame / 4, At({}), Good()).in_keyframe;
    EXPECT_NEAR(now(0, 0), 1e-6, 1e-14) << i;
  }
}

TEST(UncertaintyEstimator, LandmarksOfOneObservationDoubleTheCovariance) {
  UncertaintyEstimator estimator({});
  UncertaintyEstimator::Image image = Good();
  image.observers = 1.0;
  image.error = 3.0;
  const PoseUncertainty frame = estimator.OfImage(0, At({}), image);
  EXPECT_NEAR(frame.in_keyframe(5, 5), 6e-6, 1e-10);
}

TEST(UncertaintyEstimator, APosePredictedFromALateImageKnowsLessThanTheImage) {
  UncertaintyEstimator estimator({});
  estimator.OfOrigin(0);
  const PoseUncertainty image = estimator.OfImage(kFrame, At({}), Good());
  const PoseUncertainty later = UncertaintyEstimator::Predicted(image, 0.1);
  // 3 m/s^2 over 0.1 s, and the millimetre of the image.
  EXPECT_NEAR(later.in_keyframe(0, 0), 1e-6 + 9e-4, 1e-14);
  EXPECT_NEAR(later.in_map(0, 0), 1e-6 + 9e-4, 1e-14);
}

TEST(UncertaintyEstimator, GrowsWhileImagesHoldNothing) {
  UncertaintyEstimator estimator({});
  double last = estimator.OfImage(0, At({}), Good()).in_keyframe.trace();
  for (int i = 1; i <= 5; ++i) {
    const double now = estimator.OfImage(i * kFrame, At({}), {}).in_keyframe.trace();
    EXPECT_GT(now, 1.2 * last) << i;
    last = now;
  }
  // After 0.165 s without an image: by the fourth power of the time.
  EXPECT_NEAR(last, 3.0 * (2e-6 + (3.0 * 3.0 + 10.0 * 10.0) * std::pow(0.165, 4)), 1e-9);
}

TEST(UncertaintyEstimator, ADirectionThatStaysOpenGrowsFromFrameToFrame) {
  UncertaintyEstimator estimator({});
  estimator.OfImage(0, At({}), Good());
  UncertaintyEstimator::Image open = Good();
  open.information_C(0, 0) = 0.0;
  double last = 0.0;
  for (int i = 1; i <= 5; ++i) {
    const Covariance now = estimator.OfImage(i * kFrame, At({}), open).in_keyframe;
    EXPECT_GT(now(0, 0), last + 1e-6) << i;
    EXPECT_LT(now(1, 1), 1.01e-6) << i;
    last = now(0, 0);
  }
}

TEST(UncertaintyEstimator, APoseOfTheSmootherHasItsCovariance) {
  UncertaintyEstimator estimator({});
  const Covariance covariance = 4e-6 * Covariance::Identity();
  const PoseUncertainty frame = estimator.OfSmoother(0, At({}), covariance);
  EXPECT_EQ(frame.in_keyframe, covariance);
  EXPECT_EQ(frame.in_map, covariance);
}

TEST(UncertaintyEstimator, AFrameInheritsTheErrorOfItsKeyframe) {
  UncertaintyEstimator estimator({});
  Map map;
  const KeyFrameId id = map.AddKeyFrame({0, 0, std::make_shared<FrameFeatures>()}, Pose()).id;
  ASSERT_EQ(id, kReference);
  Covariance of_keyframe = Covariance::Zero();
  of_keyframe(4, 4) = 1e-6;  // about y
  estimator.OfSmoother(0, At({}), of_keyframe);
  estimator.AddKeyFrame(id, &map);
  // Two metres ahead, that is 2 mm to the side.
  const PoseUncertainty frame = estimator.OfSmoother(
      kFrame, At(Pose(Eigen::Quaterniond::Identity(), {0, 0, 2})), 1e-12 * Covariance::Identity());
  EXPECT_NEAR(frame.in_map(0, 0), 4e-6, 1e-11);
  EXPECT_NEAR(frame.in_map(4, 4), 1e-6, 1e-11);
  EXPECT_NEAR(std::abs(frame.in_map(0, 4)), 2e-6, 1e-11);
  EXPECT_NEAR(frame.in_map(1, 1), 0.0, 1e-11);
  EXPECT_NEAR(frame.in_keyframe(0, 0), 1e-12, 1e-18);
}

}  // namespace
}  // namespace highwall::uncertainty_estimator_test
