// Points of a user's extractor in a frame, and the rejection of invalid ones.
#include <highwall/core/error.h>
#include <highwall/frontend/features/orb_extractor.h>
#include <highwall/frontend/features/point_extractor.h>

#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "features/frame_builder.h"
#include "support/message_of.h"

namespace highwall::point_extractor_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Returns the kind and the points that it was given.
class Parrot final : public PointExtractor {
 public:
  FeatureType said{.name = "parrot",
                   .descriptor = DescriptorType::kFloat,
                   .columns = 4,
                   .pyramid = {.levels = 2, .scale_factor = 1.5}};
  ExtractedPoints points{{{10.25F, 20.5F, 1.0F, 30.0F, 5.0F, 1}, {40.0F, 50.0F, 1.0F, -1.0F, 1.0F}},
                         (cv::Mat_<float>(2, 4) << 1, 2, 3, 4, 4, 3, 2, 1)};

  const FeatureType& kind() const override { return said; }
  ExtractedPoints Extract(const cv::Mat& gray) override {
    EXPECT_EQ(gray.type(), CV_8UC1);
    return points;
  }
};

RgbdImage Blank(const RgbdSensor& sensor) {
  const cv::Size size(sensor.camera.width, sensor.camera.height);
  return {0, cv::Mat(size, CV_8UC3, cv::Scalar::all(90)), cv::Mat(size, CV_32FC1, cv::Scalar(2.0))};
}

std::shared_ptr<const FrameFeatures> Build(const std::shared_ptr<PointExtractor>& points) {
  const RgbdSensor sensor;
  return FrameBuilder(sensor, {.use_lines = false}, points).Build(Blank(sensor));
}

TEST(PointExtractor, ItsPointsAreThoseOfTheFrameWithDepthAndBits) {
  const auto parrot = std::make_shared<Parrot>();
  parrot->said.low_contrast_response = 2.0F;
  const auto features = Build(parrot);
  ASSERT_EQ(features->points.size(), 2U);
  const PointFeature& first = features->points[0];
  EXPECT_EQ(first.uv, Eigen::Vector2d(10.25, 20.5)) << "to the fraction of a pixel";
  EXPECT_EQ(first.depth, 2.0);
  EXPECT_EQ(first.octave, 1);
  EXPECT_EQ(first.angle, 30.0F);
  EXPECT_FALSE(first.low_contrast);
  EXPECT_LT(features->points[1].angle, 0.0F) << "none";
  EXPECT_TRUE(features->points[1].low_contrast);
  EXPECT_EQ(features->point_descriptors.size(), cv::Size(32, 2));
  // (1, 2, 3, 4) and (4, 3, 2, 1) are opposite after their mean is removed.
  EXPECT_EQ(cv::norm(features->point_descriptors.row(0), features->point_descriptors.row(1),
                     cv::NORM_HAMMING),
            256.0);
}

TEST(PointExtractor, OrbGivenIsOrbBuiltIn) {
  RgbdImage image = Blank({});
  std::mt19937 rng(3);
  for (int i = 0; i < 200; ++i) {
    const cv::Rect box(static_cast<int>(rng() % 600), static_cast<int>(rng() % 440), 30, 20);
    cv::rectangle(image.bgr, box, cv::Scalar::all(static_cast<double>(rng() % 256)), cv::FILLED);
  }
  const auto built_in = FrameBuilder({}, {}).Build(image);
  const auto given = FrameBuilder({}, {}, std::make_shared<OrbExtractor>()).Build(image);
  ASSERT_EQ(given->points.size(), built_in->points.size());
  ASSERT_GT(given->points.size(), 300U);
  for (std::size_t i = 0; i < given->points.size(); ++i) {
    EXPECT_EQ(given->points[i].uv, built_in->points[i].uv);
    EXPECT_EQ(given->points[i].octave, built_in->points[i].octave);
    EXPECT_EQ(given->points[i].low_contrast, built_in->points[i].low_contrast);
  }
  EXPECT_EQ(cv::norm(given->point_descriptors, built_in->point_descriptors, cv::NORM_HAMMING), 0.0);
}

TEST(PointExtractor, NoPointsAreFine) {
  const auto parrot = std::make_shared<Parrot>();
  parrot->points = {};
  EXPECT_TRUE(Build(parrot)->points.empty());
}

struct Fault {
  const char* says;
  std::function<void(Parrot&)> make;
};

TEST(PointExtractor, AnErrorNamesTheExtractorAndItsFault) {
  const Fault faults[] = {
      {"keypoint 1 is at (639.6, 50), outside of the image of 640 x 480",
       [](Parrot& p) { p.points.keypoints[1].pt.x = 639.6F; }},
      {"keypoint 0 is at (10.25, -0.6), outside",
       [](Parrot& p) { p.points.keypoints[0].pt.y = -0.6F; }},
      {"keypoint 1 is at no finite place", [](Parrot& p) { p.points.keypoints[1].pt.y = kNan; }},
      {"keypoint 0 has octave 2, but FeatureType::pyramid has 2 levels from 0",
       [](Parrot& p) { p.points.keypoints[0].octave = 2; }},
      {"keypoint 0 has octave -1", [](Parrot& p) { p.points.keypoints[0].octave = -1; }},
      {"keypoint 1 has no angle of 0 to 360",
       [](Parrot& p) { p.points.keypoints[1].angle = kNan; }},
      {"keypoint 1 has no finite response",
       [](Parrot& p) { p.points.keypoints[1].response = kNan; }},
      {"2 keypoints have 1 rows of descriptors",
       [](Parrot& p) { p.points.descriptors = p.points.descriptors.row(0); }},
      {"2 keypoints have 0 rows of descriptors",
       [](Parrot& p) { p.points.descriptors = cv::Mat(); }},
      {"descriptors are not CV_32F, as FeatureType::descriptor says",
       [](Parrot& p) { p.points.descriptors = cv::Mat::zeros(2, 4, CV_8U); }},
      {"descriptors are not CV_8U, as FeatureType::descriptor says",
       [](Parrot& p) { p.said.descriptor = DescriptorType::kBinary; }},
      {"descriptors have 4 columns, not 5 as FeatureType::columns says",
       [](Parrot& p) { p.said.columns = 5; }},
      {"the descriptor of keypoint 1 has a value that is not finite",
       [](Parrot& p) { p.points.descriptors.at<float>(1, 3) = kNan; }},
  };
  for (const Fault& fault : faults) {
    const auto parrot = std::make_shared<Parrot>();
    fault.make(*parrot);
    const std::string message = testing::MessageOf<InvalidArgument>([&] { Build(parrot); });
    EXPECT_TRUE(message.starts_with(std::string("points by parrot: ") + fault.says)) << message;
  }
}

TEST(PointExtractor, AKindThatNoneIsIsRefusedAtOnce) {
  const Fault faults[] = {
      {"FeatureType::name must have 1 to 64 printable", [](Parrot& p) { p.said.name.clear(); }},
      {"FeatureType::name must have 1 to 64 printable", [](Parrot& p) { p.said.name = "a\nb"; }},
      {"points by parrot: FeatureType::columns must be 2 to 4096, is 1",
       [](Parrot& p) { p.said.columns = 1; }},
      {"points by parrot: PyramidOptions::levels", [](Parrot& p) { p.said.pyramid.levels = 17; }},
      {"points by parrot: PyramidOptions::scale_factor",
       [](Parrot& p) { p.said.pyramid.scale_factor = 1.0; }},
  };
  for (const Fault& fault : faults) {
    const auto parrot = std::make_shared<Parrot>();
    fault.make(*parrot);
    const std::string message =
        testing::MessageOf<InvalidArgument>([&] { FrameBuilder({}, {}, parrot); });
    EXPECT_TRUE(message.starts_with(fault.says)) << message;
  }
}

}  // namespace
}  // namespace highwall::point_extractor_test
