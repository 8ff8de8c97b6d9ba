#include "simulate/scenes/road_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace highwall::simulate {
namespace {

constexpr double kRut = 0.8, kRutWidth = 0.22;      // [m] from the road's middle; half width
constexpr double kEdge = 1.9;                       // [m] where the shoulder begins to rise
constexpr double kViewBegin = 1.0, kViewEnd = 4.5;  // [m] of ground seen ahead of the camera

double Noise(const ValueNoise& noise, double s, double left) {
  constexpr float kSharp = 1e-3f;  // [m]
  return static_cast<double>(noise(Eigen::Vector2d(s, left).cast<float>(), kSharp));
}

double Step(double x) {
  const double y = std::clamp(x, 0.0, 1.0);
  return y * y * (3.0 - 2.0 * y);
}

double Bell(double x) {
  return std::exp(-0.5 * x * x);
}

}  // namespace

RoadSurface::RoadSurface(std::vector<Stretch> stretches, double speed, double length,
                         std::uint32_t seed)
    : stretches_(std::move(stretches)), speed_(speed), length_(length) {
  const auto period = static_cast<float>(length);
  undulation_ = {.wavelength = 1.4f, .octaves = 4, .seed = seed + 1, .period = period};
  bumps_ = {.wavelength = 0.42f, .octaves = 2, .seed = seed + 2, .period = period};
  shoulder_ = {.wavelength = 0.9f, .octaves = 4, .seed = seed + 3, .period = period};
  patches_ = {.wavelength = 1.1f, .octaves = 3, .seed = seed + 4, .period = period};
}

double RoadSurface::At(StretchKind kind, double s) const {
  const double within = s - std::floor(s / length_) * length_;
  return Intensity(stretches_, kind, within / speed_);
}

double RoadSurface::Height(double s, double left) const {
  const double beside = std::abs(left - kMiddle);
  double height = 0.03 * Noise(undulation_, s, left) - 0.025 * Bell((beside - kRut) / kRutWidth);
  if (const double bumpy = At(StretchKind::kBumpy, s); bumpy > 0.0) {
    height += 0.075 * bumpy * Noise(bumps_, s, left);
  }
  if (const double shaken = At(StretchKind::kBlurred, s); shaken > 0.0) {
    constexpr double kWashboard = 0.2;  // [m] from crest to crest
    height += 0.015 * shaken * std::sin(2.0 * std::numbers::pi * s / kWashboard);
  }
  const double shoulder = Step((beside - kEdge) / 0.9);
  return height + shoulder * (0.28 + 0.16 * Noise(shoulder_, s, left));
}

double RoadSurface::Dust(double s, double left) const {
  const double some = 0.35 * Step(0.3 + 1.3 * Noise(patches_, s, left));
  double cover = 0.0;
  for (const Stretch& stretch : stretches_) {
    if (stretch.kind != StretchKind::kLowTexture) continue;
    const double begin = stretch.begin * speed_ + kViewBegin, end = stretch.end * speed_ + kViewEnd;
    // Uses the closest lap.
    const double middle = 0.5 * (begin + end);
    const double ahead = s - middle - std::round((s - middle) / length_) * length_;
    constexpr double kFade = 1.0;  // [m]
    cover = std::max(cover, Step((0.5 * (end - begin) - std::abs(ahead)) / kFade + 0.5));
  }
  return some + (0.93 - some) * cover;
}

double RoadSurface::Tint(double s, double left) const {
  const double worn = Bell((std::abs(left - kMiddle) - kRut) / (1.3 * kRutWidth));
  return 1.0 - 0.22 * worn * (1.0 + 0.5 * Noise(patches_, s + 17.0, left));
}

}  // namespace highwall::simulate
