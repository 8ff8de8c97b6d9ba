#include "simulate/camera/stretch.h"

#include <algorithm>

namespace highwall::simulate {

std::string_view ToString(StretchKind kind) {
  switch (kind) {
    case StretchKind::kBumpy:
      return "bumpy";
    case StretchKind::kBlurred:
      return "blurred";
    case StretchKind::kLowTexture:
      return "low_texture";
    case StretchKind::kLowLight:
      return "low_light";
    case StretchKind::kDust:
      return "dust";
    case StretchKind::kBlackout:
      return "blackout";
  }
  return "unknown";
}

double Intensity(std::span<const Stretch> stretches, StretchKind kind, double t) {
  constexpr double kRamp = 0.5;  // [s]
  double greatest = 0.0;
  for (const Stretch& stretch : stretches) {
    if (stretch.kind != kind || t < stretch.begin || t > stretch.end) continue;
    if (kind == StretchKind::kBlackout) return 1.0;
    const double x = std::min(1.0, std::min(t - stretch.begin, stretch.end - t) / kRamp);
    greatest = std::max(greatest, x * x * (3.0 - 2.0 * x));
  }
  return greatest;
}

}  // namespace highwall::simulate
