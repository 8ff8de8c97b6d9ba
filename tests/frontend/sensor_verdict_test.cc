// What contradicts a configuration is collected in one verdict.
#include <highwall/frontend/input/sensor_verdict.h>

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace highwall::sensor_verdict_test {
namespace {

SensorFinding Finding(SensorFault fault, Trust trust, const std::string& text) {
  return {fault, trust, text, "try again"};
}

TEST(SensorVerdict, IsConsistentWithoutFindings) {
  EXPECT_EQ(SensorVerdict().trust(), Trust::kConsistent);
  EXPECT_EQ(SensorVerdict().Summary(), "consistent");
}

TEST(SensorVerdict, TakesTheTrustOfItsWorstFinding) {
  SensorVerdict verdict;
  EXPECT_TRUE(verdict.Add(Finding(SensorFault::kStamps, Trust::kDoubtful, "stamps are equal")));
  EXPECT_EQ(verdict.Summary(), "doubtful: stamps are equal: try again");
  EXPECT_TRUE(verdict.Add(Finding(SensorFault::kLens, Trust::kNotTrusted, "wrong lens")));
  EXPECT_EQ(verdict.Summary(), "not to be trusted: wrong lens: try again (and 1 more, above)");
}

TEST(SensorVerdict, AWorseFindingOfTheSameKindReplacesTheFirst) {
  SensorVerdict verdict;
  verdict.Add(Finding(SensorFault::kLens, Trust::kDoubtful, "first"));
  EXPECT_FALSE(verdict.Add(Finding(SensorFault::kLens, Trust::kDoubtful, "second")));
  ASSERT_EQ(verdict.findings.size(), 1U);
  EXPECT_EQ(verdict.findings.front().text, "first");
  EXPECT_TRUE(verdict.Add(Finding(SensorFault::kLens, Trust::kNotTrusted, "third")));
  ASSERT_EQ(verdict.findings.size(), 1U);
  EXPECT_EQ(verdict.findings.front().text, "third");
}

TEST(SensorVerdict, EveryFaultHasItsName) {
  std::set<std::string> names;
  int faults = 0;
  for (; std::string(ToString(static_cast<SensorFault>(faults))) != "unknown"; ++faults) {
    names.insert(ToString(static_cast<SensorFault>(faults)));
  }
  EXPECT_EQ(static_cast<SensorFault>(faults - 1), SensorFault::kEmptyMap) << "the last one";
  EXPECT_EQ(names.size(), static_cast<std::size_t>(faults));
}

}  // namespace
}  // namespace highwall::sensor_verdict_test
