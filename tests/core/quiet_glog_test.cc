#include <highwall/internal/quiet_glog.h>

#include <thread>
#include <vector>

#include <glog/logging.h>
#include <gtest/gtest.h>

namespace highwall::internal::quiet_glog_test {
namespace {

TEST(QuietGlog, IsQuietWhileOneLivesAndLeavesTheLevelAsItWas) {
  FLAGS_minloglevel = google::GLOG_WARNING;
  {
    const QuietGlog outer;
    {
      const QuietGlog inner;
      EXPECT_EQ(FLAGS_minloglevel, google::GLOG_FATAL);
    }
    EXPECT_EQ(FLAGS_minloglevel, google::GLOG_FATAL);
  }
  EXPECT_EQ(FLAGS_minloglevel, google::GLOG_WARNING);
}

TEST(QuietGlog, SeveralThreadsLeaveTheLevelAsItWas) {
  FLAGS_minloglevel = google::GLOG_INFO;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([] {
      for (int k = 0; k < 1000; ++k) const QuietGlog quiet;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(FLAGS_minloglevel, google::GLOG_INFO);
}

}  // namespace
}  // namespace highwall::internal::quiet_glog_test
