// Comparison of two settings: pairs over common frames, and the statistics of their ratios.
#include "paired.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "paired_statistics.h"

namespace highwall::bench::paired_test {
namespace {

TEST(PairedStatistics, BoundsOfStudentsTAreThoseOfTheTables) {
  EXPECT_NEAR(StudentBound(1), 12.7062, 5e-5);
  EXPECT_NEAR(StudentBound(2), 4.3027, 5e-5);
  EXPECT_NEAR(StudentBound(3), 3.1824, 5e-5);
  EXPECT_NEAR(StudentBound(4), 2.7764, 5e-5);
  EXPECT_NEAR(StudentBound(9), 2.2622, 5e-5);
  EXPECT_NEAR(StudentBound(30), 2.0423, 5e-5);
  EXPECT_NEAR(StudentBound(1000), 1.9623, 5e-5);
  EXPECT_THROW(StudentBound(0), InvalidArgument);
}

// Ratios 1, 2 and 4: the mean of the logarithms is ln 2, and so is their deviation.
TEST(PairedStatistics, TheIntervalOfThreeKnownRatiosIsThatOfTextbooks) {
  const double ln2 = std::numbers::ln2;
  const MeanLog mean = MeanOf({0.0, ln2, 2.0 * ln2});
  EXPECT_NEAR(Ratio(mean), 2.0, 1e-12);
  EXPECT_NEAR(mean.variance, ln2 * ln2 / 3.0, 1e-12);
  EXPECT_EQ(mean.degrees_of_freedom, 2.0);
  const std::optional<Interval> interval = RatioInterval(mean);
  ASSERT_TRUE(interval);
  const double factor = std::exp(4.302653 * ln2 / std::sqrt(3.0));
  EXPECT_NEAR(interval->low, 2.0 / factor, 1e-5);
  EXPECT_NEAR(interval->high, 2.0 * factor, 1e-4);
}

TEST(PairedStatistics, EqualRatiosHaveNoWidthAndOneRatioHasNoInterval) {
  const std::optional<Interval> none = RatioInterval(MeanOf({0.0, 0.0, 0.0}));
  ASSERT_TRUE(none);
  EXPECT_EQ(none->low, 1.0);
  EXPECT_EQ(none->high, 1.0);
  EXPECT_FALSE(RatioInterval(MeanOf({0.1})));
  EXPECT_THROW(MeanOf({}), InvalidArgument);
  EXPECT_THROW(MeanOfMeans({}), InvalidArgument);
}

TEST(PairedStatistics, SequencesHaveEqualWeightWhateverTheirVariance) {
  const MeanLog first{.mean = 0.2, .variance = 0.04, .degrees_of_freedom = 4.0};
  const MeanLog second{.mean = -0.1, .variance = 0.0001, .degrees_of_freedom = 9.0};
  const MeanLog both = MeanOfMeans({first, second});
  EXPECT_NEAR(both.mean, 0.05, 1e-15);
  EXPECT_NEAR(both.variance, 0.0401 / 4.0, 1e-15);
  // Nearly all of the variance is that of the first, and so are the degrees of freedom.
  EXPECT_NEAR(both.degrees_of_freedom, 4.02, 0.001);
  // Two equal variances have twice the degrees of freedom.
  EXPECT_NEAR(MeanOfMeans({first, first}).degrees_of_freedom, 8.0, 1e-12);
  EXPECT_NEAR(MeanOfMeans({first, first}).variance, 0.02, 1e-15);
}

TEST(PairedStatistics, OneSequenceWithoutAnIntervalLeavesAllWithoutOne) {
  EXPECT_FALSE(RatioInterval(MeanOfMeans({MeanOf({0.1}), MeanOf({0.1, 0.2})})));
  const std::optional<Interval> sure = RatioInterval(MeanOfMeans({MeanOf({0, 0}), MeanOf({0, 0})}));
  ASSERT_TRUE(sure);
  EXPECT_EQ(sure->high, 1.0);
}

constexpr Stamp kInterval = 100'000'000;  // [ns]

// A camera on a circle; `error` [m] moves every other frame away from the centre.
Trajectory Circle(int first, int end, double error = 0.0) {
  Trajectory trajectory;
  for (int i = first; i < end; ++i) {
    const double radius = 1.0 + (i % 2 == 0 ? error : -error), angle = 0.1 * i;
    const Eigen::Vector3d p(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    trajectory.push_back({kInterval * i, Pose(Eigen::Quaterniond::Identity(), p)});
  }
  return trajectory;
}

SettingRun RunOf(Trajectory trajectory) {
  return {.trajectory = std::move(trajectory), .lost = 0, .frame_ms = 1.0, .failure = {}};
}

TEST(ComparePair, ErrorsAreThoseOfTheFramesThatBothHave) {
  // A has its error where B has no pose.
  Trajectory a = Circle(0, 64, 0.01);
  a.back().pose = Pose();
  const Pair pair = ComparePair(Circle(0, 64), 5, 64, RunOf(a), RunOf(Circle(0, 62, 0.02)));
  EXPECT_EQ(pair.problem, "");
  EXPECT_EQ(pair.begin, 5U);
  EXPECT_EQ(pair.common_frames, 62U);
  EXPECT_NEAR(pair.ape_a, 0.01, 1e-4);
  EXPECT_NEAR(pair.ape_b, 0.02, 1e-4);
}

TEST(ComparePair, ARunWithLessThanHalfOfTheFramesIsNamedAndNotCompared) {
  const Trajectory truth = Circle(0, 64);
  const SettingRun whole = RunOf(Circle(0, 64, 0.01));
  EXPECT_EQ(ComparePair(truth, 0, 64, whole, RunOf(Circle(32, 64, 0.01))).problem, "");
  EXPECT_EQ(ComparePair(truth, 0, 64, whole, RunOf(Circle(33, 64, 0.01))).problem,
            "B has 31 of 64 frames in one map");
  SettingRun nothing = RunOf({});
  nothing.failure = "too dark";
  EXPECT_EQ(ComparePair(truth, 0, 64, nothing, nothing).problem,
            "A has 0 of 64 frames in one map (too dark), "
            "B has 0 of 64 frames in one map (too dark)");
}

TEST(ComparePair, RunsWithNothingInCommonAreNotCompared) {
  const Pair pair =
      ComparePair(Circle(0, 64), 0, 64, RunOf(Circle(0, 32, 0.01)), RunOf(Circle(32, 64, 0.01)));
  EXPECT_EQ(pair.common_frames, 0U);
  EXPECT_NE(pair.problem, "");
}

TEST(MeanLogRatio, OnlyPairsThatAreComparedCount) {
  Pair twice, half, bad;
  twice.ape_a = 0.01;
  twice.ape_b = 0.02;
  half.ape_a = 0.04;
  half.ape_b = 0.02;
  bad.problem = "lost";
  const std::optional<MeanLog> ratio = MeanLogRatio({twice, bad, half, twice});
  ASSERT_TRUE(ratio);
  EXPECT_NEAR(Ratio(*ratio), std::cbrt(2.0), 1e-12);
  EXPECT_EQ(ratio->degrees_of_freedom, 2.0);
  EXPECT_FALSE(MeanLogRatio({bad}));
}

}  // namespace
}  // namespace highwall::bench::paired_test
