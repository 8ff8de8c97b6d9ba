#include "sensor/turned_mount.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace highwall {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kFewestTurns = 25;              // of 0.1 s
constexpr double kTolerated = 3.0 * kDegree;  // of calibrations, and by errors that poses share
constexpr double kTurned = 6.0 * kDegree;
constexpr double kPriorSigma = 20.0 * kDegree;  // of the rotation
// Least variance of a component of a rotation over 0.1 s [rad^2]: half the sigma of good poses,
// since errors that last cancel in differences.
constexpr double kLeastVariance = 8e-8;

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a * b.transpose()).angle();
}

// Returns the best rotation within the tolerated angle: that with the weakest prior.
Eigen::Matrix3d BestTolerated(const GyroscopeFit& fit, const Eigen::Matrix3d& stated,
                              double weight) {
  constexpr double kFirm = 1e12, kSimilar = 1.05;  // ratios of weights
  double low = weight, high = kFirm * weight;
  while (high > kSimilar * low) {
    const double middle = std::sqrt(low * high);
    (AngleBetween(fit.RotationNear(stated, middle), stated) > kTolerated ? low : high) = middle;
  }
  return fit.RotationNear(stated, high);
}

}  // namespace

std::optional<TurnedMount> FindTurnedMount(std::span<const GyroscopeFit> fits,
                                           const Eigen::Matrix3d& R_CB) {
  constexpr double kWeight = kLeastVariance / (2.0 * kPriorSigma * kPriorSigma);
  TurnedMount best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const Eigen::Matrix3d R = fits[i].RotationNear(R_CB, kWeight);
    const double mean = fits[i].Squared(R) / std::max(fits[i].size(), 1);
    if (mean >= least) continue;
    least = mean;
    best.R_CB = R;
    best.fit = i;
  }
  const int n = fits[best.fit].size();
  if (n < kFewestTurns || AngleBetween(best.R_CB, R_CB) <= kTurned) return std::nullopt;
  double tolerated = std::numeric_limits<double>::infinity();
  for (const GyroscopeFit& fit : fits) {
    const double squared = fit.Squared(BestTolerated(fit, R_CB, kWeight));
    tolerated = std::min(tolerated, squared / std::max(fit.size(), 1));
  }
  constexpr int kUnknowns = 7;  // rotation, bias, offset of the clocks
  const double variance = std::max(n * least / (3 * n - kUnknowns), kLeastVariance);
  best.gain = n * (tolerated - least) / variance;
  return best;
}

}  // namespace highwall
