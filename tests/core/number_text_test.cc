#include <highwall/internal/number_text.h>

#include <functional>
#include <iomanip>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/atomic_file.h>
#include <highwall/core/pose_graph.h>
#include <highwall/core/trajectory.h>

#include "support/decimal_comma.h"
#include "support/temporary_directory.h"

namespace highwall::number_text_test {
namespace {

using testing::DecimalCommaInC;
using testing::DecimalCommaInStreams;
using testing::GermanLocale;
using testing::ReadText;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Everything that core writes, as one text.
std::string Written() {
  const testing::TemporaryDirectory folder("written");
  const Eigen::Vector3d theta(0.1, -0.2, 0.3);
  const Trajectory trajectory{{1305031102175304000, Pose::FromTangent({0.5, -1234.25, 3.0}, theta)},
                              {1305031102275304000, Pose::FromTangent({1e-9, 0.0, 1e9}, theta)}};
  WriteTumTrajectory(folder / "trajectory.txt", trajectory);
  PoseGraph graph;
  graph.has_poses = true;
  graph.nodes = {{1000, trajectory[0].pose}, {2000, trajectory[1].pose}};
  WriteG2o(folder / "graph.g2o", graph);
  AtomicFile file(folder / "plain.txt");
  file.stream() << 1234567 << ' ' << 0.5;
  file.Commit();
  TextWriter text;
  text << std::fixed << std::setprecision(3) << 1234.5 << ' ' << 500000000;
  return NumberText(1234.5) + ' ' + NumberText(0.1F) + ' ' + FixedText(0.25) + ' ' +
         FixedText(-1234.5678, 2) + ' ' + RoundedText(1234567.0, 4) + ' ' + text.str() + '\n' +
         ReadText(folder / "trajectory.txt") + ReadText(folder / "graph.g2o") +
         ReadText(folder / "plain.txt");
}

void ExpectNumbersAreRead() {
  EXPECT_EQ(ReadNumber<double>("0.5"), 0.5);
  EXPECT_EQ(ReadNumber<double>("0,5"), std::nullopt);
  EXPECT_EQ(ReadNumber<double>("1.234,5"), std::nullopt);
  double first = 0.0, second = 0.0;
  EXPECT_TRUE(TextReader("1.5 2000.25") >> first >> second);
  EXPECT_EQ(first, 1.5);
  EXPECT_EQ(second, 2000.25);
  const testing::TemporaryDirectory folder("read");
  testing::WriteText(folder / "trajectory.txt", "1.5 0.25 -1234.5 3 0 0 0 1\n");
  const Trajectory trajectory = ReadTumTrajectory(folder / "trajectory.txt");
  ASSERT_EQ(trajectory.size(), 1U);
  EXPECT_EQ(trajectory[0].stamp, 1500000000);
  EXPECT_EQ(trajectory[0].pose.p(), Eigen::Vector3d(0.25, -1234.5, 3.0));
}

TEST(NumberText, HasTheFormsOfPrintf) {
  EXPECT_EQ(NumberText(0.1), "0.1");
  EXPECT_EQ(NumberText(1e-300), "1e-300");
  EXPECT_EQ(NumberText(0.1F), "0.1");
  EXPECT_EQ(NumberText(kInfinity), "inf");
  EXPECT_EQ(FixedText(0.5), std::to_string(0.5));
  EXPECT_EQ(FixedText(-2.0 / 3.0, 2), "-0.67");
  EXPECT_EQ(FixedText(3.0, 0), "3");
  EXPECT_EQ(FixedText(std::numeric_limits<double>::max(), 17).size(), 309U + 1U + 17U);
  EXPECT_EQ(RoundedText(1234567.0, 4), "1.235e+06");
  EXPECT_EQ(RoundedText(0.25, 4), "0.25");
}

TEST(NumberText, AWholeTextIsANumberOrNone) {
  EXPECT_EQ(ReadNumber<double>("+1e3"), 1000.0);
  EXPECT_EQ(ReadNumber<int>("-12"), -12);
  for (const char* const none : {"", "+", "+-1", " 1", "1 ", "1x", "x"}) {
    EXPECT_EQ(ReadNumber<double>(none), std::nullopt) << none;
  }
  EXPECT_EQ(ReadNumber<int>("1.5"), std::nullopt);
  EXPECT_EQ(ReadNumber<unsigned>("-1"), std::nullopt);
  double value = 0.0;
  EXPECT_TRUE(ParseNumber("1e3", &value));
  EXPECT_EQ(value, 1000.0);
  EXPECT_FALSE(ParseNumber("+1e3", &value));
}

TEST(NumberText, WordsAreWhatStandsBetweenSeparators) {
  using Words = std::vector<std::string_view>;
  EXPECT_EQ(SplitWords("\ta, b  c,", ", \t"), (Words{"a", "b", "c"}));
  EXPECT_EQ(SplitWords("a,b", " "), (Words{"a,b"}));
  EXPECT_EQ(SplitWords(" \t", " \t"), Words());
  EXPECT_EQ(SplitWords("", " "), Words());
}

TEST(NumberText, DoesNotFollowTheGlobalLocaleOfStreams) {
  const std::string expected = Written();
  const DecimalCommaInStreams comma;
  std::ostringstream other;
  other << 1234.5;
  ASSERT_EQ(other.str(), "1.234,5") << "a stream that follows";
  EXPECT_EQ(Written(), expected);
  ExpectNumbersAreRead();
}

TEST(NumberText, DoesNotFollowSetlocale) {
  const GermanLocale german;
  if (!german.IsMade()) GTEST_SKIP() << testing::kNoGermanLocale;
  const std::string expected = Written();
  const DecimalCommaInC comma(german);
  ASSERT_EQ(std::to_string(0.5), "0,500000") << "a function that follows";
  EXPECT_EQ(Written(), expected);
  ExpectNumbersAreRead();
}

}  // namespace
}  // namespace highwall::number_text_test
