#include "worker_team.h"

#include <array>
#include <atomic>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace highwall::internal {
namespace {

TEST(WorkerTeam, DoesEveryPartOnceInEveryRound) {
  for (const std::size_t parts : {1, 2, 5}) {
    WorkerTeam team(parts);
    std::vector<int> done(parts, 0);
    for (int round = 1; round <= 100; ++round) {
      team.Run([&](std::size_t part) { ++done.at(part); });
      for (const int count : done) ASSERT_EQ(count, round) << parts;
    }
  }
}

TEST(WorkerTeam, PartsRunSideBySide) {
  WorkerTeam team(2);
  // Each waits for the other: one after the other would wait for ever.
  std::array<std::atomic<bool>, 2> here{};
  team.Run([&](std::size_t part) {
    here[part] = true;
    here[part].notify_all();
    here[1 - part].wait(false);
  });
  EXPECT_TRUE(here[0] && here[1]);
}

TEST(WorkerTeam, ThrowsWhatAPartThrewOnceAllAreDoneAndGoesOn) {
  for (const std::size_t thrower : {0, 1}) {
    WorkerTeam team(2);
    std::array<bool, 2> done{};
    EXPECT_THROW(team.Run([&](std::size_t part) {
      done[part] = true;
      if (part == thrower) throw std::runtime_error("part");
    }),
                 std::runtime_error);
    EXPECT_TRUE(done[0] && done[1]);
    int sum = 0;
    team.Run([&](std::size_t part) {
      if (part == 0) sum = 1;
    });
    EXPECT_EQ(sum, 1);
  }
}

TEST(WorkerTeam, EndsWithoutWork) {
  const WorkerTeam team(3);
}

}  // namespace
}  // namespace highwall::internal
