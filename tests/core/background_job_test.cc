#include <highwall/internal/background_job.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

namespace highwall::background_job_test {
namespace {

// Runs until it is cancelled.
class Endless {
 public:
  explicit Endless(std::atomic<int>* ended)
      : ended_(ended), task_(true, [this](const std::stop_token& stop) {
          began_ = true;
          while (!stop.stop_requested()) std::this_thread::yield();
          ++*ended_;
        }) {
    while (!began_) std::this_thread::yield();  // a cancelled job that never began would never run
  }

  void Cancel() { task_.Cancel(); }
  bool IsDone() const { return task_.IsDone(); }

 private:
  std::atomic<int>* ended_;
  std::atomic<bool> began_ = false;
  BackgroundTask task_;
};

TEST(BackgroundTask, NotInTheBackgroundIsDoneAtOnceOnTheCallersThread) {
  std::thread::id worked;
  BackgroundTask task(false, [&](const std::stop_token&) { worked = std::this_thread::get_id(); });
  EXPECT_TRUE(task.IsDone());
  EXPECT_EQ(worked, std::this_thread::get_id());
  task.Wait();
}

TEST(BackgroundTask, WaitRethrowsTheErrorOfTheWork) {
  BackgroundTask task(true, [](const std::stop_token&) { throw std::runtime_error("work"); });
  EXPECT_THROW(task.Wait(), std::runtime_error);
}

TEST(JobSlot, IsEmptyOnceItsJobIsCancelledAndTheJobEnds) {
  std::atomic<int> ended = 0;
  {
    JobSlot<Endless> slot;
    EXPECT_TRUE(slot.IsEmpty());
    slot.Cancel();  // has no effect on an empty slot
    slot.Put(std::make_unique<Endless>(&ended));
    EXPECT_FALSE(slot.IsEmpty());
    slot.Cancel();
    EXPECT_TRUE(slot.IsEmpty());
    EXPECT_EQ(slot.Take(), nullptr);
    slot.Put(std::make_unique<Endless>(&ended));
    EXPECT_FALSE(slot->IsDone());
  }
  EXPECT_EQ(ended, 2);
}

// Ends only when `let_go` is set, and ignores cancellation.
class Stubborn {
 public:
  explicit Stubborn(const std::atomic<bool>* let_go)
      : task_(true, [this, let_go](const std::stop_token&) {
          began_ = true;
          while (!*let_go) std::this_thread::yield();
        }) {
    while (!began_) std::this_thread::yield();  // a cancelled job that never began would never run
  }
  void Cancel() { task_.Cancel(); }
  bool IsDone() const { return task_.IsDone(); }

 private:
  std::atomic<bool> began_ = false;
  BackgroundTask task_;
};

TEST(JobSlot, HasNoRoomWhereTwoThatWereCancelledHaveNotEnded) {
  std::atomic<bool> let_go = false;
  JobSlot<Stubborn> slot;
  int begun = 0;
  for (; begun < 100 && slot.HasRoom(); ++begun) {
    slot.Put(std::make_unique<Stubborn>(&let_go));
    slot.Cancel();
  }
  EXPECT_EQ(begun, 2);
  let_go = true;
  while (!slot.HasRoom()) std::this_thread::yield();
}

TEST(JobSlot, BeyondItsRoomItWaitsForTheOldest) {
  std::atomic<bool> let_go = false;
  JobSlot<Stubborn> slot;
  for (int i = 0; i < 3; ++i) {
    slot.Put(std::make_unique<Stubborn>(&let_go));
    slot.Cancel();
  }
  std::atomic<bool> is_put = false;
  std::thread fourth([&] {
    slot.Put(std::make_unique<Stubborn>(&let_go));
    is_put = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(is_put);
  let_go = true;
  fourth.join();
  EXPECT_TRUE(is_put);
}

}  // namespace
}  // namespace highwall::background_job_test
