#include "cameras/device_clock.h"

#include <cstdint>

#include <gtest/gtest.h>

namespace highwall::device_clock_test {
namespace {

using apps::DeviceClock;
using std::chrono::milliseconds;

constexpr Stamp kStart = 1'700'000'000'000'000'000;
constexpr Stamp kMs = 1'000'000;

TEST(DeviceClock, StampsCountFromTheTimeOfTheHostByTheClockOfTheDevice) {
  DeviceClock clock(kStart);
  const DeviceClock::Host::time_point now{};
  EXPECT_EQ(clock.At(5'000'000, now), kStart);
  EXPECT_EQ(clock.At(5'033'000, now + milliseconds(90)), kStart + 33 * kMs) << "it came late";
  EXPECT_EQ(clock.At(5'066'000, now + milliseconds(91)), kStart + 66 * kMs);
  EXPECT_EQ(clock.At(5'060'000, now + milliseconds(92)), kStart + 60 * kMs) << "of the other image";
  EXPECT_EQ(clock.restarts(), 0);
}

TEST(DeviceClock, ACounterOf32BitsMayWrapAround) {
  DeviceClock clock(kStart);
  const DeviceClock::Host::time_point now{};
  clock.At((std::uint64_t{1} << 32) - 1000, now);
  EXPECT_EQ(clock.At(32'000, now + milliseconds(33)), kStart + 33 * kMs);
  EXPECT_EQ(clock.At(65'000, now + milliseconds(66)), kStart + 66 * kMs);
  EXPECT_EQ(clock.restarts(), 0);
}

TEST(DeviceClock, ALeapIsARestartThatTheClockOfTheHostBridges) {
  const DeviceClock::Host::time_point now{};
  for (const std::uint64_t leap : {std::uint64_t{1000}, std::uint64_t{90'000'000'000}}) {
    DeviceClock clock(kStart);
    clock.At(60'000'000, now);
    EXPECT_EQ(clock.At(leap, now + milliseconds(2500)), kStart + 2500 * kMs);
    EXPECT_EQ(clock.At(leap + 33'000, now + milliseconds(2540)), kStart + 2533 * kMs);
    EXPECT_EQ(clock.restarts(), 1);
  }
}

}  // namespace
}  // namespace highwall::device_clock_test
