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
       {std::tuple{Status::kInconsistent, false, SensorFault::kImuInconsistent},
        std::tuple{Status::kInconsistent, true, SensorFault::kImuSign},
        std::tuple{Status::kWrongGravity, false, SensorFault::kImuScale}}) {
    const InitializationReport wrong{
        .status = status, .gravity_norm = 11.8, .error = 25.0, .estimate = std::nullopt};
    StartCheck check;
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(check.Update(wrong, true, reversed)) << i;
    EXPECT_FALSE(check.Update(ready, false, false));
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(check.Update(wrong, true, reversed)) << i;
    const auto finding = check.Update(wrong, true, reversed);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->fault, fault);
    EXPECT_EQ(finding->trust, Trust::kDoubtful);
    // Once.
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(check.Update(wrong, true, reversed)) << i;
  }
}

}  // namespace
}  // namespace highwall::start_check_test
