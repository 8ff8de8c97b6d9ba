#include "cli/stop_signals.h"

#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

namespace highwall::stop_signals_test {
namespace {

using apps::StopSignals;

constexpr int kDone = 7;  // exit code

TEST(StopSignals, TheFirstIsRememberedAndEndsNothing) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const StopSignals signals;
    EXPECT_EQ(signals.caught(), 0);
    ::raise(signal);
    EXPECT_EQ(signals.caught(), signal);
  }
}

// timeout(1) sends it to the process and to its group.
TEST(StopSignals, OneThatIsSentTwiceIsOne) {
  const StopSignals signals;
  ::raise(SIGTERM);
  ::raise(SIGTERM);
  ::raise(SIGHUP);
  EXPECT_EQ(signals.caught(), SIGTERM);
}

TEST(StopSignals, ASecondOneEndsTheProcessAtOnce) {
  EXPECT_EXIT(
      {
        const StopSignals signals;
        ::raise(SIGINT);
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
        ::raise(SIGHUP);
        std::_Exit(kDone);
      },
      ::testing::ExitedWithCode(129), "");
}

TEST(StopSignals, RestoresTheEarlierHandlers) {
  { const StopSignals signals; }
  EXPECT_EXIT(::raise(SIGTERM), ::testing::KilledBySignal(SIGTERM), "");
}

TEST(StopSignals, AHangupThatNohupIgnoresStaysIgnored) {
  EXPECT_EXIT(
      {
        ::signal(SIGHUP, SIG_IGN);
        const StopSignals signals;
        ::raise(SIGHUP);
        std::_Exit(signals.caught() == 0 ? kDone : 1);
      },
      ::testing::ExitedWithCode(kDone), "");
}

TEST(StopSignals, HaveTheNamesAndExitCodesOfShells) {
  EXPECT_EQ(apps::SignalName(SIGINT), "SIGINT");
  EXPECT_EQ(apps::SignalName(SIGTERM), "SIGTERM");
  EXPECT_EQ(apps::SignalName(SIGHUP), "SIGHUP");
  EXPECT_EQ(apps::ExitCodeOf(SIGINT), 130);
  EXPECT_EQ(apps::ExitCodeOf(SIGTERM), 143);
}

}  // namespace
}  // namespace highwall::stop_signals_test
