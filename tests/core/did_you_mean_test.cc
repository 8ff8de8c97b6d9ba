#include <highwall/internal/did_you_mean.h>

#include <filesystem>

#include <gtest/gtest.h>

#include "support/temporary_directory.h"

namespace highwall::did_you_mean_test {
namespace {

TEST(EditDistance, CountsInsertionsDeletionsAndReplacements) {
  EXPECT_EQ(EditDistance("", ""), 0U);
  EXPECT_EQ(EditDistance("", "abc"), 3U);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3U);
  EXPECT_EQ(EditDistance("sitting", "kitten"), 3U);
}

TEST(DidYouMean, NamesTheWordThatIsMeant) {
  EXPECT_EQ(DidYouMean("pionts", {"points", "lines", "both"}), "; did you mean 'points'?");
  EXPECT_EQ(DidYouMean("slm", {"slam", "simulate"}), "; did you mean 'slam'?");
  EXPECT_EQ(DidYouMean("sim", {"slam", "simulate"}), "; did you mean 'simulate'?");
}

TEST(DidYouMean, IsSilentWhereNothingIsNear) {
  EXPECT_EQ(DidYouMean("banana", {"points", "lines", "both"}), "");
  EXPECT_EQ(DidYouMean("x", {}), "");
}

TEST(DidYouMean, NamesThePathThatIsMeant) {
  const testing::TemporaryDirectory folder("paths");
  std::filesystem::create_directory(folder.path() / "office_1");
  const std::string there = (folder.path() / "office_1").string();
  EXPECT_EQ(DidYouMeanPath(folder.path() / "ofice_1"), "; did you mean '" + there + "'?");
  EXPECT_EQ(DidYouMeanPath(folder.path() / "ofice_1/"), "; did you mean '" + there + "'?");
  EXPECT_EQ(DidYouMeanPath(folder.path() / "kitchen"), "");
  EXPECT_EQ(DidYouMeanPath(folder.path() / "none" / "kitchen"), "");
}

}  // namespace
}  // namespace highwall::did_you_mean_test
