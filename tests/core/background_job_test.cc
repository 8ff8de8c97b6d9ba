#include <highwall/internal/background_job.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

namespace highwall::background_job_test {
namespace {

// Goes on until it is told to end.
class Endless {
 public:
  explicit Endless(std::atomic<int>* ended)
      : ended_(ended), task_(true, [this](const std::stop_token& stop) {
          began_ = true;
          while (!stop.stop_requested()) std::this_thread::yield();
          ++*ended_;
        }) {
    while (!began_) std::this_thread::yield();  // what has not begun is not done at all
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

TEST(BackgroundTask, WaitThrowsWhatEndedTheWork) {
  BackgroundTask task(true, [](const std::stop_token&) { throw std::runtime_error("work"); });
  EXPECT_THROW(task.Wait(), std::runtime_error);
}

TEST(JobSlot, IsEmptyOnceItsJobIsCancelledAndTheJobEnds) {
  std::atomic<int> ended = 0;
  {
    JobSlot<Endless> slot;
    EXPECT_TRUE(slot.IsEmpty());
    slot.Cancel();  // nothing
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

}  // namespace
}  // namespace highwall::background_job_test
