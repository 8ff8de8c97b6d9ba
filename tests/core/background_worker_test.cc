#include <highwall/internal/background_worker.h>

#include <atomic>
#include <chrono>
#include <latch>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/error.h>

namespace highwall::background_worker_test {
namespace {

using Stop = const std::stop_token&;

TEST(BackgroundWorker, DoesAllWorkInOrderBeforeItFinishes) {
  std::vector<int> done;
  BackgroundWorker worker(3);
  for (int i = 0; i < 50; ++i) worker.Post([&done, i](Stop) { done.push_back(i); });
  worker.Finish();
  ASSERT_EQ(done.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(BackgroundWorker, UsesSpareTimeUntilThereIsNothingToDoAndAgainAfterWork) {
  std::atomic<int> idle_task = 0;
  BackgroundWorker worker(1, [&] {
    const bool more = ++idle_task % 3 != 0;
    idle_task.notify_all();
    return more;
  });
  idle_task.wait(0);
  for (int now = idle_task; now < 3; now = idle_task) idle_task.wait(now);
  std::latch begun(1);
  worker.Post([&](Stop) { begun.count_down(); });
  begun.wait();
  for (int now = idle_task; now < 6; now = idle_task) idle_task.wait(now);
  worker.Finish();
  EXPECT_EQ(idle_task, 6);
}

TEST(BackgroundWorker, HoldsNoMoreThanItsBacklog) {
  BackgroundWorker worker(2);
  std::latch go(1);
  std::atomic<int> posted = 0, done = 0;
  worker.Post([&](Stop) { go.wait(); });
  std::jthread poster([&] {
    for (int i = 0; i < 6; ++i) {
      worker.Post([&](Stop) { ++done; });
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

TEST(BackgroundWorker, RethrowsTheErrorOfWorkAtTheNextCallOnceAndContinues) {
  BackgroundWorker worker(4);
  const auto fail = [](Stop) { throw std::runtime_error("work"); };
  worker.Post(fail);
  EXPECT_THROW(worker.Wait(), std::runtime_error);
  EXPECT_NO_THROW(worker.Wait());
  worker.Post(fail);
  while (!worker.IsIdle()) std::this_thread::yield();
  EXPECT_THROW(worker.Post([](Stop) {}), std::runtime_error);
  bool done = false;
  worker.Post([&](Stop) { done = true; });
  worker.Wait();
  EXPECT_TRUE(done);
  worker.Post(fail);
  EXPECT_THROW(worker.Finish(), std::runtime_error);
}

TEST(BackgroundWorker, RethrowsTheErrorOfTheIdleTask) {
  BackgroundWorker worker(1, []() -> bool { throw std::runtime_error("idle_task"); });
  const auto post = [&] {
    for (int i = 0; i < 1000; ++i) {
      worker.Post([](Stop) {});
      worker.Wait();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  EXPECT_THROW(post(), std::runtime_error);
}

TEST(BackgroundWorker, DropsWorkQueuedBehindWorkThatThrew) {
  BackgroundWorker worker(4);
  std::latch go(1);
  bool done = false;
  worker.Post([&](Stop) {
    go.wait();
    throw std::runtime_error("work");
  });
  worker.Post([&](Stop) { done = true; });
  go.count_down();
  EXPECT_THROW(worker.Finish(), std::runtime_error);
  EXPECT_FALSE(done);
}

TEST(BackgroundWorker, WakesAPosterThatWaitsForRoomWhenWorkThrows) {
  BackgroundWorker worker(1);
  std::latch go(1);
  worker.Post([&](Stop) {
    go.wait();
    throw std::runtime_error("work");
  });
  const auto fill = [&] {
    for (int i = 0; i < 3; ++i) worker.Post([](Stop) {});
  };
  const std::jthread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    go.count_down();
  });
  EXPECT_THROW(fill(), std::runtime_error);
}

TEST(BackgroundWorker, IsIdleWhenAllIsDone) {
  BackgroundWorker worker(2);
  EXPECT_TRUE(worker.IsIdle());
  std::latch go(1);
  worker.Post([&](Stop) { go.wait(); });
  EXPECT_FALSE(worker.IsIdle());
  go.count_down();
  worker.Wait();
  EXPECT_TRUE(worker.IsIdle());
}

TEST(BackgroundWorker, StopsOnlyTheWorkPostedSoFar) {
  BackgroundWorker worker(4);
  std::atomic<bool> begun = false;
  std::vector<bool> stopped;
  worker.Post([&](Stop stop) {
    begun = true;
    begun.notify_all();
    while (!stop.stop_requested()) std::this_thread::yield();
    stopped.push_back(stop.stop_requested());
  });
  worker.Post([&](Stop stop) { stopped.push_back(stop.stop_requested()); });
  begun.wait(false);
  worker.RequestStop();
  worker.Post([&](Stop stop) { stopped.push_back(stop.stop_requested()); });
  worker.Finish();
  EXPECT_EQ(stopped, std::vector<bool>({true, true, false}));
}

TEST(BackgroundWorker, ItsDestructorStopsTheWorkAndDropsTheQueue) {
  std::latch begun(1);
  bool stopped = false, next = false;
  {
    BackgroundWorker worker(4);
    worker.Post([&](Stop stop) {
      begun.count_down();
      while (!stop.stop_requested()) std::this_thread::yield();
      stopped = true;
    });
    worker.Post([&](Stop) { next = true; });
    begun.wait();
  }
  EXPECT_TRUE(stopped);
  EXPECT_FALSE(next);
}

TEST(BackgroundWorker, RefusesWorkAfterItsEndAndABacklogOfNothing) {
  EXPECT_THROW(BackgroundWorker(0), InvalidArgument);
  BackgroundWorker worker(1);
  worker.Finish();
  EXPECT_THROW(worker.Post([](Stop) {}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::background_worker_test
