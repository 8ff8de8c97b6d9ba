#pragma once

#include <array>

#include <highwall/frontend/loops/options.h>
#include <highwall/internal/option_table.h>

namespace [[gnu::visibility("default")]] highwall {

inline const char* ToString(RobustLoops robust) {
  switch (robust) {
    case RobustLoops::kNone:
      return "none";
    case RobustLoops::kGnc:
      return "gnc";
    case RobustLoops::kDcs:
      return "dcs";
    case RobustLoops::kSwitchable:
      break;
  }
  return "switchable";
}

template <>
inline constexpr std::array kChoices<RobustLoops> = {RobustLoops::kNone, RobustLoops::kGnc,
                                                     RobustLoops::kDcs, RobustLoops::kSwitchable};

void ForEachOption(OptionsOf<KeyFrameGraphOptions> auto& options, const auto& visit) {
  visit("drift_translation", options.drift_translation, Positive().In("of the distance"));
  visit("drift_rotation", options.drift_rotation, Positive().In("of the angle"));
  visit("drift_bias", options.drift_bias, AtLeast(0.0));
  visit("loop_translation", options.loop_translation, Positive().In("m"));
  visit("loop_rotation", options.loop_rotation, Positive().In("rad"));
  visit("max_loop_chi2", options.max_loop_chi2, Positive());
  visit("min_shared", options.min_shared, AtLeast(1));
  visit("neighbours", options.neighbours, AtLeast(0));
  visit("hold_gravity", options.hold_gravity);
}

void ForEachOption(OptionsOf<LoopDetectorOptions> auto& options, const auto& visit) {
  visit("consistency", options.consistency, AtLeast(1));
  visit("min_support", options.min_support, AtLeast(6));
  visit("min_found", options.min_found, Share());
  visit("min_match_ratio_across_submaps", options.min_match_ratio_across_submaps, Share());
  visit("decisive_ratio", options.decisive_ratio, AtLeast(1.0));
}

void ForEachOption(OptionsOf<LoopCorrectionOptions> auto& options, const auto& visit) {
  visit("robust", options.robust);
}

void ForEachOption(OptionsOf<LoopCloserOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("graph", options.graph);
  visit("detector", options.detector);
  visit("correction", options.correction);
  visit("adjust", options.adjust);
}

void ForEachOption(OptionsOf<UserFactorOptions> auto& options, const auto& visit) {
  visit("every", options.every, AtLeast(1));
  visit("share", options.share, AtLeast(0.0));
  visit("max_angle", options.max_angle, Positive().In("rad"));
  visit("max_gap", options.max_gap, Positive().In("s"));
}

}  // namespace highwall
