#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/features/lbd_line_extractor.h>
#include <highwall/frontend/features/orb_matcher.h>

#include "features/line_refinement.h"

namespace highwall::line_extractor_test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

void AddNoise(cv::Mat* image, double sigma, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat noise(image->size(), CV_16S);
  rng.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::add(*image, noise, *image, cv::noArray(), CV_8U);
}

// A bright rectangle on dark ground. Each side is a step under a Gaussian blur, so that its
// position is exact except near the corners.
class Rectangle {
 public:
  explicit Rectangle(double degrees) {
    constexpr float kHalfWidth = 95.0F, kHalfHeight = 70.0F;
    const Eigen::Rotation2Df R(static_cast<float>(degrees) * kPi / 180.0F);
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
      const Eigen::Vector2f corner(static_cast<float>(x) * kHalfWidth,
                                   static_cast<float>(y) * kHalfHeight);
      corners_.push_back(Eigen::Vector2f(160.3F, 120.7F) + R * corner);
    }
  }

  cv::Mat Draw() const {
    constexpr float kBlur = 0.8F;
    cv::Mat image(240, 320, CV_8U);
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        float inside = 1.0F;
        for (std::size_t i = 0; i < 4; ++i) {
          const LineSegment side = Side(i);
          const Eigen::Vector2f d = (side.e - side.s).normalized();
          const Eigen::Vector2f p(static_cast<float>(u), static_cast<float>(v));
          const float depth = d.x() * (p - side.s).y() - d.y() * (p - side.s).x();
          inside *= 0.5F * std::erfc(-depth / (kBlur * std::numbers::sqrt2_v<float>));
        }
        image.at<uchar>(v, u) = cv::saturate_cast<uchar>(50.0F + 130.0F * inside);
      }
    }
    AddNoise(&image, 1.0, 1);
    return image;
  }

  // Returns side i from corner i to the next: clockwise as seen.
  LineSegment Side(std::size_t i) const { return {corners_[i], corners_[(i + 1) % 4]}; }

 private:
  std::vector<Eigen::Vector2f> corners_;
};

float DistanceToLine(const Eigen::Vector2f& p, const LineSegment& line) {
  const Eigen::Vector2f d = (line.e - line.s).normalized();
  return std::abs(d.x() * (p.y() - line.s.y()) - d.y() * (p.x() - line.s.x()));
}

bool Equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && (a.empty() || cv::norm(a, b, cv::NORM_INF) == 0.0);
}

// Returns an image of many lines of all lengths, some of them through the border.
cv::Mat ManyLines(std::uint64_t seed) {
  cv::Mat image(240, 320, CV_8U, cv::Scalar(90));
  cv::RNG rng(seed);
  for (int i = 0; i < 40; ++i) {
    const cv::Point a(rng.uniform(-40, 360), rng.uniform(-40, 280));
    const cv::Point b(rng.uniform(-40, 360), rng.uniform(-40, 280));
    cv::line(image, a, b, cv::Scalar(rng.uniform(0, 255)), rng.uniform(2, 9), cv::LINE_AA);
  }
  AddNoise(&image, 1.0, seed);
  return image;
}

TEST(LineSegment, AngleIsThatOfTheUndirectedLine) {
  const auto angle = [](float x, float y) {
    return LineSegment{{3.0F, 4.0F}, {3.0F + x, 4.0F + y}}.Angle();
  };
  EXPECT_FLOAT_EQ(angle(1, 0), 0.0F);
  EXPECT_FLOAT_EQ(angle(-1, 0), 0.0F);
  EXPECT_FLOAT_EQ(angle(1, 1), kPi / 4);
  EXPECT_FLOAT_EQ(angle(-1, -1), kPi / 4);
  EXPECT_FLOAT_EQ(angle(0, -1), kPi / 2);
  EXPECT_FLOAT_EQ(angle(1, -1), 3 * kPi / 4);
  EXPECT_LT(angle(1, -1e-9F), kPi);
  EXPECT_FLOAT_EQ(angle(-3, -4), angle(3, 4));
}

TEST(LineExtractorOptions, NamesTheFieldThatIsOutOfRange) {
  const auto message = [](const LineExtractorOptions& options) -> std::string {
    try {
      LbdLineExtractor extractor(options);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "");
  EXPECT_NE(message({.min_length = 0.0}).find("min_length"), std::string::npos);
  EXPECT_NE(message({.max_lines = 0}).find("max_lines"), std::string::npos);
}

// An edge that is partly hidden by a small object, in a large image: 14 px of 1280 are as 7 of 640.
TEST(LineExtractor, AGapIsMeasuredByTheSizeOfTheImage) {
  cv::Mat image(960, 1280, CV_8U, cv::Scalar(60));
  cv::rectangle(image, cv::Rect(200, 400, 880, 120), cv::Scalar(180), cv::FILLED);
  cv::rectangle(image, cv::Rect(633, 390, 14, 140), cv::Scalar(120), cv::FILLED);
  cv::GaussianBlur(image, image, {}, 1.0);
  AddNoise(&image, 1.0, 3);
  const LineFeatures lines = LbdLineExtractor(LineExtractorOptions{}).Extract(image);
  ASSERT_FALSE(lines.segments.empty());
  EXPECT_GT(lines.segments.front().Length(), 800.0F);
}

// The longest segment, first too far from the second longest, reaches it by merging the third.
TEST(MergeCollinear, AMergedSegmentReachesOneThatWasTooFarBefore) {
  const auto on_x = [](float from, float to) { return LineSegment{{from, 5.0F}, {to, 5.0F}}; };
  const std::vector<LineSegment> merged =
      internal::MergeCollinear({on_x(0, 100), on_x(108, 128), on_x(136, 196)}, 10.0F);
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_EQ(merged[0].s, Eigen::Vector2f(0, 5));
  EXPECT_EQ(merged[0].e, Eigen::Vector2f(196, 5));
  EXPECT_EQ(internal::MergeCollinear({on_x(0, 100), on_x(111, 128)}, 10.0F).size(), 2U);
}

class LineExtractorTest : public ::testing::TestWithParam<LineDetector> {
 protected:
  LineFeatures Extract(const cv::Mat& image, LineExtractorOptions options = {}) const {
    options.detector = GetParam();
    return LbdLineExtractor(options).Extract(image);
  }
};

INSTANTIATE_TEST_SUITE_P(, LineExtractorTest,
                         ::testing::Values(LineDetector::kLsd, LineDetector::kEdLines),
                         [](const ::testing::TestParamInfo<LineDetector>& tested) {
                           return tested.param == LineDetector::kLsd ? "Lsd" : "EdLines";
                         });

TEST_P(LineExtractorTest, FindsTheSidesOfARectangle) {
  for (const double degrees : {0.0, 7.0, 30.0, 45.0, 80.0}) {
    const Rectangle shape(degrees);
    const LineFeatures features = Extract(shape.Draw());
    EXPECT_EQ(features.segments.size(), 4U) << degrees;
    for (std::size_t i = 0; i < 4; ++i) {
      const LineSegment side = shape.Side(i);
      const auto found = std::find_if(
          features.segments.begin(), features.segments.end(), [&](const LineSegment& segment) {
            // A tenth of a pixel is the accuracy of the refined position of a clean step edge.
            return DistanceToLine(segment.s, side) < 0.1F && DistanceToLine(segment.e, side) < 0.1F;
          });
      ASSERT_NE(found, features.segments.end()) << degrees << ", side " << i;
      EXPECT_GT(found->Length(), 0.88F * side.Length());
      EXPECT_LT(found->Length(), 1.05F * side.Length());
      // The shape is bright and lies to the left of a counter-clockwise path.
      EXPECT_LT((found->e - found->s).dot(side.e - side.s), 0.0F);
    }
  }
}

TEST_P(LineExtractorTest, FindsLinesWithinAPixelWithoutRefinement) {
  const Rectangle shape(12.0);
  const LineFeatures features = Extract(shape.Draw(), {.refine = false});
  for (std::size_t i = 0; i < 4; ++i) {
    const LineSegment side = shape.Side(i);
    EXPECT_TRUE(std::any_of(features.segments.begin(), features.segments.end(), [&](const auto& s) {
      return DistanceToLine(s.s, side) < 1.0F && DistanceToLine(s.e, side) < 1.0F;
    })) << i;
  }
}

TEST_P(LineExtractorTest, FindsNoLinesInBlankOrTinyImages) {
  for (const int value : {0, 128, 255}) {
    const LineFeatures features = Extract(cv::Mat(240, 320, CV_8U, cv::Scalar(value)));
    EXPECT_TRUE(features.segments.empty());
    EXPECT_TRUE(features.descriptors.empty());
  }
  const cv::Mat image = Rectangle(0.0).Draw();
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(5, 240), cv::Size(320, 3), cv::Size(15, 15)}) {
    EXPECT_TRUE(Extract(image(cv::Rect(cv::Point(), size)).clone()).segments.empty()) << size;
  }
}

TEST_P(LineExtractorTest, RejectsImagesThatAreEmptyOrNotGray) {
  EXPECT_THROW(Extract(cv::Mat()), InvalidArgument);
  EXPECT_THROW(Extract(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(0))), InvalidArgument);
  EXPECT_THROW(Extract(cv::Mat(240, 320, CV_16U, cv::Scalar(0))), InvalidArgument);
}

TEST_P(LineExtractorTest, DescribesLinesAtTheBorder) {
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(64, 48), cv::Size(17, 400)}) {
    cv::Mat image(size, CV_8U, cv::Scalar(30));
    cv::rectangle(image, cv::Point(2, 2), cv::Point(size.width - 3, size.height - 3),
                  cv::Scalar(200), 1);
    cv::line(image, cv::Point(0, 0), cv::Point(size.width - 1, size.height - 1), cv::Scalar(240),
             3);
    const LineFeatures features = Extract(image, {.min_length = 0.05});
    ASSERT_GT(features.segments.size(), 1U) << size;
    EXPECT_EQ(features.descriptors.rows, static_cast<int>(features.segments.size()));
    for (const LineSegment& segment : features.segments) {
      for (const Eigen::Vector2f& p : {segment.s, segment.e}) {
        EXPECT_TRUE(p.allFinite());
        // Refinement may move an end across the edge, by two pixels at most.
        EXPECT_TRUE(p.x() > -2.5F && p.x() < static_cast<float>(size.width) + 1.5F);
        EXPECT_TRUE(p.y() > -2.5F && p.y() < static_cast<float>(size.height) + 1.5F);
      }
    }
  }
}

TEST_P(LineExtractorTest, SurvivesNoiseOfAnySize) {
  cv::RNG rng(5);
  for (int i = 0; i < 30; ++i) {
    cv::Mat image(rng.uniform(16, 120), rng.uniform(16, 120), CV_8U);
    rng.fill(image, cv::RNG::UNIFORM, 0, 256);
    const LineFeatures features = Extract(image, {.min_length = 0.1});
    EXPECT_EQ(features.descriptors.rows, static_cast<int>(features.segments.size()));
  }
}

// One edge winds through the whole image.
TEST_P(LineExtractorTest, SurvivesAnEndlessEdge) {
  cv::Mat image(240, 320, CV_8U, cv::Scalar(40));
  bool to_the_right = true;
  for (int y = 10; y < 228; y += 6, to_the_right = !to_the_right) {
    const int turn = to_the_right ? 309 : 10;
    cv::line(image, cv::Point(10, y), cv::Point(309, y), cv::Scalar(200), 2);
    cv::line(image, cv::Point(turn, y), cv::Point(turn, y + 6), cv::Scalar(200), 2);
  }
  EXPECT_GT(Extract(image).segments.size(), 50U);
}

TEST_P(LineExtractorTest, KeepsTheLongestAndDropsTheShort) {
  const cv::Mat image = ManyLines(2);
  const LineFeatures all = Extract(image, {.max_lines = 1000});
  const LineFeatures few = Extract(image, {.max_lines = 10});
  ASSERT_GT(all.segments.size(), 20U);
  ASSERT_EQ(few.segments.size(), 10U);
  EXPECT_EQ(few.descriptors.rows, 10);
  for (std::size_t i = 0; i < few.segments.size(); ++i) {
    EXPECT_EQ(few.segments[i].s, all.segments[i].s);
    EXPECT_EQ(few.segments[i].e, all.segments[i].e);
  }
  for (const LineSegment& segment : all.segments) {
    EXPECT_GT(segment.Length(), 0.04F * 320.0F - 0.1F);  // refinement hardly rotates
  }
}

TEST_P(LineExtractorTest, JoinsTheFragmentsOfAnEdge) {
  cv::Mat image(240, 320, CV_8U, cv::Scalar(60));
  image(cv::Rect(40, 120, 240, 120)).setTo(160);
  image(cv::Rect(158, 100, 5, 40)).setTo(110);  // a pole of five pixels in front of the edge
  AddNoise(&image, 1.0, 3);
  const auto longest = [&](bool merge) {
    return Extract(image, {.merge = merge}).segments.at(0).Length();
  };
  EXPECT_LT(longest(false), 130.0F);
  EXPECT_GT(longest(true), 225.0F);
}

TEST_P(LineExtractorTest, ComputesDescriptorsOnDemand) {
  const LineFeatures features = Extract(ManyLines(4), {.descriptors = false});
  EXPECT_FALSE(features.segments.empty());
  EXPECT_TRUE(features.descriptors.empty());
}

TEST_P(LineExtractorTest, DoesNotDependOnTheNumberOfThreads) {
  const cv::Mat image = ManyLines(6);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const LineFeatures one = Extract(image);
  cv::setNumThreads(2);
  const LineFeatures two = Extract(image);
  cv::setNumThreads(threads);
  ASSERT_EQ(one.segments.size(), two.segments.size());
  EXPECT_TRUE(Equal(one.descriptors, two.descriptors));
  for (std::size_t i = 0; i < one.segments.size(); ++i) {
    EXPECT_EQ(one.segments[i].s, two.segments[i].s);
    EXPECT_EQ(one.segments[i].e, two.segments[i].e);
  }
}

// Half a turn reverses the scan order; the bright side defines the direction, and the descriptor is
// relative to the line.
TEST_P(LineExtractorTest, DescriptorsTurnWithTheImage) {
  const cv::Mat image = ManyLines(7);
  for (const double degrees : {15.0, 180.0}) {
    const cv::Matx23d A = cv::getRotationMatrix2D(cv::Point2f(159.5F, 119.5F), degrees, 1.0);
    cv::Mat turned;
    cv::warpAffine(image, turned, A, image.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    const LineFeatures a = Extract(image), b = Extract(turned);
    const auto matches =
        MatchDescriptors(a.descriptors, b.descriptors, {.max_distance = 60, .ratio = 0.9});
    ASSERT_GT(matches.size(), 20U) << degrees;
    std::size_t right = 0;
    for (const FeatureMatch& match : matches) {
      const LineSegment& from = a.segments[static_cast<std::size_t>(match.query)];
      const auto map = [&](const Eigen::Vector2f& p) -> Eigen::Vector2f {
        const cv::Vec2d q = A * cv::Vec3d(p.x(), p.y(), 1.0);
        return Eigen::Vector2d(q[0], q[1]).cast<float>();
      };
      const LineSegment expected{map(from.s), map(from.e)};
      const LineSegment& found = b.segments[static_cast<std::size_t>(match.train)];
      right += DistanceToLine(found.s, expected) < 1.0F &&
               DistanceToLine(found.e, expected) < 1.0F &&
               (found.e - found.s).dot(expected.e - expected.s) > 0.0F;
    }
    EXPECT_GT(right, matches.size() * 9 / 10) << degrees;
  }
}

TEST_P(LineExtractorTest, DoesNotDependOnEarlierImages) {
  LbdLineExtractor used({.detector = GetParam()});
  used.Extract(ManyLines(8));
  used.Extract(Rectangle(20.0).Draw().rowRange(0, 100).clone());
  const LineFeatures a = used.Extract(ManyLines(9)), b = Extract(ManyLines(9));
  ASSERT_EQ(a.segments.size(), b.segments.size());
  EXPECT_TRUE(Equal(a.descriptors, b.descriptors));
}

}  // namespace
}  // namespace highwall::line_extractor_test
