#include <highwall/frontend/input/frame_reader.h>

#include <atomic>
#include <chrono>
#include <new>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::frame_reader_test {
namespace {

// Ten frames, of which the fourth and the last are unusable; frame `fatal` throws bad_alloc.
class FakeDataset final : public Dataset {
 public:
  static constexpr std::size_t kSize = 10;

  explicit FakeDataset(std::size_t fatal = kSize) : fatal_(fatal) {}

  std::size_t size() const override { return kSize; }
  Stamp stamp(std::size_t index) const override { return static_cast<Stamp>(index) * 100; }
  const Trajectory* groundtruth() const override { return nullptr; }
  int loads() const { return loads_; }

 private:
  RgbdImage DoLoad(std::size_t index) const override {
    ++loads_;
    if (index == fatal_) throw std::bad_alloc();
    if (index == 3 || index == kSize - 1) throw IoError("frame", "is broken");
    return {stamp(index), {}, {}};
  }

  std::size_t fatal_;
  mutable std::atomic<int> loads_ = 0;
};

std::vector<Stamp> ReadAll(FrameReader* reader) {
  std::vector<Stamp> stamps;
  while (const std::optional<RgbdImage> image = reader->Next()) stamps.push_back(image->stamp);
  return stamps;
}

TEST(FrameReader, GivesTheUsableFramesInOrderWithAndWithoutAThread) {
  const std::vector<Stamp> expected = {0, 100, 200, 400, 500, 600, 700, 800};
  for (const std::size_t prefetch : {0U, 1U, 4U, 100U}) {
    const FakeDataset dataset;
    FrameReader reader(dataset, {.prefetch = prefetch});
    EXPECT_EQ(ReadAll(&reader), expected) << prefetch;
    EXPECT_EQ(reader.position(), 10U);
    EXPECT_FALSE(reader.Next());
    ASSERT_EQ(dataset.problems().size(), 2U);
    EXPECT_EQ(dataset.problems()[1].frame, 9U);
  }
}

TEST(FrameReader, KeepsToItsRange) {
  const FakeDataset dataset;
  for (const std::size_t prefetch : {0U, 4U}) {
    FrameReader reader(dataset, {.begin = 2, .end = 5, .prefetch = prefetch});
    EXPECT_EQ(reader.count(), 3U);
    EXPECT_EQ(ReadAll(&reader), (std::vector<Stamp>{200, 400}));
    FrameReader beyond(dataset, {.begin = 20, .end = 3, .prefetch = prefetch});
    EXPECT_EQ(beyond.count(), 0U);
    EXPECT_FALSE(beyond.Next());
  }
}

TEST(FrameReader, CountsSkippedFramesIntoItsPosition) {
  const FakeDataset dataset;
  FrameReader reader(dataset);
  for (int i = 0; i < 4; ++i) reader.Next();
  EXPECT_EQ(reader.position(), 5U);  // frame 3 was skipped
}

TEST(FrameReader, DecodesNoFurtherAheadThanAsked) {
  const FakeDataset dataset;
  FrameReader reader(dataset, {.prefetch = 2});
  reader.Next();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LE(dataset.loads(), 5);  // 1 taken, 2 queued, 1 waiting for room, and the broken one
}

TEST(FrameReader, StopsInTheMiddle) {
  const FakeDataset dataset;
  FrameReader reader(dataset, {.prefetch = 1});
  EXPECT_TRUE(reader.Next());
}

TEST(FrameReader, PassesOnErrorsThatConcernMoreThanOneFile) {
  const FakeDataset dataset(2);
  FrameReader reader(dataset);
  EXPECT_TRUE(reader.Next());
  EXPECT_TRUE(reader.Next());
  EXPECT_THROW(reader.Next(), std::bad_alloc);
  EXPECT_THROW(reader.Next(), std::bad_alloc);
}

}  // namespace
}  // namespace highwall::frame_reader_test
