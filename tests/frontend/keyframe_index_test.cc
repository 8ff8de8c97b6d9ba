#include <highwall/frontend/map/keyframe_index.h>

#include <string>

#include <gtest/gtest.h>
#include <highwall/core/error.h>

#include "support/id_literals.h"
#include "support/message_of.h"
#include "support/synthetic_scene.h"

namespace highwall::keyframe_index_test {
namespace {

using testing::AppendDescriptor;
using testing::RandomDescriptor;
using testing::operator""_kf;

constexpr int kPoints = 100, kLines = 30;

FrameFeatures RandomFeatures(std::mt19937& rng, int points = kPoints, int lines = kLines) {
  FrameFeatures features;
  for (int i = 0; i < points; ++i)
    AppendDescriptor(features.point_descriptors, RandomDescriptor(rng));
  for (int i = 0; i < lines; ++i)
    AppendDescriptor(features.line_descriptors, RandomDescriptor(rng));
  return features;
}

// Returns each descriptor with `bits` bits flipped, as in another view of the same place.
cv::Mat Turned(const cv::Mat& descriptors, int bits, std::mt19937& rng) {
  cv::Mat turned = descriptors.clone();
  for (int i = 0; i < turned.rows; ++i) {
    for (int b = 0; b < bits; ++b) {
      const unsigned bit = rng() % 256;
      turned.at<std::uint8_t>(i, static_cast<int>(bit / 8)) ^=
          static_cast<std::uint8_t>(1U << bit % 8);
    }
  }
  return turned;
}

class KeyFrameIndexTest : public ::testing::Test {
 protected:
  KeyFrameIndexTest() {
    for (int i = 0; i < 20; ++i) {
      features.push_back(RandomFeatures(rng));
      index.Add(KeyFrameId(i), features.back());
    }
  }

  std::mt19937 rng{7};
  std::vector<FrameFeatures> features;
  KeyFrameIndex index;
};

TEST_F(KeyFrameIndexTest, FindsAPlaceSeenAgainByPointsOrByLines) {
  FrameFeatures by_points, by_lines;
  by_points.point_descriptors = Turned(features[7].point_descriptors, 20, rng);
  by_lines.line_descriptors = Turned(features[12].line_descriptors, 20, rng);
  const auto points = index.Query(by_points), lines = index.Query(by_lines);
  ASSERT_FALSE(points.empty());
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(points[0].keyframe, 7_kf);
  EXPECT_EQ(lines[0].keyframe, 12_kf);
  // A table finds a descriptor with 20 of 256 bits flipped with probability 0.92^16 = 0.26, four
  // tables find 0.7 of them; a random one collides with 4 / 2^16.
  EXPECT_GT(points[0].score, 0.4);
  EXPECT_GT(lines[0].score, 0.4);
  EXPECT_TRUE(points.size() == 1 || points[1].score < 0.05);
}

TEST_F(KeyFrameIndexTest, PointsAndLinesAddUp) {
  FrameFeatures mixed = features[3];
  mixed.point_descriptors = features[5].point_descriptors.clone();
  // The query has 100 points of keyframe 5 and 30 lines, which count twice, of keyframe 3.
  const auto places = index.Query(mixed);
  ASSERT_GE(places.size(), 2u);
  EXPECT_EQ(places[0].keyframe, 5_kf);
  EXPECT_EQ(places[1].keyframe, 3_kf);
  EXPECT_NEAR(places[0].score, 100.0 / 160.0, 1e-12);
  EXPECT_NEAR(places[1].score, 60.0 / 160.0, 1e-12);
}

TEST_F(KeyFrameIndexTest, WordsOfManyKeyFramesHaveLittleWeight) {
  FrameFeatures common;
  AppendDescriptor(common.point_descriptors, RandomDescriptor(rng));
  for (int i = 20; i < 40; ++i) index.Add(KeyFrameId(i), common);
  FrameFeatures query = common;
  query.point_descriptors = common.point_descriptors.clone();
  AppendDescriptor(query.point_descriptors, RandomDescriptor(rng));
  const auto places = index.Query(query);
  ASSERT_EQ(places.size(), 20u);
  // The score is log(41 / 20) of 2 log(41).
  EXPECT_NEAR(places[0].score, std::log(41.0 / 20.0) / (2.0 * std::log(41.0)), 1e-12);
  EXPECT_EQ(places[0].keyframe, 39_kf) << "of equal scores the newer first";
}

TEST_F(KeyFrameIndexTest, DoesNotFindRemovedKeyFrames) {
  ASSERT_EQ(index.Query(features[7]).at(0).keyframe, 7_kf);
  index.Remove(7_kf, features[7]);
  EXPECT_EQ(index.size(), 19u);
  for (const PlaceScore& place : index.Query(features[7])) EXPECT_NE(place.keyframe, 7_kf);
  EXPECT_EQ(index.Query(features[8]).at(0).keyframe, 8_kf);
}

TEST_F(KeyFrameIndexTest, AnEmptyFrameIsSimilarToNone) {
  EXPECT_TRUE(index.Query(FrameFeatures()).empty());
  EXPECT_TRUE(KeyFrameIndex().Query(features[0]).empty());
  index.Add(20_kf, FrameFeatures());
  EXPECT_EQ(index.size(), 21u);
}

TEST(KeyFrameIndexOptions, ErrorsNameTheField) {
  const auto expect_error = [](const KeyFrameIndexOptions& options, const std::string& field) {
    testing::ExpectError(field, [&] { options.Validate(); });
  };
  EXPECT_NO_THROW(KeyFrameIndexOptions().Validate());
  expect_error({.tables = 0}, "tables");
  expect_error({.tables = 13}, "tables");
  expect_error({.max_signature_bits = 33}, "max_signature_bits");
  expect_error({.line_weight = -1.0}, "line_weight");
}

}  // namespace
}  // namespace highwall::keyframe_index_test
