#include "inertial/start_check.h"

#include <optional>
#include <tuple>

#include <gtest/gtest.h>

namespace highwall::start_check_test {
namespace {

using Status = InitializationStatus;

TEST(StartCheck, NamesWhatFourSolutionsInARowContradict) {
  const InitializationReport ready{.status = Status::kReady, .estimate = std::nullopt};
  for (const auto& [status, reversed, fault] :
       {std::tuple{Status::kInconsistent, ReversedFit::kNotBetter, SensorFault::kImuInconsistent},
        std::tuple{Status::kInconsistent, ReversedFit::kClearlyBetter, SensorFault::kImuSign},
        std::tuple{Status::kWrongGravity, ReversedFit::kNotBetter, SensorFault::kImuScale}}) {
    const InitializationReport wrong{.status = status,
                                     .gravity_norm = 11.8,
                                     .error = 25.0,
                                     .reversed = reversed,
                                     .estimate = std::nullopt};
    StartCheck check;
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(check.Update(wrong, true)) << i;
    EXPECT_FALSE(check.Update(ready, false));
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(check.Update(wrong, true)) << i;
    const auto finding = check.Update(wrong, true);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->fault, fault);
    EXPECT_EQ(finding->trust, Trust::kDoubtful);
    // Once, also if others agree in between.
    EXPECT_FALSE(check.Update(ready, false));
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(check.Update(wrong, true)) << i;
  }
}

}  // namespace
}  // namespace highwall::start_check_test
