#include <gtest/gtest.h>

#include "tracking/tracking_diagnostics.h"

namespace highwall::tracking_diagnostics_test {
namespace {

constexpr FeatureNeeds kNeeds{
    .min_features = 100, .min_corner = 7.0, .usual_sharpness = 10.0, .searched = 60.0};

// Returns a well-lit sharp image with many features that have depth.
FrameFeatures Good() {
  FrameFeatures features;
  features.brightness = 110.0;
  features.sharpness = 9.0;
  features.points.resize(300);
  for (PointFeature& point : features.points) point.depth = 1.0;
  return features;
}

FrameFeatures Few() {
  FrameFeatures features = Good();
  features.points.resize(30);
  return features;
}

TEST(LossReason, BrightnessAndSharpnessExplainTooFewFeatures) {
  FrameFeatures features = Few();
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kPlain);
  features.sharpness = 4.9;
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kBlurred);
  features.brightness = 20.0;
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kDark);
  features.sharpness = 4.9, features.brightness = 110.0;
  FeatureNeeds first = kNeeds;
  first.usual_sharpness = 0.0;
  EXPECT_EQ(ReasonOf(features, {}, first), LossReason::kPlain) << "nothing to compare with";
}

TEST(LossReason, CornersThatMayBeNoiseMakeADarkImageNoBrighter) {
  FrameFeatures features = Good();
  for (PointFeature& point : features.points) point.low_contrast = true;
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kPlain);
  features.brightness = 20.0;
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kDark);
}

TEST(LossReason, FeaturesWithoutDepthAreNoDepth) {
  FrameFeatures features = Good();
  for (std::size_t i = 99; i < features.points.size(); ++i) features.points[i].depth = 0.0;
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kNoDepth);
  features.points[99].depth = 1.0;
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kUnknownPlace);
  features.points[99].depth = 0.0;
  features.lines.resize(1);
  features.lines[0].segment_C.emplace();
  EXPECT_EQ(ReasonOf(features, {}, kNeeds), LossReason::kUnknownPlace) << "lines count as well";
}

TEST(LossReason, MatchesExplainTheLossOfAGoodImage) {
  const FrameFeatures features = Good();
  EXPECT_EQ(ReasonOf(features, {.masked_share = 0.6}, kNeeds), LossReason::kAllMoving);
  EXPECT_EQ(ReasonOf(features, {.shift = 61.0}, kNeeds), LossReason::kTooFast);
  EXPECT_EQ(ReasonOf(features, {.tried = 100, .agreed = 49}, kNeeds), LossReason::kContradictory);
  EXPECT_EQ(ReasonOf(features, {.tried = 100, .agreed = 50}, kNeeds), LossReason::kUnknownPlace);
  EXPECT_EQ(ReasonOf(features, {.tried = 20}, kNeeds), LossReason::kUnknownPlace)
      << "so few contradict nothing";
  EXPECT_EQ(ReasonOf(features, {.predicted = true}, kNeeds), LossReason::kDeadReckoning);
}

TEST(LossReason, EachHasAName) {
  EXPECT_STREQ(ToString(LossReason::kDark), "dark");
  EXPECT_STREQ(ToString(LossReason::kRepeatedImage), "repeated image");
  EXPECT_STREQ(ToString(LossReason::kDeadReckoning), "dead reckoning");
}

}  // namespace
}  // namespace highwall::tracking_diagnostics_test
