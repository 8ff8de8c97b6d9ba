#include "progress.h"

#include <gtest/gtest.h>

namespace highwall::apps {
namespace {

TEST(Progress, ShowsShareRateAndTimeLeft) {
  EXPECT_EQ(FormatProgress("reading", 120, 480, 4.0), "reading  120/480  25%  30.0/s  12 s left");
}

TEST(Progress, ShowsCountAndRateWithoutATotal) {
  EXPECT_EQ(FormatProgress("reading", 120, 0, 4.0), "reading  120  30.0/s");
}

TEST(Progress, ShowsNoRateBeforeTheFirstStepAndNoTimeAfterTheLast) {
  EXPECT_EQ(FormatProgress("reading", 0, 480, 4.0), "reading  0/480  0%");
  EXPECT_EQ(FormatProgress("reading", 480, 480, 4.0), "reading  480/480  100%  120.0/s");
}

TEST(Progress, IsSilentWhereStandardErrorIsNoTerminal) {
  ::testing::internal::CaptureStderr();  // into a file
  {
    Progress progress("reading");
    progress.Update(1, 2);
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace highwall::apps
