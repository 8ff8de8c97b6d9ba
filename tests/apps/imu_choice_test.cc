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
  const auto fixed = ReadImuChoice("fixed:2.5");
  EXPECT_EQ(fixed->policy, ImuWeighting::kFixed);
  EXPECT_EQ(fixed->fixed_weight, 2.5);
  EXPECT_EQ(ReadImuChoice("")->policy, ImuWeighting::kConsistent) << "the default has no name";
}

TEST(ImuChoice, RefusesUnknownValues) {
  for (std::string choice :
       std::vector<std::string>{"on", "Paper", "consistent", "fixed", "fixed:", "fixed:0",
                                "fixed:-1", "fixed:nan", "fixed:1001", "fixed:1x"}) {
    EXPECT_FALSE(ImuChoice()(choice).empty()) << choice;
    EXPECT_THROW(ReadImuChoice(choice), InvalidArgument) << choice;
  }
}

TEST(ImuChoice, SaysThatTheFormerNameIsTheDefault) {
  EXPECT_NE(ImuChoice()(std::string("consistent")).find("leave it out"), std::string::npos);
}

}  // namespace
}  // namespace highwall::apps::imu_choice_test
