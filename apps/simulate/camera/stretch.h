#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace highwall::simulate {

// Cause of difficulty in a part of a sequence.
enum class StretchKind {
  kBumpy,       // the vehicle bounces on bumps
  kBlurred,     // it shakes fast, in shade with long exposures: images blur
  kLowTexture,  // dust covers ground and walls
  kLowLight,    // deep shadow: long exposures, then noise
  kDust,        // dust in the air hides distant surfaces
  kBlackout,    // the lens is covered: black images, no depth
};

std::string_view ToString(StretchKind kind);

// [s] since the first frame; begin < end.
struct Stretch {
  StretchKind kind = StretchKind::kBumpy;
  double begin = 0.0, end = 0.0;
};

// Returns the strength at time t, in [0, 1]: it rises and falls smoothly within half a second at
// either end of a stretch; a blackout begins and ends abruptly.
double Intensity(std::span<const Stretch> stretches, StretchKind kind, double t);

}  // namespace highwall::simulate
