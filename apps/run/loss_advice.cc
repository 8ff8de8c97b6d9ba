#include "run/loss_advice.h"

#include <algorithm>
#include <utility>

#include <fmt/core.h>

#include <highwall/frontend/pose/pose_report.h>

namespace highwall::apps {
namespace {

struct LossWords {
  const char* what;
  const char* helps;
};

LossWords Explain(LossReason reason) {
  switch (reason) {
    case LossReason::kDark:
      return {"the image is too dark to find features in", "more light, or a longer exposure"};
    case LossReason::kBlurred:
      return {"the image is blurred", "slower motion, or more light and a shorter exposure"};
    case LossReason::kPlain:
      return {"the image has hardly any corners or edges", "a view with more structure, or an IMU"};
    case LossReason::kNoDepth:
      return {"the features have hardly any depth",
              "a view within the sensor's range (highwall info says what it measures)"};
    case LossReason::kTooFast:
      return {"the camera turned or moved too fast", "slower motion, or a higher frame rate"};
    case LossReason::kContradictory:
      return {"the matches with the frame before contradict each other",
              "a calibration that fits (highwall info), or fewer repeated patterns in view"};
    case LossReason::kAllMoving:
      return {"moving objects fill most of the image",
              "a view with more static surfaces, or an IMU"};
    case LossReason::kUnknownPlace:
      return {"the image matches no place in the map",
              "overlap between the views before and after"};
    case LossReason::kRepeatedImage:
      return {"the colour image repeats the one before", "a recording without dropped images"};
    case LossReason::kDeadReckoning:
      return {"the images gave no pose for longer than the IMU can bridge",
              "shorter passages in the dark or before plain walls"};
  }
  return {"", ""};
}

constexpr LossReason kReasons[] = {
    LossReason::kDark,          LossReason::kBlurred,      LossReason::kPlain,
    LossReason::kNoDepth,       LossReason::kTooFast,      LossReason::kContradictory,
    LossReason::kAllMoving,     LossReason::kUnknownPlace, LossReason::kRepeatedImage,
    LossReason::kDeadReckoning,
};

}  // namespace

std::string LossAdvice(const std::map<std::string, std::size_t>& reasons, std::size_t lost) {
  if (reasons.empty()) return "";
  const auto most =
      std::ranges::max_element(reasons, {}, [](const auto& entry) { return entry.second; });
  const auto& [name, count] = *most;
  for (const LossReason reason : kReasons) {
    if (name != ToString(reason)) continue;
    const LossWords words = Explain(reason);
    return fmt::format("{} of {} frames without a pose: {}; what helps: {}", count, lost,
                       words.what, words.helps);
  }
  return fmt::format(
      "{} of {} frames without a pose: tracking failed soon after their submap began, and the "
      "system dropped the submap; what helps: depth that fits the colour images (highwall info "
      "tests it), slower motion, more light",
      count, lost);
}

std::optional<SensorFinding> UnexplainedLosses(const std::map<std::string, std::size_t>& reasons,
                                               std::size_t frames) {
  constexpr double kMany = 0.4;  // of the frames
  double unexplained = 0.0;
  for (const char* reason :
       {ToString(LossReason::kUnknownPlace), ToString(LossReason::kContradictory), "dropped"}) {
    const auto it = reasons.find(reason);
    if (it != reasons.end()) unexplained += static_cast<double>(it->second);
  }
  const auto all = static_cast<double>(frames);
  if (unexplained <= kMany * all) return std::nullopt;
  return SensorFinding{
      SensorFault::kDepthInconsistent, Trust::kDoubtful,
      fmt::format("{:.0f} % of the frames have no pose although their images show enough: depth "
                  "that does not fit the colour images, or a fast motion",
                  100.0 * unexplained / all),
      "highwall info tests how depth is stored; compare an image with its depth by eye"};
}

}  // namespace highwall::apps
