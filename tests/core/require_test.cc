#include <highwall/internal/require.h>

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "support/message_of.h"

namespace highwall::require_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <typename Check>
std::string Refusal(const Check& check) {
  return testing::MessageOf<InvalidArgument>(check);
}

TEST(Require, SaysTheNameTheDemandAndTheValue) {
  EXPECT_EQ(Refusal([] { RequirePositive(-3, "Options::width"); }),
            "Options::width must be positive, is -3");
  EXPECT_EQ(Refusal([] { RequireNotNegative(-0.5, "a"); }), "a must not be negative, is -0.500000");
  EXPECT_EQ(Refusal([] { RequireAtLeast(1, 2, "a"); }), "a must be at least 2, is 1");
  EXPECT_EQ(Refusal([] { RequireWithin(7, 1, 6, "a"); }), "a must lie in [1, 6], is 7");
  EXPECT_EQ(Refusal([] { RequirePositiveFinite(kInfinity, "a"); }), "a must be positive, is inf");
  EXPECT_EQ(Refusal([] { RequireNotNegativeFinite(kInfinity, "a"); }),
            "a must not be negative, is inf");
}

TEST(Require, AcceptsTheBoundOnlyWhereItBelongsToTheRange) {
  EXPECT_NO_THROW(RequireNotNegative(0.0, "a"));
  EXPECT_NO_THROW(RequireNotNegativeFinite(0.0, "a"));
  EXPECT_NO_THROW(RequireAtLeast(2, 2, "a"));
  EXPECT_NO_THROW(RequireWithin(1, 1, 6, "a"));
  EXPECT_NO_THROW(RequireWithin(6, 1, 6, "a"));
  EXPECT_THROW(RequirePositive(0.0, "a"), InvalidArgument);
  EXPECT_THROW(RequirePositiveFinite(0.0, "a"), InvalidArgument);
  EXPECT_THROW(RequireWithin(0, 1, 6, "a"), InvalidArgument);
}

TEST(Require, AcceptsInfinityUnlessTheValueMustBeFinite) {
  EXPECT_NO_THROW(RequirePositive(kInfinity, "a"));
  EXPECT_NO_THROW(RequireNotNegative(kInfinity, "a"));
  EXPECT_THROW(RequirePositiveFinite(kInfinity, "a"), InvalidArgument);
  EXPECT_THROW(RequireNotNegativeFinite(kInfinity, "a"), InvalidArgument);
}

TEST(Require, RefusesNanEverywhere) {
  EXPECT_THROW(RequirePositive(kNan, "a"), InvalidArgument);
  EXPECT_THROW(RequireNotNegative(kNan, "a"), InvalidArgument);
  EXPECT_THROW(RequirePositiveFinite(kNan, "a"), InvalidArgument);
  EXPECT_THROW(RequireNotNegativeFinite(kNan, "a"), InvalidArgument);
  EXPECT_THROW(RequireAtLeast(kNan, 0.0, "a"), InvalidArgument);
  EXPECT_THROW(RequireWithin(kNan, 0.0, 1.0, "a"), InvalidArgument);
}

}  // namespace
}  // namespace highwall::require_test
