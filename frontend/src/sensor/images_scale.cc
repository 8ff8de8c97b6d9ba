#include "sensor/images_scale.h"

#include <cmath>
#include <limits>

namespace highwall {
namespace {

constexpr int kFewestArcs = 25;
constexpr double kSignificantScale = 25.0;        // variances
constexpr double kLeastRatio = 0.37;              // of log2: 1.3, with which an IMU in use copes
constexpr double kMostRatio = 5.0;                // of log2
constexpr double kCoarse = 0.25, kFine = 0.0625;  // steps of log2
// The part of the changes of velocity that a free fit must explain, and the part of this that the
// ratio may leave: what explains less is another fault. Depth that is much too long makes errors of
// the images as much longer: of a far ratio less is expected.
constexpr double kExplained = 0.5, kLeft = 0.04;
constexpr double kFarRatio = 1.5;  // of log2
constexpr double kExplainedByFar = 0.4, kLeftByFar = 0.15;

struct ScaledFit {
  double log2 = 0.0, squared = std::numeric_limits<double>::infinity();
};

}  // namespace

std::vector<double> ScalesOfImages() {
  constexpr int kOctaves = 4, kPerOctave = 4;
  std::vector<double> scales;
  for (int i = -kOctaves * kPerOctave; i <= kOctaves * kPerOctave; ++i) {
    scales.push_back(std::exp2(static_cast<double>(i) / kPerOctave));
  }
  return scales;
}

std::optional<double> ContradictedScale(const AccelerometerFit& fit, const Eigen::Matrix3d& A_CB,
                                        const Eigen::Vector3d& lever_arm, double strictness) {
  // What fits the configuration worst is most of what shows a scale: of the rest the gain counts.
  const bool is_trimmed = strictness < 1.0;
  if (fit.size() < kFewestArcs) return std::nullopt;
  const auto squared = [&](double log2) {
    const double scale = std::exp2(log2);
    return fit.Squared(scale * A_CB, scale * lever_arm);
  };
  const double free = fit.FreeSquared(), explained = fit.Signal() - free;
  const double configured = squared(0.0), limit = strictness * kSignificantScale * fit.Variance();
  // The best ratio explains no more than a free fit: most recordings end here.
  if (configured - free < limit) return std::nullopt;
  if (!is_trimmed && explained < kExplainedByFar * fit.Signal()) return std::nullopt;
  ScaledFit best;
  const auto search = [&](double from, double to, double step) {
    const int steps = static_cast<int>(std::lround((to - from) / step));
    for (int i = 0; i <= steps; ++i) {
      const double log2 = from + i * step, found = squared(log2);
      if (found < best.squared) best = {log2, found};
    }
  };
  search(-kMostRatio, kMostRatio, kCoarse);
  search(best.log2 - kCoarse, best.log2 + kCoarse, kFine);
  if (std::abs(best.log2) < kLeastRatio || configured - best.squared < limit) return std::nullopt;
  const bool is_far = std::abs(best.log2) > kFarRatio;
  if (!is_trimmed && !is_far && explained < kExplained * fit.Signal()) return std::nullopt;
  const double left = is_far ? kLeftByFar : kLeft;
  if (!is_trimmed && best.squared - free > left * explained) return std::nullopt;
  return std::exp2(best.log2);
}

}  // namespace highwall
