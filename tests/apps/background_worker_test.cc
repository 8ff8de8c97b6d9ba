#include "background_worker.h"

#include <atomic>
#include <chrono>
#include <latch>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace highwall::apps {
namespace {

bool NothingToSpare() {
  return false;
}

TEST(BackgroundWorker, DoesAllWorkInOrderBeforeItFinishes) {
  std::vector<int> done;
  BackgroundWorker worker(3, NothingToSpare);
  for (int i = 0; i < 50; ++i) worker.Post([&done, i] { done.push_back(i); });
  worker.Finish();
  ASSERT_EQ(done.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(BackgroundWorker, UsesSpareTimeUntilThereIsNothingToDoAndAgainAfterWork) {
  std::atomic<int> spare = 0;
  BackgroundWorker worker(1, [&] {
    const bool more = ++spare % 3 != 0;
    spare.notify_all();
    return more;
  });
  spare.wait(0);
  for (int now = spare; now < 3; now = spare) spare.wait(now);
  std::latch begun(1);
  worker.Post([&] { begun.count_down(); });
  begun.wait();
  for (int now = spare; now < 6; now = spare) spare.wait(now);
  worker.Finish();
  EXPECT_EQ(spare, 6);
}

TEST(BackgroundWorker, HoldsNoMoreThanItsBacklog) {
  BackgroundWorker worker(2, NothingToSpare);
  std::latch go(1);
  std::atomic<int> posted = 0, done = 0;
  worker.Post([&] { go.wait(); });
  std::jthread poster([&] {
    for (int i = 0; i < 6; ++i) {
      worker.Post([&] { ++done; });
      ++posted;
      posted.notify_all();
    }
  });
  for (int now = posted; now < 1; now = posted) posted.wait(now);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_LE(posted, 2) << "more than two wait behind the piece that is being done";
  go.count_down();
  poster.join();
  worker.Finish();
  EXPECT_EQ(done, 6);
}

TEST(BackgroundWorker, ThrowsWhatWorkThrew) {
  BackgroundWorker worker(4, NothingToSpare);
  worker.Post([] { throw std::runtime_error("work"); });
  EXPECT_THROW(worker.Finish(), std::runtime_error);
}

TEST(BackgroundWorker, GivesUpWhatWaitsWhenItIsNotFinished) {
  std::latch begun(1);
  std::atomic<bool> done = false;
  {
    BackgroundWorker worker(4, NothingToSpare);
    worker.Post([&] {
      begun.count_down();
      done = true;
    });
    begun.wait();
  }
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace highwall::apps
