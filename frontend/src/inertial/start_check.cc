#include "inertial/start_check.h"

#include <string>

#include <highwall/factors/imu_factor.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

// Solutions in a row, half a second apart. Right recordings, with what sensors leave open, had
// hardly any that is contradicted (docs/lab/2026-11-misuse-whole-table.md).
constexpr int kContradictions = 4;

SensorFinding ContradictedStart(const InitializationReport& solution) {
  if (solution.reversed == ReversedFit::kClearlyBetter) {
    return {SensorFault::kImuSign, Trust::kDoubtful,
            "accelerometer and images agree if the sign of the accelerometer is reversed (at rest "
            "it must point up)",
            "multiply it by -1; the images are used alone"};
  }
  if (solution.status == InitializationStatus::kWrongGravity) {
    return {SensorFault::kImuScale, Trust::kDoubtful,
            "by the readings of the accelerometer gravity is " +
                FixedText(solution.gravity_norm, 2) + " m/s^2 where it is " +
                FixedText(kStandardGravity, 2),
            "check its unit and scale; the images are used alone"};
  }
  return {SensorFault::kImuInconsistent, Trust::kDoubtful,
          "images and IMU contradict each other from the beginning (chi-squared " +
              FixedText(solution.error, 0) + " per degree of freedom)",
          "check depth_factor, and T_BC, axes, units and clocks of the IMU; the images are used "
          "alone"};
}

}  // namespace

std::optional<SensorFinding> StartCheck::Update(const InitializationReport& solution,
                                                bool wrong_readings, ImuAgreement agreement) {
  // A solution without an error could not be solved; a sign that fits better by little shows
  // nothing.
  const bool is_contradicted = solution.status == InitializationStatus::kInconsistent &&
                               solution.error > 0.0 && agreement != ImuAgreement::kConsistent &&
                               solution.reversed == ReversedFit::kNotBetter;
  const bool counts =
      is_contradicted || wrong_readings || solution.reversed == ReversedFit::kClearlyBetter;
  in_a_row_ = counts ? in_a_row_ + 1 : 0;
  if (is_reported_ || in_a_row_ < kContradictions) return std::nullopt;
  is_reported_ = true;
  return ContradictedStart(solution);
}

}  // namespace highwall
