#include <highwall/internal/stopwatch.h>

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

namespace highwall::stopwatch_test {
namespace {

// The only upper bound is the test's own clock, because a busy machine may suspend a thread for
// long.
TEST(Stopwatch, MeasuresTheTimeSinceItWasMade) {
  const auto before = std::chrono::steady_clock::now();
  const Stopwatch stopwatch;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const double seconds = stopwatch.Seconds();
  const double milliseconds = stopwatch.Milliseconds();
  const std::chrono::duration<double> most = std::chrono::steady_clock::now() - before;
  EXPECT_GE(seconds, 0.02);
  EXPECT_GE(milliseconds, 1e3 * seconds);
  EXPECT_LE(milliseconds, 1e3 * most.count());
}

TEST(Stopwatch, StartsAnewWhenANewOneIsAssigned) {
  Stopwatch stopwatch;
  const Stopwatch older = stopwatch;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  stopwatch = Stopwatch();
  const double newer = stopwatch.Seconds();
  EXPECT_GE(older.Seconds() - newer, 0.02);
}

}  // namespace
}  // namespace highwall::stopwatch_test
