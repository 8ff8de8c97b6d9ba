#include <highwall/core/error.h>

#include <string>

#include <gtest/gtest.h>

namespace highwall::error_test {
namespace {

TEST(Error, RequireThrowsTheMessageAndNothingOfTheCode) {
  const int width = -3;
  try {
    HIGHWALL_REQUIRE(width > 0, "width must be positive, is " + std::to_string(width));
    FAIL() << "no exception";
  } catch (const InvalidArgument& e) {
    EXPECT_STREQ(e.what(), "width must be positive, is -3");
  }
}

TEST(Error, RequireEvaluatesItsMessageOnlyOnFailure) {
  int calls = 0;
  const auto message = [&calls] {
    ++calls;
    return std::string("never");
  };
  HIGHWALL_REQUIRE(calls == 0, message());
  EXPECT_EQ(calls, 0);
}

TEST(Error, RequireIsOneStatement) {
  bool reached = false;
  if (true)
    HIGHWALL_REQUIRE(true, "");
  else
    reached = true;
  EXPECT_FALSE(reached);
}

TEST(Error, IoErrorsNameTheFileAndTheLine) {
  EXPECT_STREQ(IoError("data/rgb.txt", "missing").what(), "data/rgb.txt: missing");
  EXPECT_STREQ(IoError("data/rgb.txt", 12, "not a stamp").what(), "data/rgb.txt:12: not a stamp");
}

TEST(Error, CanBeCaughtAsTheStandardKinds) {
  EXPECT_THROW(HIGHWALL_REQUIRE(false, ""), std::invalid_argument);
  EXPECT_THROW(throw IoError("x", "y"), std::runtime_error);
}

}  // namespace
}  // namespace highwall::error_test
