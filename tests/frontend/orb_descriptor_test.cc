#include "features/orb_descriptor.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "features/orb_pattern.h"

namespace highwall::orb_descriptor_test {
namespace {

constexpr int kTests = 256;

// Returns OpenCV's descriptors of the same corners.
cv::Mat DescribeByOpenCv(const cv::Mat& image, std::vector<cv::KeyPoint> corners) {
  const auto orb = cv::ORB::create(1, 1.2F, 1, 0, 0, 2, cv::ORB::FAST_SCORE, 31);
  for (cv::KeyPoint& corner : corners) {
    corner.octave = 0;
    corner.size = 31;
  }
  cv::Mat descriptors;
  orb->compute(image, corners, descriptors);
  return descriptors;
}

bool Bit(const cv::Mat& descriptor, int test) {
  return ((descriptor.at<std::uint8_t>(0, test / 8) >> (test % 8)) & 1) != 0;
}

int DifferentBits(const cv::Mat& a, const cv::Mat& b) {
  return static_cast<int>(cv::norm(a, b, cv::NORM_HAMMING));
}

// A textured image and corners all over it, as close to its edges as extraction takes them.
cv::Mat Texture(const cv::Size& size) {
  cv::Mat image(size, CV_8UC1);
  cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {}, 3.0);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}
std::vector<cv::KeyPoint> Corners(const cv::Size& size) {
  std::vector<cv::KeyPoint> corners;
  for (int y = 17; y < size.height - 17; y += 5) {
    for (int x = 17; x < size.width - 17; x += 5) {
      const auto angle = static_cast<float>((37 * x + 11 * y) % 3600) / 10.0F;
      corners.emplace_back(cv::Point2f(static_cast<float>(x), static_cast<float>(y)), 31.0F, angle);
    }
  }
  // The outermost row and column that may hold a corner.
  corners.emplace_back(cv::Point2f(static_cast<float>(size.width - 18), 17.0F), 31.0F, 45.0F);
  corners.emplace_back(cv::Point2f(17.0F, static_cast<float>(size.height - 18)), 31.0F, 225.0F);
  return corners;
}

// Positions of the two pixels of each test along a direction, found with one edge after the other.
// A rising edge sets the bit of a test if it is between the smoothed pixels.
struct Ends {
  int first, second;
};
std::vector<std::optional<Ends>> FindTests(int dx, int dy) {
  constexpr int kSide = 101, kCentre = 50;
  const int reach = 3 * (dx + dy);  // of the smoothing
  std::vector<std::optional<Ends>> found(kTests);
  for (int at = -60; at <= 60; ++at) {
    for (const bool rises : {true, false}) {
      cv::Mat image(kSide, kSide, CV_8UC1);
      image.forEach<std::uint8_t>([&](std::uint8_t& pixel, const int* p) {
        const bool beyond = (p[1] - kCentre) * dx + (p[0] - kCentre) * dy >= at;
        pixel = beyond == rises ? 255 : 0;
      });
      const cv::Mat bits = DescribeByOpenCv(image, {{cv::Point2f(kCentre, kCentre), 31.0F, 0.0F}});
      for (int test = 0; test < kTests; ++test) {
        if (!Bit(bits, test)) continue;
        auto& ends = found[static_cast<std::size_t>(test)];
        const int low = at + reach - 1, high = at - reach;
        if (!ends) ends = rises ? Ends{low, high} : Ends{high, low};
        (rises ? ends->second : ends->first) = high;
      }
    }
  }
  return found;
}

TEST(OrbDescriptor, TestsArePairsOfPixelsOfOpenCv) {
  const auto along_x = FindTests(1, 0), along_y = FindTests(0, 1), across = FindTests(1, 1);
  for (std::size_t i = 0; i < kTests; ++i) {
    const auto [x1, y1, x2, y2] = internal::kOrbPattern[i];
    EXPECT_EQ(along_x[i].has_value(), x1 != x2) << i;
    EXPECT_EQ(along_y[i].has_value(), y1 != y2) << i;
    ASSERT_EQ(across[i].has_value(), x1 + y1 != x2 + y2) << i;
    if (along_x[i]) {
      EXPECT_TRUE(along_x[i]->first == x1 && along_x[i]->second == x2) << i;
    }
    if (along_y[i]) {
      EXPECT_TRUE(along_y[i]->first == y1 && along_y[i]->second == y2) << i;
    }
    if (across[i]) {
      EXPECT_TRUE(across[i]->first == x1 + y1 && across[i]->second == x2 + y2) << i;
    }
  }
}

// OpenCV smooths by floating-point sums, which decide a few tests of nearly equal pixels otherwise.
TEST(OrbDescriptor, AgreesWithOpenCvUpToRounding) {
  const cv::Size size(163, 121);
  const cv::Mat image = Texture(size);
  const std::vector<cv::KeyPoint> corners = Corners(size);
  const cv::Mat ours = internal::DescribeOrb(image, corners);
  const cv::Mat theirs = DescribeByOpenCv(image, corners);
  ASSERT_EQ(ours.size(), theirs.size());
  int all = 0, most = 0;
  for (int i = 0; i < ours.rows; ++i) {
    const int different = DifferentBits(ours.row(i), theirs.row(i));
    all += different;
    most = std::max(most, different);
  }
  EXPECT_LE(most, 8) << "of 256";
  EXPECT_LE(static_cast<double>(all) / ours.rows, 1.0) << "of 256";
}

TEST(OrbDescriptor, TurnsWithTheImage) {
  const cv::Mat image = Texture({101, 101});
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  const std::vector<cv::KeyPoint> corner = {{cv::Point2f(40.0F, 60.0F), 31.0F, 20.0F}};
  const std::vector<cv::KeyPoint> corner_turned = {{cv::Point2f(40.0F, 40.0F), 31.0F, 110.0F}};
  EXPECT_LE(DifferentBits(internal::DescribeOrb(image, corner),
                          internal::DescribeOrb(turned, corner_turned)),
            4)
      << "rotated coordinates are rounded";
}

TEST(OrbDescriptor, NoCornersGiveNoRows) {
  EXPECT_EQ(internal::DescribeOrb(Texture({64, 48}), {}).rows, 0);
}

}  // namespace
}  // namespace highwall::orb_descriptor_test
