#include <gtest/gtest.h>

#include "system/frame_clock.h"

namespace highwall::frame_clock_test {
namespace {

// Returns the clock after frames that are `interval` [s] apart.
FrameClock After(double interval, int frames = 40) {
  FrameClock clock;
  for (int i = 0; i < frames; ++i) clock.Add(FromSeconds(i * interval));
  return clock;
}

TEST(FrameClock, MeasuresInSecondsWhereACameraIsFasterThanOneHertz) {
  for (const double interval : {0.01, 1.0 / 30.0, 0.5, 0.99}) {
    EXPECT_EQ(After(interval).Seconds(0, 2'000'000'000), 2.0) << interval;
  }
}

TEST(FrameClock, CountsFramesAtThirtyHertzWhereTheyAreFartherApart) {
  for (const double interval : {1.0, 33.0, 33'333.0}) {
    EXPECT_NEAR(After(interval).Seconds(0, FromSeconds(6 * interval)), 0.2, 1e-9) << interval;
  }
}

TEST(FrameClock, AFewPausesAreNoRate) {
  FrameClock clock;
  Stamp stamp = 0;
  for (int i = 0; i < 200; ++i) {
    stamp += i % 5 < 2 ? 60'000'000'000 : 33'000'000;
    clock.Add(stamp);
    EXPECT_EQ(clock.Seconds(0, 1'000'000'000), 1.0) << i;
  }
}

TEST(FrameClock, TheFirstFramesSayNothing) {
  EXPECT_EQ(After(33.0, 9).Seconds(0, 1'000'000'000), 1.0);
  EXPECT_LT(After(33.0, 10).Seconds(0, 1'000'000'000), 1.0);
}

}  // namespace
}  // namespace highwall::frame_clock_test
