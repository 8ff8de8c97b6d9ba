#include "run/imu_choice.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::apps::imu_choice_test {
namespace {

TEST(ImuChoice, NamesThePolicyAndTheWeight) {
  EXPECT_FALSE(ReadImuChoice("off"));
  EXPECT_EQ(ReadImuChoice("paper")->policy, ImuWeighting::kPaper);
  EXPECT_EQ(ReadImuChoice("consistent")->policy, ImuWeighting::kConsistent);
  const auto fixed = ReadImuChoice("fixed:2.5");
  EXPECT_EQ(fixed->policy, ImuWeighting::kFixed);
  EXPECT_EQ(fixed->fixed_weight, 2.5);
  EXPECT_EQ(ReadImuChoice("")->policy, ImuWeightingOptions().policy) << "the default";
}

TEST(ImuChoice, RefusesUnknownValues) {
  for (std::string choice :
       std::vector<std::string>{"on", "Paper", "fixed", "fixed:", "fixed:0", "fixed:-1",
                                "fixed:nan", "fixed:1001", "fixed:1x"}) {
    EXPECT_FALSE(ImuChoice()(choice).empty()) << choice;
    EXPECT_THROW(ReadImuChoice(choice), InvalidArgument) << choice;
  }
}

}  // namespace
}  // namespace highwall::apps::imu_choice_test
