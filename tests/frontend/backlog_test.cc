#include "system/backlog.h"

#include <gtest/gtest.h>

namespace highwall::backlog_test {
namespace {

constexpr KeyFramePolicyOptions kDue{.max_gap = 0.3, .wanted_tracked = 100};

TEST(Backlog, NothingIsPostponedWhileNoImageWaits) {
  Backlog backlog;
  EXPECT_FALSE(backlog.PostponesKeyframe(false, 1000, 0.0, kDue));
  EXPECT_FALSE(backlog.SkipsLoopSearch());
  EXPECT_EQ(backlog.postponed().keyframes, 0U);
  EXPECT_EQ(backlog.postponed().loop_searches, 0U);
}

TEST(Backlog, AKeyframeWaitsAsLongAsEnoughIsTrackedAndTheLastOneIsNotLongAgo) {
  Backlog backlog;
  backlog.Set(1);
  EXPECT_TRUE(backlog.PostponesKeyframe(false, 50, 0.89, kDue));
  EXPECT_FALSE(backlog.PostponesKeyframe(false, 49, 0.89, kDue));
  EXPECT_FALSE(backlog.PostponesKeyframe(false, 50, 0.91, kDue));
  EXPECT_EQ(backlog.postponed().keyframes, 1U);
}

TEST(Backlog, AKeyframeOfACameraThatDoesNotWaitIsPostponedEvenIfNoImageWaits) {
  Backlog backlog;
  EXPECT_TRUE(backlog.PostponesKeyframe(true, 50, 0.0, kDue));
  EXPECT_FALSE(backlog.PostponesKeyframe(true, 10, 0.0, kDue));
}

TEST(Backlog, LoopsAreSearchedForEveryThirdKeyframeHoweverLongImagesWait) {
  Backlog backlog;
  backlog.Set(2);
  for (int keyframe = 1; keyframe <= 9; ++keyframe) {
    EXPECT_EQ(backlog.SkipsLoopSearch(), keyframe % 3 != 0) << keyframe;
  }
  EXPECT_EQ(backlog.postponed().loop_searches, 6U);
}

}  // namespace
}  // namespace highwall::backlog_test
