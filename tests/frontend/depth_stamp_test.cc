#include <highwall/frontend/input/depth_stamp.h>

#include <limits>
#include <optional>

#include <gtest/gtest.h>

namespace highwall::depth_stamp_test {
namespace {

constexpr Stamp kStamp = 1'700'000'000'000'000'000;

RgbdImage WithDepthAt(std::optional<Stamp> stamp) {
  return {.stamp = kStamp, .bgr = {}, .depth = {}, .depth_stamp = stamp};
}

TEST(DepthStamp, IsTheDelayOfTheDepth) {
  EXPECT_EQ(DepthDelay(WithDepthAt(kStamp + 20'000'000)), 0.02);
  EXPECT_EQ(DepthDelay(WithDepthAt(kStamp - 100'000'000)), -0.1);
  EXPECT_EQ(DepthDelay(WithDepthAt(std::nullopt)), 0.0);
}

TEST(DepthStamp, IsNoDelayWhereItIsOfAnotherClock) {
  EXPECT_EQ(DepthDelay(WithDepthAt(kStamp + 100'000'001)), 0.0);
  EXPECT_EQ(DepthDelay(WithDepthAt(12'000'000)), 0.0);
  // The difference of such stamps would overflow.
  EXPECT_EQ(DepthDelay(WithDepthAt(std::numeric_limits<Stamp>::max())), 0.0);
  EXPECT_EQ(DepthDelay(WithDepthAt(std::numeric_limits<Stamp>::min())), 0.0);
}

}  // namespace
}  // namespace highwall::depth_stamp_test
