#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/features/orb_extractor.h>
#include <highwall/frontend/features/orb_matcher.h>

namespace highwall::orb_extractor_test {
namespace {

// Returns smoothed noise: corners everywhere, at every scale up to a few pixels.
cv::Mat TexturedImage(int width, int height, double contrast, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat noise(height, width, CV_32F), image;
  rng.fill(noise, cv::RNG::UNIFORM, -1.0, 1.0);
  cv::GaussianBlur(noise, noise, cv::Size(0, 0), 2.0);
  cv::normalize(noise, noise, 127.5 - contrast, 127.5 + contrast, cv::NORM_MINMAX);
  noise.convertTo(image, CV_8U);
  return image;
}

bool Equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         (a.empty() || cv::norm(a, b, cv::NORM_INF) == 0.0);
}

std::size_t OccupiedCells(const std::vector<cv::KeyPoint>& keypoints, float cell) {
  std::set<std::pair<int, int>> cells;
  for (const cv::KeyPoint& k : keypoints) {
    cells.emplace(static_cast<int>(k.pt.x / cell), static_cast<int>(k.pt.y / cell));
  }
  return cells.size();
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.at(values.size() / 2);
}

TEST(OrbExtractor, NamesTheOptionThatIsOutOfRange) {
  const auto message = [](const OrbExtractorOptions& options) -> std::string {
    try {
      OrbExtractor extractor(options);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "");
  EXPECT_NE(message({.features = 0}).find("features"), std::string::npos);
  EXPECT_NE(message({.pyramid = {.levels = 17}}).find("levels"), std::string::npos);
  EXPECT_NE(message({.pyramid = {.scale_factor = 1.0}}).find("scale_factor"), std::string::npos);
  EXPECT_NE(message({.fast_threshold = 0}).find("fast_threshold"), std::string::npos);
  EXPECT_NE(message({.min_fast_threshold = 21}).find("min_fast_threshold"), std::string::npos);
}

TEST(OrbExtractor, RejectsImagesThatAreEmptyOrNotGray) {
  OrbExtractor extractor;
  EXPECT_THROW(extractor.Extract(cv::Mat()), InvalidArgument);
  EXPECT_THROW(extractor.Extract(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(0))), InvalidArgument);
  EXPECT_THROW(extractor.Extract(cv::Mat(480, 640, CV_32FC1, cv::Scalar::all(0))), InvalidArgument);
}

// Returns the same scene twice with independent noise of `sigma`.
std::pair<cv::Mat, cv::Mat> TakenTwice(const cv::Mat& scene, double sigma, std::uint64_t seed) {
  cv::RNG rng(seed);
  const auto taken = [&] {
    cv::Mat noise(scene.size(), CV_16S), image;
    rng.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
    cv::add(scene, noise, image, cv::noArray(), CV_8U);
    return image;
  };
  cv::Mat first = taken();
  return {std::move(first), taken()};
}

// Returns how many of a's corners are also in b, within 1.5 px of their level.
std::size_t NumRepeated(const ExtractedPoints& a, const ExtractedPoints& b) {
  return static_cast<std::size_t>(
      std::count_if(a.keypoints.begin(), a.keypoints.end(), [&](const cv::KeyPoint& k) {
        return std::any_of(b.keypoints.begin(), b.keypoints.end(), [&](const cv::KeyPoint& other) {
          return other.octave == k.octave && cv::norm(other.pt - k.pt) < 1.5F * k.size / 31.0F;
        });
      }));
}

// Hardly any corner reaches min_fast_threshold. Corners of pure noise would coincide by chance in 3
// of 100; the usual corners of the same scene at four times the contrast do in 59.
TEST(OrbExtractor, FindsLowContrastCornersAboveTheNoise) {
  const auto [first, second] = TakenTwice(TexturedImage(320, 240, 14.0, 5), 0.5, 6);
  OrbExtractor extractor({.pyramid = {.levels = 4}});
  const ExtractedPoints a = extractor.Extract(first), b = extractor.Extract(second);
  const auto low_contrast =
      std::count_if(a.keypoints.begin(), a.keypoints.end(), [](const auto& k) {
        return k.response < static_cast<float>(OrbExtractorOptions{}.min_fast_threshold);
      });
  EXPECT_GE(low_contrast, 900);
  EXPECT_GE(NumRepeated(a, b), 300U);
}

// The response of a corner is the highest threshold that detects it.
TEST(OrbExtractor, LooksForLowContrastCornersDownToTheNoiseOfEachLevel) {
  constexpr int kLevels = 5;
  constexpr double kSigma = 3.0;
  const auto [image, other] = TakenTwice(cv::Mat(480, 640, CV_8U, cv::Scalar(128)), kSigma, 11);
  OrbExtractor extractor({.features = 100'000, .pyramid = {.levels = kLevels}});
  std::array<double, kLevels> least;
  least.fill(1e9);
  for (const cv::KeyPoint& k : extractor.Extract(image).keypoints) {
    double& of_level = least.at(static_cast<std::size_t>(k.octave));
    of_level = std::min<double>(of_level, k.response);
  }
  cv::Mat level = image;
  for (int i = 0; i < kLevels; ++i) {
    const double scale = extractor.Scale(i);
    const cv::Size size(cvRound(640 / scale), cvRound(480 / scale));
    if (i > 0) cv::resize(level, level, size, 0, 0, cv::INTER_LINEAR_EXACT);
    cv::Scalar mean, sigma;
    cv::meanStdDev(level, mean, sigma);
    // Thresholds are integers; the estimated sigma is accurate to a tenth.
    EXPECT_GE(least.at(static_cast<std::size_t>(i)), 1.8 * sigma[0]) << i;
    EXPECT_LE(least.at(static_cast<std::size_t>(i)), 2.2 * sigma[0] + 1.0) << i;
  }
}

// Where the usual thresholds yield all requested corners, no low-contrast ones are searched.
TEST(OrbExtractor, LooksForNoLowContrastCornersWhereThereAreEnough) {
  cv::Mat image(480, 640, CV_8U);
  TexturedImage(320, 480, 127.0, 8).copyTo(image.colRange(0, 320));
  TexturedImage(320, 480, 14.0, 9).copyTo(image.colRange(320, 640));
  for (const cv::KeyPoint& k : OrbExtractor().Extract(image).keypoints) {
    EXPECT_GE(k.response, static_cast<float>(OrbExtractorOptions{}.min_fast_threshold));
  }
}

TEST(OrbExtractor, FindsNoLinesInBlankOrTinyImages) {
  OrbExtractor extractor;
  EXPECT_TRUE(extractor.Extract(cv::Mat(480, 640, CV_8U, cv::Scalar(0))).keypoints.empty());
  EXPECT_TRUE(extractor.Extract(cv::Mat(480, 640, CV_8U, cv::Scalar(200))).descriptors.empty());
  const cv::Mat image = TexturedImage(640, 480, 127.0, 1);
  for (const int side : {1, 7, 16, 31, 40}) {
    EXPECT_TRUE(extractor.Extract(image(cv::Rect(0, 0, side, side))).keypoints.empty()) << side;
    EXPECT_TRUE(extractor.Extract(image(cv::Rect(0, 0, 640, side))).keypoints.empty()) << side;
  }
  EXPECT_FALSE(extractor.Extract(image(cv::Rect(0, 0, 64, 64))).keypoints.empty());
}

TEST(OrbExtractor, FillsItsBudgetWithValidFeaturesOfAllLevels) {
  const OrbExtractorOptions options{.features = 700};
  OrbExtractor extractor(options);
  const ExtractedPoints features = extractor.Extract(TexturedImage(640, 480, 127.0, 2));
  ASSERT_EQ(features.keypoints.size(), 700U);
  EXPECT_EQ(features.descriptors.size(), cv::Size(32, 700));
  EXPECT_EQ(features.descriptors.type(), CV_8U);
  std::vector<int> per_level(8, 0);
  for (const cv::KeyPoint& k : features.keypoints) {
    EXPECT_TRUE(k.pt.x > 0.0F && k.pt.x < 639.0F && k.pt.y > 0.0F && k.pt.y < 479.0F);
    EXPECT_GE(k.angle, 0.0F);
    EXPECT_LE(k.angle, 360.0F);
    EXPECT_FLOAT_EQ(k.size, static_cast<float>(31.0 * extractor.Scale(k.octave)));
    ++per_level.at(static_cast<std::size_t>(k.octave));
  }
  EXPECT_TRUE(std::is_sorted(per_level.rbegin(), per_level.rend()));
  EXPECT_GT(per_level.back(), 0);
}

TEST(OrbExtractor, SpreadsOverTheImageWhereOpenCvStaysInTheStrongestCorner) {
  cv::Mat image = TexturedImage(640, 480, 35.0, 3);
  TexturedImage(160, 120, 127.0, 4).copyTo(image(cv::Rect(0, 0, 160, 120)));
  std::vector<cv::KeyPoint> opencv;
  cv::ORB::create(1000, 1.2F, 8)->detect(image, opencv);
  const ExtractedPoints features = OrbExtractor().Extract(image);
  const std::size_t ours = OccupiedCells(features.keypoints, 40.0F);  // of 16 x 12
  EXPECT_GT(ours, 170U);
  EXPECT_GT(ours, OccupiedCells(opencv, 40.0F) + 50);
}

TEST(OrbExtractor, LowersTheThresholdOnlyInCellsWithoutCorners) {
  cv::Mat image = TexturedImage(640, 480, 20.0, 5);
  TexturedImage(320, 480, 127.0, 6).copyTo(image(cv::Rect(0, 0, 320, 480)));
  const ExtractedPoints features = OrbExtractor({.features = 4000}).Extract(image);
  int weak_left = 0, weak_right = 0;
  for (const cv::KeyPoint& k : features.keypoints) {
    if (k.octave != 0 || k.response >= 20.0F) continue;
    // A cell may extend across the border between the halves.
    if (k.pt.x < 300.0F) ++weak_left;
    if (k.pt.x > 340.0F) ++weak_right;
  }
  EXPECT_EQ(weak_left, 0);
  EXPECT_GT(weak_right, 50);
}

// Up to the rounding of the smoothed image; see orb_descriptor_test.cc.
TEST(OrbExtractor, DescribesCornersAsOpenCvDoes) {
  const cv::Mat image = TexturedImage(320, 240, 127.0, 7);
  const ExtractedPoints features =
      OrbExtractor({.features = 200, .pyramid = {.levels = 1}, .subpixel = false}).Extract(image);
  std::vector<cv::KeyPoint> keypoints = features.keypoints;
  cv::Mat descriptors;
  cv::ORB::create(500, 1.2F, 1, 0)->compute(image, keypoints, descriptors);
  ASSERT_EQ(keypoints.size(), features.keypoints.size());
  ASSERT_EQ(descriptors.size(), features.descriptors.size());
  const double different = cv::norm(descriptors, features.descriptors, cv::NORM_HAMMING);
  EXPECT_LE(different / descriptors.rows, 1.0) << "of 256";
}

TEST(OrbExtractor, DoesNotDependOnTheNumberOfThreads) {
  const cv::Mat image = TexturedImage(640, 480, 60.0, 8);
  OrbExtractor extractor;
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const ExtractedPoints one = extractor.Extract(image);
  cv::setNumThreads(2);
  const ExtractedPoints two = extractor.Extract(image);
  cv::setNumThreads(threads);
  ASSERT_EQ(one.keypoints.size(), two.keypoints.size());
  EXPECT_TRUE(Equal(one.descriptors, two.descriptors));
  for (std::size_t i = 0; i < one.keypoints.size(); ++i) {
    EXPECT_EQ(one.keypoints[i].pt, two.keypoints[i].pt);
    EXPECT_EQ(one.keypoints[i].angle, two.keypoints[i].angle);
    EXPECT_EQ(one.keypoints[i].octave, two.keypoints[i].octave);
  }
}

// Coordinates of coarse levels must not be biased towards the origin: a mirrored image has its
// corners mirrored. (Scaling level coordinates alone would be off by 1.3 px at level 7, twice that
// here.)
TEST(OrbExtractor, MapsCoarseLevelsToPixelCentresWithoutBias) {
  const cv::Mat image = TexturedImage(640, 480, 127.0, 9);
  cv::Mat mirrored;
  cv::flip(image, mirrored, -1);
  OrbExtractor extractor;
  const ExtractedPoints a = extractor.Extract(image), b = extractor.Extract(mirrored);
  int coarse = 0, found = 0;
  for (const cv::KeyPoint& k : a.keypoints) {
    if (k.octave < 5) continue;
    ++coarse;
    found += std::any_of(b.keypoints.begin(), b.keypoints.end(), [&](const cv::KeyPoint& m) {
      return m.octave == k.octave && std::abs(639.0F - m.pt.x - k.pt.x) < 0.1F &&
             std::abs(479.0F - m.pt.y - k.pt.y) < 0.1F;
    });
  }
  ASSERT_GT(coarse, 100);
  // The rest are ties that the selection resolved otherwise; with the bias none would be found.
  EXPECT_GT(found, coarse * 6 / 10);
}

class OrbExtractorUnderRotation : public ::testing::Test {
 protected:
  static constexpr double kDegrees = 25.0;

  // Computes distances of matched corners to their true positions and changes of their angles.
  void Match(bool subpixel) {
    const cv::Mat image = TexturedImage(640, 480, 127.0, 10);
    const cv::Matx23d A = cv::getRotationMatrix2D(cv::Point2f(319.5F, 239.5F), kDegrees, 1.0);
    cv::Mat rotated;
    cv::warpAffine(image, rotated, A, image.size(), cv::INTER_CUBIC);
    OrbExtractor extractor({.subpixel = subpixel});
    const ExtractedPoints a = extractor.Extract(image), b = extractor.Extract(rotated);
    for (const FeatureMatch& match : MatchDescriptors(a.descriptors, b.descriptors)) {
      const cv::KeyPoint& from = a.keypoints[static_cast<std::size_t>(match.query)];
      const cv::KeyPoint& to = b.keypoints[static_cast<std::size_t>(match.train)];
      const cv::Vec2d expected = A * cv::Vec3d(from.pt.x, from.pt.y, 1.0);
      ++matches_;
      const double error = std::hypot(expected[0] - to.pt.x, expected[1] - to.pt.y);
      if (error > 5.0) continue;
      errors_.push_back(error);
      turns_.push_back(std::remainder(static_cast<double>(to.angle - from.angle), 360.0));
    }
  }

  std::size_t matches_ = 0;
  std::vector<double> errors_, turns_;
};

TEST_F(OrbExtractorUnderRotation, MatchesAreAtTheRightPlaceAndTurnWithTheImage) {
  Match(true);
  ASSERT_GT(errors_.size(), 150U);
  EXPECT_GT(errors_.size(), matches_ * 9 / 10);
  // cv::getRotationMatrix2D rotates counter-clockwise in the image; angles grow clockwise.
  EXPECT_NEAR(Median(turns_), -kDegrees, 1.5);
}

TEST_F(OrbExtractorUnderRotation, SubPixelCornersAreCloserToTheTruth) {
  Match(false);
  const double plain = Median(errors_);
  errors_.clear();
  Match(true);
  EXPECT_LT(Median(errors_), 0.7 * plain);
}

}  // namespace
}  // namespace highwall::orb_extractor_test
