#include "run/depth_scale_check.h"

#include <cmath>

#include <fmt/core.h>

namespace highwall::apps {

bool IsScaleMeaningful(const InertialReport& last) {
  constexpr double kSettled = 3e-3;  // [s] sigma of t_d
  const bool is_used =
      last.status == InertialStatus::kRunning || last.status == InertialStatus::kDeadReckoning;
  return is_used && last.time_offset_sigma < kSettled;
}

bool IsOfImu(const SensorFinding& finding) {
  return finding.fault >= SensorFault::kImuMount && finding.fault <= SensorFault::kImuInconsistent;
}

bool LeavesNoScale(const SensorFinding& finding) {
  return IsOfImu(finding) && finding.fault != SensorFault::kImuClock;
}

std::optional<SensorFinding> CheckDepthScale(const DepthScale& scale, double depth_factor) {
  constexpr double kSmall = 0.05, kLarge = 0.1, kSigmas = 5.0;
  const double off = std::abs(scale.scale - 1.0);
  if (!(off > kSmall && off > kSigmas * scale.sigma)) return std::nullopt;
  return SensorFinding{
      SensorFault::kDepthScale, off > kLarge ? Trust::kNotTrusted : Trust::kDoubtful,
      fmt::format("by the IMU, depth reads {:.1f} % too {}",
                  100.0 * std::abs(1.0 / scale.scale - 1.0), scale.scale < 1.0 ? "long" : "short"),
      fmt::format("set depth_factor: {:.4g} in calibration.yaml", depth_factor / scale.scale)};
}

}  // namespace highwall::apps
