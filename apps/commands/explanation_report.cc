#include "commands/explanation_report.h"

#include <optional>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace highwall::apps {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

std::string ShiftText(const ErrorCause& cause) {
  return fmt::format("{:+.2f} +- {:.2f} ms", 1e3 * cause.time_shift, 2e3 * cause.time_shift_sigma);
}

std::string ScaleText(const ErrorCause& cause) {
  return fmt::format("{:.4f} +- {:.4f}", cause.scale, 2.0 * cause.scale_sigma);
}

std::string LeverText(const ErrorCause& cause) {
  return fmt::format("[{:.1f} {:.1f} {:.1f}] +- {:.1f} mm", 1e3 * cause.lever_arm.x(),
                     1e3 * cause.lever_arm.y(), 1e3 * cause.lever_arm.z(),
                     2e3 * cause.lever_arm_sigma.maxCoeff());
}

nlohmann::ordered_json CauseJson(const std::optional<ErrorCause>& cause) {
  if (!cause) return nullptr;
  const auto triple = [](const Eigen::Vector3d& v) {
    return nlohmann::ordered_json{v.x(), v.y(), v.z()};
  };
  return {{"time_shift_s", cause->time_shift},
          {"time_shift_sigma_s", cause->time_shift_sigma},
          {"scale", cause->scale},
          {"scale_sigma", cause->scale_sigma},
          {"lever_arm_m", triple(cause->lever_arm)},
          {"lever_arm_sigma_m", triple(cause->lever_arm_sigma)},
          {"rmse_m", cause->rmse}};
}

}  // namespace

std::string ExplanationTable(const ErrorExplanation& explanation) {
  const auto row = [&](const char* name, const std::string& value, double left) {
    constexpr double kNothing = 1e-9;  // [m] rounding
    const double share = explanation.rmse > kNothing ? 1.0 - left / explanation.rmse : 0.0;
    return fmt::format("  {:<26} {:<44} {:>10.3f} {:>7.1f} %\n", name, value, 1e3 * left,
                       100.0 * share);
  };
  const auto cause = [&](const char* name, const std::optional<ErrorCause>& found,
                         const auto& describe) {
    if (!found)
      return fmt::format("  {:<26} unobservable from this motion, or a shift too large\n", name);
    return row(name, describe(*found), found->rmse);
  };
  std::string text = fmt::format("\n  {:<26} {:<44} {:>10} {:>9}\n", "without",
                                 "value +- two standard deviations", "left [mm]", "less");
  text += row("(as it is)", "", explanation.rmse);
  text += cause("a shift of all stamps", explanation.time_shift, ShiftText);
  text += cause("a scale", explanation.scale, ScaleText);
  text += cause("shift and scale", explanation.time_shift_and_scale,
                [](const ErrorCause& both) { return ShiftText(both) + ", " + ScaleText(both); });
  text += cause("a lever arm", explanation.lever_arm, LeverText);
  text += cause("all three", explanation.all, [](const ErrorCause& all) {
    return fmt::format("{:+.2f} ms, {:.4f}, [{:.1f} {:.1f} {:.1f}] mm", 1e3 * all.time_shift,
                       all.scale, 1e3 * all.lever_arm.x(), 1e3 * all.lever_arm.y(),
                       1e3 * all.lever_arm.z());
  });
  text += fmt::format("  slow part (mean over 1 s) {:.3f} mm, fast part {:.3f} mm\n",
                      1e3 * explanation.slow, 1e3 * explanation.fast);
  text += fmt::format(
      "  rotation {:.3f} deg, {:.3f} deg without a turn of [{:.3f} {:.3f} {:.3f}] +- {:.3f} deg "
      "between the bodies\n",
      kDegreesPerRadian * explanation.angle_rmse,
      kDegreesPerRadian * explanation.angle_rmse_without,
      kDegreesPerRadian * explanation.hand_eye.x(), kDegreesPerRadian * explanation.hand_eye.y(),
      kDegreesPerRadian * explanation.hand_eye.z(),
      2.0 * kDegreesPerRadian * explanation.hand_eye_sigma.maxCoeff());
  return text;
}

nlohmann::ordered_json ToJson(const ErrorExplanation& explanation) {
  const Eigen::Vector3d& turn = explanation.hand_eye;
  const Eigen::Vector3d& sigma = explanation.hand_eye_sigma;
  return {{"rmse_m", explanation.rmse},
          {"time_shift", CauseJson(explanation.time_shift)},
          {"scale", CauseJson(explanation.scale)},
          {"time_shift_and_scale", CauseJson(explanation.time_shift_and_scale)},
          {"lever_arm", CauseJson(explanation.lever_arm)},
          {"all", CauseJson(explanation.all)},
          {"slow_m", explanation.slow},
          {"fast_m", explanation.fast},
          {"hand_eye_rad", {turn.x(), turn.y(), turn.z()}},
          {"hand_eye_sigma_rad", {sigma.x(), sigma.y(), sigma.z()}},
          {"angle_rmse_rad", explanation.angle_rmse},
          {"angle_rmse_without_rad", explanation.angle_rmse_without}};
}

}  // namespace highwall::apps
