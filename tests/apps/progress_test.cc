#include "cli/progress.h"

#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace highwall::apps::progress_test {
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

TEST(Progress, ShowsTheTimeWhereNothingIsCounted) {
  EXPECT_EQ(FormatProgress("writing", 0, 0, 21.7), "writing  22 s");
}

// Waits without a time limit until a line with the text arrives.
std::string LinesUntil(const std::string& text) {
  std::string lines;
  while (lines.find(text) == std::string::npos) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    lines += ::testing::internal::GetCapturedStderr();
    ::testing::internal::CaptureStderr();
  }
  return lines;
}

TEST(Progress, WritesLinesWithoutATerminalAlsoOfWorkInWhichNothingIsCounted) {
  ::testing::internal::CaptureStderr();
  {
    Progress progress("reading", std::chrono::milliseconds(1));
    progress.Update(1, 2);
    const std::string lines = LinesUntil("reading  1/2  50%");
    EXPECT_EQ(lines.back(), '\n');
    EXPECT_EQ(lines.find('\r'), std::string::npos);
    progress.Begin("writing");
    LinesUntil("writing  0 s\n");
  }
  ::testing::internal::GetCapturedStderr();
}

TEST(Progress, IsSilentForTheFirstSecondsWhereStandardErrorIsNoTerminal) {
  ::testing::internal::CaptureStderr();  // into a file
  {
    Progress progress("reading");
    progress.Update(1, 2);
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace highwall::apps::progress_test
