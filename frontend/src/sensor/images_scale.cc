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
// Of what a free fit explains: the part of it that a free fit of this kind must explain, and the
// part that the ratio may leave.
constexpr double kExplained = 0.5, kLeft = 0.04;

struct ScaledFit {
  double log2 = 0.0, squared = std::numeric_limits<double>::infinity();
};

}  // namespace

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
  if (!is_trimmed && explained < kExplained * fit.Signal()) return std::nullopt;
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
  if (!is_trimmed && best.squared - free > kLeft * explained) return std::nullopt;
  return std::exp2(best.log2);
}

}  // namespace highwall
