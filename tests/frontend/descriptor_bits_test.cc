#include <highwall/frontend/features/orb_matcher.h>

#include "features/descriptor_bits.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace highwall::descriptor_bits_test {
namespace {

constexpr int kPairs = 400;

int Distance(const cv::Mat& bits, int a, int b) {
  return HammingDistance(bits.ptr(a), bits.ptr(b));
}

// Returns random descriptors in pairs, rows 2i and 2i + 1, whose Pearson correlation is cos(angle).
cv::Mat PairsAtAngle(int columns, double angle) {
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  cv::Mat pairs(2 * kPairs, columns, CV_32F);
  for (int i = 0; i < kPairs; ++i) {
    const auto centred = [&] {
      Eigen::VectorXd v = Eigen::VectorXd::NullaryExpr(columns, [&] { return normal(rng); });
      v.array() -= v.mean();
      return v;
    };
    const Eigen::VectorXd a = centred().normalized();
    Eigen::VectorXd across = centred();
    across = (across - across.dot(a) * a).normalized();
    const Eigen::VectorXd b = std::cos(angle) * a + std::sin(angle) * across;
    for (int c = 0; c < columns; ++c) {
      // Neither length nor mean may matter.
      pairs.at<float>(2 * i, c) = static_cast<float>(3.0 * a[c] + 0.5);
      pairs.at<float>(2 * i + 1, c) = static_cast<float>(b[c] - 0.2);
    }
  }
  return pairs;
}

class BitsOfFloats : public ::testing::TestWithParam<int> {};

TEST_P(BitsOfFloats, DifferInProportionToTheAngle) {
  const DescriptorBits bits(DescriptorType::kFloat, GetParam());
  for (const double degrees : {0.0, 10.0, 30.0, 60.0, 90.0, 150.0}) {
    const cv::Mat pairs = bits.Of(PairsAtAngle(GetParam(), degrees * M_PI / 180.0));
    ASSERT_EQ(pairs.size(), cv::Size(32, 2 * kPairs));
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < kPairs; ++i) {
      const double distance = Distance(pairs, 2 * i, 2 * i + 1);
      sum += distance;
      squares += distance * distance;
    }
    const double mean = sum / kPairs, share = degrees / 180.0;
    const double sigma = std::sqrt(256.0 * share * (1.0 - share));  // of independent planes
    // The tolerance is four sigmas of the mean, and the floats that round to the other side of a
    // plane.
    EXPECT_NEAR(mean, 256.0 * share, 4.0 * sigma / std::sqrt(kPairs) + 0.01) << degrees;
    // Orthogonal planes scatter less, never more: four sigmas of the sigma of so many samples.
    EXPECT_LE(std::sqrt(std::max(squares / kPairs - mean * mean, 0.0)),
              sigma * (1.0 + 4.0 / std::sqrt(2.0 * kPairs)) + 0.1)
        << degrees;
  }
}

INSTANTIATE_TEST_SUITE_P(Columns, BitsOfFloats, ::testing::Values(64, 128, 256, 512));

TEST(DescriptorBits, OfFloatsAreTheSameEveryTimeAndOfAView) {
  const cv::Mat floats = PairsAtAngle(128, 0.5);
  cv::Mat wide(floats.rows, 140, CV_32F, cv::Scalar(9.0));
  floats.copyTo(wide.colRange(5, 133));
  const cv::Mat a = DescriptorBits(DescriptorType::kFloat, 128).Of(floats);
  const cv::Mat b = DescriptorBits(DescriptorType::kFloat, 128).Of(wide.colRange(5, 133));
  EXPECT_EQ(cv::norm(a, b, cv::NORM_HAMMING), 0.0);
}

// Map files contain such bits: other random planes would make their descriptors incomparable.
TEST(DescriptorBits, OfFloatsAreDrawnOnceAndForAll) {
  cv::Mat squares(1, 16, CV_32F);
  for (int c = 0; c < 16; ++c) squares.at<float>(c) = static_cast<float>(c * c);
  const cv::Mat bits = DescriptorBits(DescriptorType::kFloat, 16).Of(squares);
  const std::vector<int> first(bits.ptr(0), bits.ptr(0) + 8);
  EXPECT_EQ(first, (std::vector<int>{21, 47, 153, 230, 139, 1, 191, 69}));
}

cv::Mat RandomBytes(int rows, int columns) {
  cv::Mat bytes(rows, columns, CV_8U);
  cv::RNG(5).fill(bytes, cv::RNG::UNIFORM, 0, 256);
  return bytes;
}

TEST(DescriptorBits, OfBitsStayWhereTheyAre256) {
  const cv::Mat bytes = RandomBytes(10, 32);
  const cv::Mat bits = DescriptorBits(DescriptorType::kBinary, 32).Of(bytes);
  EXPECT_EQ(cv::norm(bits, bytes, cv::NORM_HAMMING), 0.0);
}

TEST(DescriptorBits, OfFewerBitsDifferInTheSameShare) {
  const cv::Mat bytes = RandomBytes(10, 16);
  const cv::Mat bits = DescriptorBits(DescriptorType::kBinary, 16).Of(bytes);
  for (int i = 1; i < bytes.rows; ++i) {
    const double before = cv::norm(bytes.row(0), bytes.row(i), cv::NORM_HAMMING);
    EXPECT_EQ(Distance(bits, 0, i), 2 * before) << "each bit is there twice";
  }
}

TEST(DescriptorBits, OfMoreBitsDifferInTheSameShareOnAverage) {
  // A tenth of the 512 bits differs.
  cv::Mat bytes = RandomBytes(2 * kPairs, 64);
  std::mt19937 rng(2);
  for (int i = 0; i < kPairs; ++i) {
    bytes.row(2 * i).copyTo(bytes.row(2 * i + 1));
    std::vector<int> order(512);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), rng);
    for (int k = 0; k < 51; ++k) {
      const int bit = order[static_cast<std::size_t>(k)];
      bytes.at<std::uint8_t>(2 * i + 1, bit / 8) ^= static_cast<std::uint8_t>(1 << (bit % 8));
    }
  }
  const cv::Mat bits = DescriptorBits(DescriptorType::kBinary, 64).Of(bytes);
  double sum = 0.0;
  for (int i = 0; i < kPairs; ++i) sum += Distance(bits, 2 * i, 2 * i + 1);
  // Four sigmas of the mean: half of 512 bits, drawn without replacement.
  const double sigma = std::sqrt(256.0 * 0.1 * 0.9 * 0.5);
  EXPECT_NEAR(sum / kPairs, 25.5, 4.0 * sigma / std::sqrt(kPairs));
}

TEST(DescriptorBits, OfNothingAreNone) {
  EXPECT_TRUE(DescriptorBits(DescriptorType::kFloat, 128).Of(cv::Mat()).empty());
  EXPECT_TRUE(DescriptorBits(DescriptorType::kBinary, 64).Of(cv::Mat()).empty());
}

}  // namespace
}  // namespace highwall::descriptor_bits_test
