#include <highwall/factors/imu_buffer.h>

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::imu_buffer_test {
namespace {

constexpr Stamp kMs = 1'000'000;

// The gyroscope reads the time in seconds along x, and the accelerometer ten times that along z.
ImuSample At(Stamp stamp) {
  const double t = ToSeconds(stamp);
  return {stamp, {t, 0.0, 0.0}, {0.0, 0.0, 10.0 * t}};
}

ImuBuffer Filled(const std::vector<Stamp>& stamps, const ImuBufferOptions& options = {}) {
  ImuBuffer buffer(options);
  for (const Stamp stamp : stamps) buffer.Add(At(stamp));
  return buffer;
}

std::vector<Stamp> Stamps(const ImuInterval& interval) {
  std::vector<Stamp> stamps;
  for (const ImuSample& sample : interval.samples) stamps.push_back(sample.stamp);
  return stamps;
}

TEST(ImuBuffer, InterpolatesAtTheImageStamps) {
  const auto interval = Filled({0, 5 * kMs, 10 * kMs, 15 * kMs}).Between(2 * kMs, 11 * kMs);
  ASSERT_TRUE(interval);
  EXPECT_EQ(Stamps(*interval), (std::vector<Stamp>{2 * kMs, 5 * kMs, 10 * kMs, 11 * kMs}));
  for (const ImuSample& sample : interval->samples) {
    EXPECT_NEAR(sample.gyroscope.x(), ToSeconds(sample.stamp), 1e-17);
    EXPECT_NEAR(sample.accelerometer.z(), 10.0 * ToSeconds(sample.stamp), 1e-16);
  }
  EXPECT_NEAR(interval->largest_step, 0.005, 1e-15);
  EXPECT_FALSE(interval->HasGap());
}

TEST(ImuBuffer, TakesReadingsAtTheEndsAsTheyAre) {
  const auto interval = Filled({0, 5 * kMs, 10 * kMs}).Between(0, 10 * kMs);
  ASSERT_TRUE(interval);
  EXPECT_EQ(Stamps(*interval), (std::vector<Stamp>{0, 5 * kMs, 10 * kMs}));
}

TEST(ImuBuffer, CutsAnIntervalBetweenTwoReadings) {
  const auto interval = Filled({0, 5 * kMs, 10 * kMs}).Between(6 * kMs, 8 * kMs);
  ASSERT_TRUE(interval);
  EXPECT_EQ(Stamps(*interval), (std::vector<Stamp>{6 * kMs, 8 * kMs}));
  EXPECT_NEAR(interval->samples[0].gyroscope.x(), 0.006, 1e-17);
}

TEST(ImuBuffer, NeighbouringIntervalsShareTheirEnd) {
  const ImuBuffer buffer = Filled({0, 5 * kMs, 10 * kMs, 15 * kMs});
  const auto a = buffer.Between(1 * kMs, 7 * kMs), b = buffer.Between(7 * kMs, 14 * kMs);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->samples.back().gyroscope, b->samples.front().gyroscope);
}

TEST(ImuBuffer, IsEmptyForAnIntervalThatItDoesNotCover) {
  const ImuBuffer buffer = Filled({5 * kMs, 10 * kMs});
  EXPECT_FALSE(buffer.Between(4 * kMs, 8 * kMs));
  EXPECT_FALSE(buffer.Between(6 * kMs, 11 * kMs));
  EXPECT_TRUE(buffer.Between(5 * kMs, 10 * kMs));
  EXPECT_FALSE(ImuBuffer().Between(0, 1));
}

TEST(ImuBuffer, ReportsGapsAboveATenthOfASecond) {
  const ImuBuffer buffer = Filled({0, 5 * kMs, 106 * kMs, 110 * kMs, 210 * kMs});
  const auto interval = buffer.Between(0, 210 * kMs);
  ASSERT_TRUE(interval);
  // 101 ms is a gap, and 100 ms is not.
  EXPECT_EQ(interval->gaps, 1);
  EXPECT_NEAR(interval->largest_step, 0.101, 1e-12);
  // A gap also counts for an interval inside it.
  EXPECT_TRUE(buffer.Between(50 * kMs, 60 * kMs)->HasGap());
  EXPECT_FALSE(buffer.Between(106 * kMs, 110 * kMs)->HasGap());
}

TEST(ImuBuffer, PutsLateReadingsInTheirPlace) {
  ImuBuffer buffer = Filled({0, 10 * kMs});
  EXPECT_EQ(buffer.Add(At(5 * kMs)), ImuSampleStatus::kReordered);
  EXPECT_EQ(Stamps(*buffer.Between(0, 10 * kMs)), (std::vector<Stamp>{0, 5 * kMs, 10 * kMs}));
  EXPECT_EQ(buffer.newest(), 10 * kMs);
}

TEST(ImuBuffer, KeepsTheFirstOfDuplicates) {
  ImuBuffer buffer = Filled({0, 5 * kMs});
  ImuSample other = At(5 * kMs);
  other.gyroscope.x() = 9.0;
  EXPECT_EQ(buffer.Add(other), ImuSampleStatus::kDuplicate);
  EXPECT_EQ(buffer.size(), 2u);
  EXPECT_NEAR(buffer.Between(0, 5 * kMs)->samples.back().gyroscope.x(), 0.005, 1e-17);
}

TEST(ImuBuffer, DropsReadingsThatAreNotFinite) {
  ImuBuffer buffer;
  ImuSample bad = At(0);
  bad.accelerometer.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(buffer.Add(bad), ImuSampleStatus::kNotFinite);
  bad = At(0);
  bad.gyroscope.y() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(buffer.Add(bad), ImuSampleStatus::kNotFinite);
  EXPECT_TRUE(buffer.empty());
}

TEST(ImuBuffer, DropsReadingsThatNoSensorMeasures) {
  ImuBuffer buffer;
  ImuSample reading = At(0);
  for (const double value : {kMaxSpecificForce * 1.0001, -1e6, 1e300}) {
    reading.accelerometer.z() = value;
    EXPECT_EQ(buffer.Add(reading), ImuSampleStatus::kImpossible) << value;
  }
  reading = At(0);
  reading.gyroscope.x() = -kMaxAngularRate * 1.0001;
  EXPECT_EQ(buffer.Add(reading), ImuSampleStatus::kImpossible);
  EXPECT_TRUE(buffer.empty());
  reading.gyroscope.x() = -kMaxAngularRate;
  reading.accelerometer.setConstant(kMaxSpecificForce);
  EXPECT_EQ(buffer.Add(reading), ImuSampleStatus::kAdded) << "the bounds themselves are possible";
}

ImuSample Still(Stamp stamp) {
  return {stamp, {0.0, 0.0, 0.0}, {0.0, 0.0, 9.8}};
}

// Number of readings, one every 5 ms, in the horizon of 30 s with both ends included.
constexpr std::size_t kHeld = 6001;

// Feeds 100 s of readings, one every 5 ms, with one more of this stamp among them, which must be
// rejected without an effect on the others.
void ExpectToDropOnly(Stamp wrong) {
  ImuBuffer buffer;
  for (Stamp stamp = 0; stamp < 100'000 * kMs; stamp += 5 * kMs) {
    ASSERT_EQ(buffer.Add(Still(stamp)), ImuSampleStatus::kAdded) << wrong << " at " << stamp;
    if (stamp != 40'000 * kMs) continue;
    const ImuSampleStatus status = buffer.Add(Still(wrong));
    EXPECT_TRUE(status == ImuSampleStatus::kJumped || status == ImuSampleStatus::kImpossible)
        << wrong << ": " << ToString(status);
    EXPECT_NE(std::string(Advice(status)), "");
  }
  EXPECT_EQ(buffer.size(), kHeld);
  EXPECT_EQ(buffer.newest(), 99'995 * kMs);
  EXPECT_FALSE(buffer.Between(99'000 * kMs, 99'995 * kMs)->HasGap());
}

TEST(ImuBuffer, DropsAStampThatJumpsAndKeepsTheOthers) {
  constexpr Stamp kHour = 3'600'000 * kMs;
  for (const Stamp wrong :
       {Stamp{55'000 * kMs}, kHour, 24 * 365 * kHour, Stamp{4'000'000'000'000'000'000},
        std::numeric_limits<Stamp>::max(), -kHour, std::numeric_limits<Stamp>::min()}) {
    ExpectToDropOnly(wrong);
  }
}

TEST(ImuBuffer, SeveralStampsThatJumpAreDroppedTogetherOrApart) {
  ImuBuffer buffer;
  for (int i = 0; i < 20'000; ++i) {
    const Stamp stamp = i * 5 * kMs;
    EXPECT_EQ(buffer.Add(Still(stamp)), ImuSampleStatus::kAdded);
    if (i % 1000 >= 5) continue;
    EXPECT_EQ(buffer.Add(Still(stamp + 3'600'000 * kMs)), ImuSampleStatus::kJumped);
  }
  EXPECT_EQ(buffer.size(), kHeld);
}

TEST(ImuBuffer, FollowsAClockThatMovedForGood) {
  for (const Stamp by : {3'600'000 * kMs, -3'600'000 * kMs}) {
    ImuBuffer buffer;
    ImuSample reading;
    for (int i = 0; i < 2000; ++i) {
      reading.stamp = i * 5 * kMs;
      buffer.Add(reading);
    }
    int dropped = 0;
    for (int i = 2000; i < 22'000; ++i) {
      reading.stamp = i * 5 * kMs + by;
      if (buffer.Add(reading) == ImuSampleStatus::kJumped) ++dropped;
    }
    EXPECT_EQ(dropped, kReadingsAfterJump) << by;
    EXPECT_EQ(buffer.newest(), reading.stamp);
    EXPECT_EQ(buffer.size(), kHeld) << by;
  }
}

TEST(ImuBuffer, FollowsAClockThatMovedWhoseReadingsComeTwiceOrOutOfOrder) {
  for (const bool twice : {true, false}) {
    ImuBuffer buffer;
    for (int i = 0; i < 2000; ++i) buffer.Add(Still(i * 5 * kMs));
    const Stamp moved = 3'600'000 * kMs;
    int dropped = 0;
    const auto add = [&](int i) {
      if (buffer.Add(Still(moved + i * 5 * kMs)) == ImuSampleStatus::kJumped) ++dropped;
    };
    for (int i = 2000; i < 12'000; i += 2) {
      add(twice ? i : i + 1);
      add(i);
      if (twice) add(i + 1), add(i + 1);
    }
    EXPECT_LE(dropped, 2 * kReadingsAfterJump) << twice;
    EXPECT_EQ(buffer.newest(), moved + 11'999 * 5 * kMs) << twice;
    EXPECT_EQ(buffer.size(), kHeld) << twice;
  }
}

TEST(ImuBuffer, AFirstStampInTheFutureIsForgotten) {
  ImuBuffer buffer;
  ImuSample reading;
  reading.stamp = 24 * 3'600'000 * kMs;
  EXPECT_EQ(buffer.Add(reading), ImuSampleStatus::kAdded);
  for (int i = 0; i < 20'000; ++i) {
    reading.stamp = i * 5 * kMs;
    buffer.Add(reading);
  }
  EXPECT_EQ(buffer.newest(), 19'999 * 5 * kMs);
  EXPECT_EQ(buffer.size(), kHeld);
}

TEST(ImuBuffer, DropsReadingsBeyondItsHorizon) {
  ImuBuffer buffer = Filled({0, 500 * kMs, 1000 * kMs}, {.max_step = 0.1, .horizon = 1.0});
  EXPECT_EQ(buffer.oldest(), 0);
  EXPECT_EQ(buffer.Add(At(1001 * kMs)), ImuSampleStatus::kAdded);
  EXPECT_EQ(buffer.oldest(), 500 * kMs);
  EXPECT_EQ(buffer.Add(At(0)), ImuSampleStatus::kTooOld);
  EXPECT_EQ(buffer.Add(At(1)), ImuSampleStatus::kReordered);
}

TEST(ImuBuffer, ReportsTheFateOfEachReading) {
  EXPECT_STREQ(ToString(ImuSampleStatus::kAdded), "added");
  EXPECT_STREQ(ToString(ImuSampleStatus::kNotFinite), "not finite");
  EXPECT_STREQ(ToString(ImuSampleStatus::kImpossible), "impossible");
  EXPECT_STREQ(ToString(ImuSampleStatus::kJumped), "jumped");
  EXPECT_STREQ(Advice(ImuSampleStatus::kAdded), "");
}

TEST(ImuBuffer, RefusesBadArguments) {
  EXPECT_THROW(ImuBuffer({.max_step = 0.0}), InvalidArgument);
  EXPECT_THROW(ImuBuffer({.max_step = 1.0, .horizon = 0.5}), InvalidArgument);
  const ImuBuffer buffer = Filled({0, 5 * kMs});
  EXPECT_THROW(buffer.Between(5, 5), InvalidArgument);
  EXPECT_THROW(buffer.Between(5, 4), InvalidArgument);
  EXPECT_THROW(ImuBuffer().oldest(), InvalidArgument);
  EXPECT_THROW(ImuBuffer().newest(), InvalidArgument);
}

}  // namespace
}  // namespace highwall::imu_buffer_test
