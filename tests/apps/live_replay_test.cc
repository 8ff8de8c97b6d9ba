#include "run/live_replay.h"

#include <chrono>
#include <new>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

namespace highwall::apps::live_replay_test {
namespace {

using Clock = std::chrono::steady_clock;

// Six frames without images, `gap` apart; the third is unusable, and frame `fatal` throws
// bad_alloc.
class FakeDataset final : public Dataset {
 public:
  static constexpr std::size_t kSize = 6;

  explicit FakeDataset(Stamp gap, std::size_t fatal = kSize) : gap_(gap), fatal_(fatal) {}

  std::size_t size() const override { return kSize; }
  Stamp stamp(std::size_t index) const override { return static_cast<Stamp>(index) * gap_; }
  const Trajectory* groundtruth() const override { return nullptr; }

 private:
  RgbdImage DoLoad(std::size_t index) const override {
    if (index == fatal_) throw std::bad_alloc();
    if (index == 2) throw IoError("frame", "is broken");
    return {stamp(index), {}, {}};
  }

  Stamp gap_;
  std::size_t fatal_;
};

TEST(LiveReplay, EveryFrameArrivesOrIsCounted) {
  const FakeDataset dataset(FromSeconds(0.005));
  const auto start = Clock::now();
  LiveReplay replay(dataset, {});
  std::vector<Stamp> stamps;
  while (const auto image = replay.Next()) {
    stamps.push_back(image->stamp);
    EXPECT_GT(replay.position(), static_cast<std::size_t>(image->stamp / dataset.stamp(1)));
  }
  EXPECT_GE(Clock::now() - start, std::chrono::nanoseconds(dataset.stamp(5))) << "too early";
  EXPECT_EQ(stamps.size() + replay.dropped() + dataset.problems().size(), replay.count());
  EXPECT_EQ(stamps.back(), dataset.stamp(5));
  EXPECT_EQ(replay.position(), replay.count());
  EXPECT_FALSE(replay.Next());
}

TEST(LiveReplay, ARateDividesTheTimesBetweenFrames) {
  const FakeDataset dataset(FromSeconds(10.0));
  const auto start = Clock::now();
  LiveReplay replay(dataset, {}, 1e4);  // a frame each millisecond
  std::optional<Stamp> last;
  while (const auto image = replay.Next()) last = image->stamp;
  const auto taken = Clock::now() - start;
  EXPECT_EQ(last, dataset.stamp(5));
  EXPECT_GE(taken, std::chrono::milliseconds(5)) << "too early";
  EXPECT_LT(taken, std::chrono::seconds(10)) << "at the pace of the stamps the second frame is due";
}

TEST(LiveReplay, StopsInTheMiddleWithoutWaitingForTheNextFrame) {
  const FakeDataset dataset(FromSeconds(60.0));
  const auto start = Clock::now();
  {
    LiveReplay replay(dataset, {});
    EXPECT_TRUE(replay.Next());
  }
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(30));
}

TEST(LiveReplay, PassesOnTheErrorOfTheReader) {
  const FakeDataset dataset(0, 1);
  LiveReplay replay(dataset, {});
  EXPECT_TRUE(replay.Next());
  EXPECT_THROW(replay.Next(), std::bad_alloc);
}

}  // namespace
}  // namespace highwall::apps::live_replay_test
