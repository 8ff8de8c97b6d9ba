#include <highwall/frontend/input/frame_queue.h>

#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/error.h>

namespace highwall::frame_queue_test {
namespace {

TEST(FrameQueue, GivesImagesInTheOrderInWhichTheyCame) {
  FrameQueue queue(3);
  for (const Stamp stamp : {10, 20, 30}) queue.Push({stamp, {}, {}});
  queue.Close();
  for (const Stamp stamp : {10, 20, 30}) {
    const auto image = queue.Pop();
    ASSERT_TRUE(image);
    EXPECT_EQ(image->stamp, stamp);
  }
  EXPECT_FALSE(queue.Pop());
  EXPECT_FALSE(queue.Pop()) << "and again";
  EXPECT_EQ(queue.dropped(), 0U);
}

TEST(FrameQueue, AFullOneDropsTheOldestAndCountsIt) {
  FrameQueue queue(2);
  for (const Stamp stamp : {10, 20, 30, 40, 50}) queue.Push({stamp, {}, {}});
  EXPECT_EQ(queue.dropped(), 3U);
  EXPECT_EQ(queue.size(), 2U);
  EXPECT_EQ(queue.Pop()->stamp, 40);
  EXPECT_EQ(queue.size(), 1U);
  EXPECT_EQ(queue.Pop()->stamp, 50);
  queue.Push({60, {}, {}});
  EXPECT_EQ(queue.Pop()->stamp, 60);
  EXPECT_EQ(queue.dropped(), 3U);
}

TEST(FrameQueue, AClosedOneTakesNoMore) {
  FrameQueue queue;
  queue.Push({10, {}, {}});
  queue.Close();
  queue.Push({20, {}, {}});
  EXPECT_EQ(queue.dropped(), 1U);
  EXPECT_EQ(queue.Pop()->stamp, 10);
  EXPECT_FALSE(queue.Pop());
}

TEST(FrameQueue, WhoWaitsIsWokenByAnImageAndByTheEnd) {
  FrameQueue queue;
  std::vector<Stamp> stamps;
  std::jthread user([&] {
    while (const auto image = queue.Pop()) stamps.push_back(image->stamp);
  });
  queue.Push({10, {}, {}});
  queue.Close();
  user.join();
  EXPECT_EQ(stamps, (std::vector<Stamp>{10}));
}

TEST(FrameQueue, BetweenTwoThreadsEveryImageArrivesOrIsCounted) {
  constexpr Stamp kImages = 20000;
  FrameQueue queue(3);
  const std::jthread camera([&] {
    for (Stamp stamp = 1; stamp <= kImages; ++stamp) queue.Push({stamp, {}, {}});
    queue.Close();
  });
  std::size_t arrived = 0;
  Stamp last = 0;
  while (const auto image = queue.Pop()) {
    EXPECT_GT(image->stamp, last);
    last = image->stamp;
    ++arrived;
  }
  EXPECT_EQ(last, kImages) << "the newest is never dropped";
  EXPECT_EQ(arrived + queue.dropped(), static_cast<std::size_t>(kImages));
}

TEST(FrameQueue, RefusesToHoldNothing) {
  EXPECT_THROW(FrameQueue(0), InvalidArgument);
}

}  // namespace
}  // namespace highwall::frame_queue_test
