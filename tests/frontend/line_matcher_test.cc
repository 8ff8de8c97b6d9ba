#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/features/line_matcher.h>

namespace highwall::line_matcher_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;

LineSegment Segment(double x, double y, double length, double angle) {
  const Eigen::Vector2d half = 0.5 * length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d middle(x, y);
  return {(middle - half).cast<float>(), (middle + half).cast<float>()};
}

LineSegment Swapped(const LineSegment& segment) {
  return {segment.e, segment.s};
}

// Sets a descriptor with the lowest `bits` bits set.
void SetDescriptor(cv::Mat* descriptors, int row, int bits) {
  descriptors->row(row).setTo(0);
  for (int i = 0; i < bits; ++i) {
    descriptors->at<std::uint8_t>(row, i / 8) |= static_cast<uchar>(1U << (i % 8));
  }
}

std::vector<FeatureMatch> Identity(int count) {
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < count; ++i) matches.push_back({i, i, 0});
  return matches;
}

TEST(LineAngleDifference, WrapsModuloPi) {
  EXPECT_NEAR(LineAngleDifference(0.3, 0.1), 0.2, 1e-15);
  EXPECT_NEAR(LineAngleDifference(0.01, kPi - 0.01), 0.02, 1e-15);
  EXPECT_NEAR(LineAngleDifference(kPi - 0.01, 0.01), -0.02, 1e-15);
  EXPECT_NEAR(LineAngleDifference(7.0 * kPi + 0.2, -4.0 * kPi), 0.2, 1e-14);
  EXPECT_NEAR(std::abs(LineAngleDifference(kPi / 2, 0.0)), kPi / 2, 1e-15);
}

TEST(LineGates, AngleGateIsOpenBelowAlphaAndAcrossTheWrap) {
  const LineGates gates{.max_angle = 10.0 * kDegree};
  const LineSegment a = Segment(100, 100, 50, 4.0 * kDegree);
  EXPECT_TRUE(PassesAngleGate(a, Segment(100, 100, 50, 13.9 * kDegree), gates));
  EXPECT_FALSE(PassesAngleGate(a, Segment(100, 100, 50, 14.1 * kDegree), gates));
  EXPECT_TRUE(PassesAngleGate(a, Segment(100, 100, 50, 174.1 * kDegree), gates));
  EXPECT_FALSE(PassesAngleGate(a, Segment(100, 100, 50, 173.9 * kDegree), gates));
}

TEST(LineGates, AngleGateDoesNotSeeWhichEndComesFirst) {
  const LineGates gates{.max_angle = 10.0 * kDegree};
  const LineSegment a = Segment(100, 100, 50, 30.0 * kDegree);
  const LineSegment b = Segment(100, 100, 50, 35.0 * kDegree);
  EXPECT_TRUE(PassesAngleGate(a, Swapped(b), gates));
  EXPECT_TRUE(PassesAngleGate(Swapped(a), b, gates));
}

TEST(LineGates, LengthGateIsSymmetric) {
  const LineGates gates{.min_length_ratio = 0.5};
  const LineSegment a = Segment(0, 0, 100, 0);
  EXPECT_TRUE(PassesLengthGate(a, Segment(0, 0, 51, 0), gates));
  EXPECT_FALSE(PassesLengthGate(a, Segment(0, 0, 49, 0), gates));
  EXPECT_FALSE(PassesLengthGate(Segment(0, 0, 49, 0), a, gates));
  EXPECT_FALSE(PassesLengthGate(LineSegment(), LineSegment(), gates));
}

TEST(LineGates, MidpointGateLiesAroundThePrediction) {
  const LineGates gates{.max_midpoint_distance = 10.0};
  const LineSegment b = Segment(200, 100, 50, 1.0);
  EXPECT_TRUE(PassesMidpointGate({200.0F, 109.9F}, b, gates));
  EXPECT_FALSE(PassesMidpointGate({200.0F, 110.1F}, b, gates));
}

TEST(LineMatcher, SmallMotionWithoutDescriptorsChoosesTheNearestOneToOne) {
  LineFeatures query, train;
  query.segments = {Segment(100, 100, 60, 0.50), Segment(110, 100, 60, 0.50)};
  train.segments = {Segment(300, 300, 60, 0.50), Segment(112, 100, 60, 0.51),
                    Segment(102, 100, 60, 0.51)};
  const auto matches = MatchSmallMotion(query, train);
  ASSERT_EQ(matches.size(), 2U);
  EXPECT_EQ(matches[0], (FeatureMatch{0, 2, 0}));
  EXPECT_EQ(matches[1], (FeatureMatch{1, 1, 0}));
}

TEST(LineMatcher, SmallMotionPrefersTheBetterDescriptorWithinTheGates) {
  LineFeatures query, train;
  query.segments = {Segment(100, 100, 60, 0.5)};
  train.segments = {Segment(101, 100, 60, 0.5), Segment(110, 100, 60, 0.5),
                    Segment(400, 100, 60, 0.5)};
  query.descriptors.create(1, 32, CV_8U);
  train.descriptors.create(3, 32, CV_8U);
  SetDescriptor(&query.descriptors, 0, 0);
  SetDescriptor(&train.descriptors, 0, 40);
  SetDescriptor(&train.descriptors, 1, 12);
  SetDescriptor(&train.descriptors, 2, 0);  // identical, but outside of the gates
  const auto matches = MatchSmallMotion(query, train);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0], (FeatureMatch{0, 1, 12}));
}

TEST(LineMatcher, PredictedMidpointsMoveTheGate) {
  LineFeatures query, train;
  query.segments = {Segment(100, 100, 60, 0.5)};
  train.segments = {Segment(400, 100, 60, 0.5)};
  EXPECT_TRUE(MatchSmallMotion(query, train).empty());
  EXPECT_EQ(MatchSmallMotion(query, train, {}, {{395.0F, 100.0F}}).size(), 1U);
  EXPECT_THROW(MatchSmallMotion(query, train, {}, {{0, 0}, {0, 0}}), InvalidArgument);
}

class LargeMotion : public ::testing::Test {
 protected:
  // Matches one query against two candidates, `first` and `second` bits away.
  std::vector<FeatureMatch> Match(int first, int second, const LineMatcherOptions& options = {}) {
    LineFeatures query, train;
    query.segments = {Segment(100, 100, 60, 0.5)};
    train.segments = {Segment(180, 100, 60, 0.8), Segment(190, 100, 60, 0.8)};
    query.descriptors = cv::Mat(1, 32, CV_8U, cv::Scalar(0));
    train.descriptors.create(2, 32, CV_8U);
    SetDescriptor(&train.descriptors, 0, first);
    SetDescriptor(&train.descriptors, 1, second);
    return MatchLargeMotion(query, train, options);
  }
};

TEST_F(LargeMotion, TakesTheNearestDescriptorThatPassesTheRatioTest) {
  EXPECT_EQ(Match(40, 60), (std::vector<FeatureMatch>{{0, 0, 40}}));
  EXPECT_TRUE(Match(40, 45).empty());
  EXPECT_EQ(Match(40, 45, {.ratio = 1.0}).size(), 1U);
}

TEST_F(LargeMotion, DropsDescriptorsThatAreTooFarApart) {
  EXPECT_EQ(Match(80, 200).size(), 1U);
  EXPECT_TRUE(Match(81, 200).empty());
}

TEST_F(LargeMotion, KeepsMutualMatchesOnly) {
  LineFeatures query, train;
  query.segments = {Segment(100, 100, 60, 0.5), Segment(105, 100, 60, 0.5)};
  train.segments = {Segment(100, 110, 60, 0.5)};
  query.descriptors.create(2, 32, CV_8U);
  SetDescriptor(&query.descriptors, 0, 20);
  SetDescriptor(&query.descriptors, 1, 5);
  train.descriptors = cv::Mat(1, 32, CV_8U, cv::Scalar(0));
  EXPECT_EQ(MatchLargeMotion(query, train), (std::vector<FeatureMatch>{{1, 0, 5}}));
}

TEST_F(LargeMotion, NeedsDescriptors) {
  LineFeatures plain;
  plain.segments = {Segment(100, 100, 60, 0.5)};
  EXPECT_THROW(MatchLargeMotion(plain, plain), InvalidArgument);
  EXPECT_TRUE(MatchLargeMotion(LineFeatures(), LineFeatures()).empty());
  plain.descriptors = cv::Mat(2, 32, CV_8U, cv::Scalar(0));  // one row too many
  EXPECT_THROW(MatchLargeMotion(plain, plain), InvalidArgument);
}

class MadRejection : public ::testing::Test {
 protected:
  // Makes 21 segments of all directions that rotate by `rotation` and a little noise; the last
  // three rotate by `outlier` more.
  void Turn(double rotation, double outlier) {
    std::mt19937 rng(11);
    std::normal_distribution<double> noise(0.0, 1.0 * kDegree);
    for (int i = 0; i < 21; ++i) {
      const double angle = i * kPi / 21.0;
      const double extra = i >= 18 ? outlier : noise(rng);
      query_.push_back(Segment(20.0 * i, 100, 50, angle));
      train_.push_back(Segment(20.0 * i + 5, 103, 50, angle + rotation + extra));
      if (i % 2 == 0) train_.back() = Swapped(train_.back());
    }
  }

  std::vector<LineSegment> query_, train_;
};

TEST_F(MadRejection, DropsSegmentsThatTurnOtherwise) {
  Turn(4.0 * kDegree, 12.0 * kDegree);
  EXPECT_EQ(RejectByMad(Identity(21), query_, train_), Identity(18));
}

TEST_F(MadRejection, WorksWhereTheRotationWraps) {
  Turn(90.0 * kDegree, 12.0 * kDegree);
  EXPECT_EQ(RejectByMad(Identity(21), query_, train_), Identity(18));
}

TEST_F(MadRejection, LimitGrowsWithK) {
  Turn(4.0 * kDegree, 12.0 * kDegree);
  EXPECT_EQ(RejectByMad(Identity(21), query_, train_, {.mad_k = 50.0}), Identity(21));
  EXPECT_LT(RejectByMad(Identity(21), query_, train_, {.mad_k = 0.5}).size(), 15U);
}

TEST_F(MadRejection, KeepsNoiseWhenMostRotationsAreEqual) {
  for (int i = 0; i < 10; ++i) {
    query_.push_back(Segment(20.0 * i, 100, 50, 0.3));
    train_.push_back(Segment(20.0 * i, 100, 50, i == 9 ? 0.3 + kDegree : 0.3));
  }
  EXPECT_EQ(RejectByMad(Identity(10), query_, train_), Identity(10));
  EXPECT_EQ(RejectByMad(Identity(10), query_, train_, {.min_deviation = 0.0}), Identity(9));
}

TEST_F(MadRejection, LeavesFewerThanThreeMatchesAlone) {
  Turn(0.0, 1.0);
  const std::vector<FeatureMatch> two = {{0, 0, 0}, {20, 20, 0}};
  EXPECT_EQ(RejectByMad(two, query_, train_), two);
}

// The rule as printed uses the displacement of the start: it drops the segment that moved the other
// way and cannot detect one that rotated about its start.
TEST_F(MadRejection, PaperRuleMeasuresTheDirectionOfDisplacement) {
  for (int i = 0; i < 20; ++i) {
    const LineSegment a = Segment(20.0 * i, 100, 50, 0.5);
    const Eigen::Vector2f motion = i == 7 ? Eigen::Vector2f(-10, 1) : Eigen::Vector2f(10, 1);
    query_.push_back(a);
    train_.push_back({a.s + motion, a.e + motion});
  }
  train_[3].e = train_[3].s + Eigen::Vector2f(0.0F, 50.0F);
  train_[5] = Swapped(train_[5]);
  const auto paper = RejectByMad(Identity(20), query_, train_, {.mad_rule = MadRule::kPaper});
  const auto median = RejectByMad(Identity(20), query_, train_);
  std::vector<FeatureMatch> without_7 = Identity(20), without_3 = Identity(20);
  without_7.erase(without_7.begin() + 7);
  without_3.erase(without_3.begin() + 3);
  EXPECT_EQ(paper, without_7);
  EXPECT_EQ(median, without_3);
}

// One gross outlier among few inflates the standard deviation so much that it hides itself: with n
// matches no deviation exceeds sqrt(n - 1) of it.
TEST_F(MadRejection, PaperRuleIsMaskedByItsOutliers) {
  for (int i = 0; i < 8; ++i) {
    const LineSegment a = Segment(20.0 * i, 100, 50, 0.5);
    const Eigen::Vector2f motion = i == 7 ? Eigen::Vector2f(-10, 1) : Eigen::Vector2f(10, 1);
    query_.push_back(a);
    train_.push_back({a.s + motion, a.e + motion});
  }
  EXPECT_EQ(RejectByMad(Identity(8), query_, train_, {.mad_rule = MadRule::kPaper}), Identity(8));
}

TEST(LineMatcherOptions, NamesTheFieldThatIsOutOfRange) {
  const auto message = [](LineMatcherOptions options) -> std::string {
    try {
      options.Validate();
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "");
  EXPECT_NE(message({.small_motion = {.max_angle = 2.0}}).find("max_angle"), std::string::npos);
  EXPECT_NE(message({.large_motion = {.min_length_ratio = 1.0}}).find("min_length_ratio"),
            std::string::npos);
  EXPECT_NE(message({.small_motion = {.max_midpoint_distance = 0.0}}).find("max_midpoint"),
            std::string::npos);
  EXPECT_NE(message({.max_distance = -1}).find("max_distance"), std::string::npos);
  EXPECT_NE(message({.ratio = 1.5}).find("ratio"), std::string::npos);
  EXPECT_NE(message({.mad_k = 0.0}).find("mad_k"), std::string::npos);
  EXPECT_NE(message({.min_deviation = -1.0}).find("min_deviation"), std::string::npos);
}

}  // namespace
}  // namespace highwall::line_matcher_test
