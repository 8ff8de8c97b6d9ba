#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/features/orb_matcher.h>

namespace highwall::orb_matcher_test {
namespace {

cv::Mat RandomDescriptors(int rows, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> byte(0, 255);
  cv::Mat descriptors(rows, 32, CV_8U);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < 32; ++j) descriptors.at<std::uint8_t>(i, j) = static_cast<uchar>(byte(rng));
  }
  return descriptors;
}

// Flips the `bits` lowest bits of the row.
void FlipBits(cv::Mat* descriptors, int row, int bits) {
  for (int i = 0; i < bits; ++i) {
    descriptors->at<std::uint8_t>(row, i / 8) ^= static_cast<uchar>(1U << (i % 8));
  }
}

TEST(HammingDistance, CountsTheBitsThatDiffer) {
  const cv::Mat a = RandomDescriptors(1, 1);
  for (const int bits : {0, 1, 7, 8, 63, 64, 65, 128, 255, 256}) {
    cv::Mat b = a.clone();
    FlipBits(&b, 0, bits);
    EXPECT_EQ(HammingDistance(a.ptr(), b.ptr()), bits);
    EXPECT_EQ(HammingDistance(b.ptr(), a.ptr()), bits);
  }
}

TEST(HammingDistance, WorksOnUnalignedDescriptors) {
  std::vector<std::uint8_t> a(40, 0), b(40, 0);
  b[3] = 1;
  b[34] = 0x80;
  EXPECT_EQ(HammingDistance(a.data() + 3, b.data() + 3), 2);
}

TEST(MatchDescriptors, FindsAPermutation) {
  const cv::Mat query = RandomDescriptors(40, 2);
  cv::Mat train(40, 32, CV_8U);
  for (int i = 0; i < 40; ++i) query.row(i).copyTo(train.row((7 * i + 3) % 40));
  for (int i = 0; i < 40; ++i) FlipBits(&train, i, i % 5);
  const auto matches = MatchDescriptors(query, train);
  ASSERT_EQ(matches.size(), 40U);
  for (const FeatureMatch& match : matches) {
    EXPECT_EQ(match.train, (7 * match.query + 3) % 40);
    EXPECT_EQ(match.distance, match.train % 5);
  }
}

TEST(MatchDescriptors, DropsMatchesBeyondTheDistance) {
  const cv::Mat query = RandomDescriptors(1, 3);
  cv::Mat train = query.clone();
  FlipBits(&train, 0, 30);
  EXPECT_EQ(MatchDescriptors(query, train, {.max_distance = 30}).size(), 1U);
  EXPECT_TRUE(MatchDescriptors(query, train, {.max_distance = 29}).empty());
}

TEST(MatchDescriptors, DropsAmbiguousMatches) {
  const cv::Mat query = RandomDescriptors(1, 4);
  cv::Mat train = query.clone();
  train.push_back(query);
  FlipBits(&train, 0, 8);
  FlipBits(&train, 1, 10);  // 8 < 0.8 * 10 is false
  EXPECT_TRUE(MatchDescriptors(query, train, {.ratio = 0.8}).empty());
  EXPECT_EQ(MatchDescriptors(query, train, {.ratio = 0.81}).size(), 1U);
  EXPECT_EQ(MatchDescriptors(query, train, {.ratio = 1.0}).size(), 1U);
}

TEST(MatchDescriptors, MutualMatchesAreOneToOne) {
  const cv::Mat train = RandomDescriptors(1, 5);
  cv::Mat query = train.clone();
  query.push_back(train);
  FlipBits(&query, 0, 6);
  FlipBits(&query, 1, 2);
  const OrbMatcherOptions one_way{.mutual = false};
  EXPECT_EQ(MatchDescriptors(query, train, one_way).size(), 2U);
  const auto matches = MatchDescriptors(query, train);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0], (FeatureMatch{1, 0, 2}));
}

TEST(MatchDescriptors, AcceptsEmptySidesAndRejectsOtherShapes) {
  const cv::Mat some = RandomDescriptors(3, 6);
  EXPECT_TRUE(MatchDescriptors(cv::Mat(), some).empty());
  EXPECT_TRUE(MatchDescriptors(some, cv::Mat()).empty());
  EXPECT_THROW(MatchDescriptors(some, some.colRange(0, 16)), InvalidArgument);
  EXPECT_THROW(MatchDescriptors(cv::Mat(3, 32, CV_32F, cv::Scalar(0)), some), InvalidArgument);
  EXPECT_THROW(MatchDescriptors(some, some, {.max_distance = 257}), InvalidArgument);
  EXPECT_THROW(MatchDescriptors(some, some, {.ratio = 0.0}), InvalidArgument);
}

class FeatureGridTest : public ::testing::Test {
 protected:
  FeatureGridTest() {
    std::mt19937 rng(7);
    // Some lie outside of the 640 x 480 image.
    std::uniform_real_distribution<float> x(-20.0F, 660.0F), y(-20.0F, 500.0F);
    std::uniform_int_distribution<int> octave(0, 7);
    for (int i = 0; i < 1000; ++i) {
      keypoints_.emplace_back(x(rng), y(rng), 31.0F, -1.0F, 0.0F, octave(rng));
    }
  }

  std::vector<int> BruteForce(const Eigen::Vector2d& centre, double radius, int min_octave,
                              int max_octave) const {
    std::vector<int> indices;
    for (std::size_t i = 0; i < keypoints_.size(); ++i) {
      const cv::KeyPoint& k = keypoints_[i];
      if (k.octave < min_octave || k.octave > max_octave) continue;
      const double dx = k.pt.x - centre.x(), dy = k.pt.y - centre.y();
      if (dx * dx + dy * dy <= radius * radius) indices.push_back(static_cast<int>(i));
    }
    return indices;
  }

  std::vector<cv::KeyPoint> keypoints_;
};

TEST_F(FeatureGridTest, EqualsAnExhaustiveSearch) {
  const FeatureGrid grid(keypoints_, cv::Size(640, 480), 17.0);
  EXPECT_EQ(grid.size(), keypoints_.size());
  std::mt19937 rng(8);
  std::uniform_real_distribution<double> x(-50.0, 690.0), y(-50.0, 530.0), radius(0.0, 120.0);
  std::size_t found = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d centre(x(rng), y(rng));
    const double r = radius(rng);
    std::vector<int> indices = grid.Query(centre, r, 1, 5);
    std::sort(indices.begin(), indices.end());
    EXPECT_EQ(indices, BruteForce(centre, r, 1, 5));
    found += indices.size();
  }
  EXPECT_GT(found, 1000U);
}

TEST_F(FeatureGridTest, FindsNothingWhereThereIsNothing) {
  EXPECT_TRUE(FeatureGrid().Query({10.0, 10.0}, 100.0, 0, 7).empty());
  const FeatureGrid none({}, cv::Size(640, 480));
  EXPECT_TRUE(none.Query({10.0, 10.0}, 100.0, 0, 7).empty());
  const FeatureGrid grid(keypoints_, cv::Size(640, 480));
  EXPECT_TRUE(grid.Query({320.0, 240.0}, 1000.0, 8, 9).empty());
  EXPECT_TRUE(grid.Query({320.0, 240.0}, -1.0, 0, 7).empty());
  EXPECT_TRUE(grid.Query({std::nan(""), 240.0}, 50.0, 0, 7).empty());
}

TEST_F(FeatureGridTest, RejectsBadArguments) {
  EXPECT_THROW(FeatureGrid(keypoints_, cv::Size(0, 480)), InvalidArgument);
  EXPECT_THROW(FeatureGrid(keypoints_, cv::Size(640, 480), 0.0), InvalidArgument);
  keypoints_[0].pt.x = std::nanf("");
  EXPECT_THROW(FeatureGrid(keypoints_, cv::Size(640, 480)), InvalidArgument);
}

}  // namespace
}  // namespace highwall::orb_matcher_test
