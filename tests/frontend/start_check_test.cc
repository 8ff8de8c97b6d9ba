#include "inertial/start_check.h"

#include <optional>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

namespace highwall::start_check_test {
namespace {

using Status = InitializationStatus;

InitializationReport Solution(Status status, ReversedFit reversed, double error = 25.0) {
  return {.status = status,
          .gravity_norm = 11.8,
          .error = error,
          .reversed = reversed,
          .estimate = std::nullopt};
}

TEST(StartCheck, NamesWhatFourSolutionsInARowContradict) {
  const InitializationReport ready = Solution(Status::kReady, ReversedFit::kNotBetter, 1.0);
  for (const auto& [status, reversed, fault] :
       {std::tuple{Status::kInconsistent, ReversedFit::kNotBetter, SensorFault::kImuInconsistent},
        std::tuple{Status::kInconsistent, ReversedFit::kClearlyBetter, SensorFault::kImuSign},
        std::tuple{Status::kWrongGravity, ReversedFit::kNotBetter, SensorFault::kImuScale}}) {
    const InitializationReport wrong = Solution(status, reversed);
    StartCheck check;
    const auto update = [&](const InitializationReport& solution) {
      return check.Update(solution, solution.status == Status::kWrongGravity,
                          ImuAgreement::kUndecided);
    };
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(update(wrong)) << i;
    EXPECT_FALSE(update(ready));
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(update(wrong)) << i;
    const auto finding = update(wrong);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->fault, fault);
    EXPECT_EQ(finding->trust, Trust::kDoubtful);
    // Once, also if others agree in between.
    EXPECT_FALSE(update(ready));
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(update(wrong)) << i;
  }
}

// A slow camera that is mounted upside down, poor poses beside an IMU that is confirmed, a problem
// that was not solved, poses whose gravity is wrong beside readings that are right.
TEST(StartCheck, IsSilentWhereNothingIsWrongWithTheReadings) {
  for (const auto& [solution, agreement] :
       {std::pair{Solution(Status::kInconsistent, ReversedFit::kBetter, 1.0),
                  ImuAgreement::kUndecided},
        std::pair{Solution(Status::kInconsistent, ReversedFit::kNotBetter),
                  ImuAgreement::kConsistent},
        std::pair{Solution(Status::kInconsistent, ReversedFit::kNotBetter, 0.0),
                  ImuAgreement::kUndecided},
        std::pair{Solution(Status::kWrongGravity, ReversedFit::kNotBetter),
                  ImuAgreement::kUndecided}}) {
    StartCheck check;
    for (int i = 0; i < 20; ++i) EXPECT_FALSE(check.Update(solution, false, agreement)) << i;
  }
}

}  // namespace
}  // namespace highwall::start_check_test
