#include <highwall/internal/worker_team.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace highwall::worker_team_test {
namespace {

TEST(WorkerTeam, DoesEveryTaskOnceInEveryRound) {
  for (const std::size_t workers : {1, 2, 5}) {
    WorkerTeam team(workers);
    for (const std::size_t tasks : {0, 1, 2, 17}) {
      std::vector<int> done(tasks, 0);
      for (int round = 1; round <= 100; ++round) {
        team.Run(tasks, [&](std::size_t, std::size_t task) { ++done.at(task); });
        for (const int count : done) ASSERT_EQ(count, round) << workers;
      }
    }
  }
}

TEST(WorkerTeam, TasksRunSideBySide) {
  WorkerTeam team(2);
  // Each task waits for the other, so running them sequentially would never end.
  std::array<std::atomic<bool>, 2> here{};
  std::array<std::size_t, 2> worker_of{};
  team.Run(2, [&](std::size_t worker, std::size_t task) {
    worker_of[task] = worker;
    here[task] = true;
    here[task].notify_all();
    here[1 - task].wait(false);
  });
  EXPECT_TRUE(here[0] && here[1]);
  // Data of a worker are found by its number.
  EXPECT_EQ(std::minmax(worker_of[0], worker_of[1]), std::minmax<std::size_t>(0, 1));
}

TEST(WorkerTeam, WorkersAreNumberedFromZero) {
  for (const std::size_t workers : {1, 2, 5}) {
    WorkerTeam team(workers);
    team.Run(100, [&](std::size_t worker, std::size_t) { EXPECT_LT(worker, workers); });
  }
}

TEST(WorkerTeam, AWorkerDoesOneTaskAtATime) {
  WorkerTeam team(3);
  std::vector<int> done(3, 0);  // by each worker; a data race if two of one number ran concurrently
  for (int round = 0; round < 100; ++round) {
    team.Run(50, [&](std::size_t worker, std::size_t) { ++done.at(worker); });
  }
  EXPECT_EQ(done[0] + done[1] + done[2], 5000);
}

TEST(WorkerTeam, OthersContinueWhileAWorkerIsDelayed) {
  WorkerTeam team(3);
  std::atomic<int> done = 0;
  team.Run(20, [&](std::size_t, std::size_t task) {
    if (task == 0) {
      for (int count = done; count < 19; count = done) done.wait(count);
    } else {
      ++done;
      done.notify_all();
    }
  });
  EXPECT_EQ(done, 19);
}

TEST(WorkerTeam, RethrowsTheErrorOfATaskOnceAllAreDoneAndContinues) {
  for (const std::size_t workers : {1, 2}) {
    WorkerTeam team(workers);
    for (const std::size_t thrower : {0, 1}) {
      std::array<bool, 2> done{};
      const auto work = [&](std::size_t, std::size_t task) {
        done[task] = true;
        if (task == thrower) throw std::runtime_error("task");
      };
      EXPECT_THROW(team.Run(2, work), std::runtime_error);
      EXPECT_TRUE(done[0] && done[1]);
      int sum = 0;
      team.Run(2, [&](std::size_t, std::size_t task) {
        if (task == 0) sum = 1;
      });
      EXPECT_EQ(sum, 1);
    }
  }
}

TEST(WorkerTeam, EndsWithoutWork) {
  const WorkerTeam team(3);
}

}  // namespace
}  // namespace highwall::worker_team_test
