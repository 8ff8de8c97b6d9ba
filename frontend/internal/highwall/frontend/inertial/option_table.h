#pragma once

#include <array>

#include <highwall/frontend/inertial/options.h>
#include <highwall/internal/imu_buffer_options.h>

namespace [[gnu::visibility("default")]] highwall {

template <>
inline constexpr std::array kChoices<ImuWeighting> = {
    ImuWeighting::kPaper, ImuWeighting::kConsistent, ImuWeighting::kFixed};

template <>
inline constexpr std::array kChoices<InertialCoupling> = {InertialCoupling::kTight,
                                                          InertialCoupling::kLoose};

void ForEachOption(OptionsOf<ImuWeightingOptions> auto& options, const auto& visit) {
  visit("policy", options.policy);
  visit("fixed_weight", options.fixed_weight, Finite(Positive()));
}

void ForEachOption(OptionsOf<InertialInitializerOptions> auto& options, const auto& visit) {
  visit("gyroscope_bias_sigma", options.gyroscope_bias_sigma, Finite(Positive()).In("rad/s"));
  visit("accelerometer_bias_sigma", options.accelerometer_bias_sigma,
        Finite(Positive()).In("m/s^2"));
  visit("time_offset_sigma", options.time_offset_sigma, Finite(Positive()).In("s"));
}

void ForEachOption(OptionsOf<VisualNoise> auto& options, const auto& visit) {
  visit("position", options.position, Finite(Positive()).In("m"));
  visit("rotation", options.rotation, Finite(Positive()).In("rad"));
  visit("scale", options.scale, Finite(Positive()));
  visit("min_error", options.min_error, Finite(Positive()));
}

void ForEachOption(OptionsOf<TightWindowOptions> auto& options, const auto& visit) {
  visit("interval", options.interval, Finite(Positive()).In("s"));
  visit("max_points", options.max_points, AtLeast(0));
  visit("max_lines", options.max_lines, AtLeast(0));
}

void ForEachOption(OptionsOf<InertialOptions> auto& options, const auto& visit) {
  visit("coupling", options.coupling);
  visit("weighting", options.weighting);
  visit("estimate_time_offset", options.estimate_time_offset);
  visit("estimate_extrinsics", options.estimate_extrinsics);
  visit("extrinsics_position_sigma", options.extrinsics_position_sigma, Finite(Positive()).In("m"));
  visit("extrinsics_rotation_sigma", options.extrinsics_rotation_sigma,
        Finite(Positive()).In("rad"));
  visit("initializer", options.initializer);
  visit("max_attempts", options.max_attempts, AtLeast(1));
  visit("buffer", options.buffer);
  visit("window_states", options.window_states, AtLeast(2));
  visit("tight", options.tight);
  visit("visual_noise", options.visual_noise);
  visit("max_dead_reckoning", options.max_dead_reckoning, Finite(Positive()).In("s"));
}

}  // namespace highwall
