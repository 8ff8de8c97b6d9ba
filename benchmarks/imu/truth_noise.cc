#include "truth_noise.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <highwall/internal/median.h>

namespace highwall::bench {
namespace {

constexpr double kSaturated = 16.0;  // [s]
constexpr std::size_t kFewest = 6;   // minimum number of windows of a length, for a median

// Variances per axis of rotation, velocity and position over windows: measured, and expected from
// the IMU.
struct Spread {
  Eigen::Vector3d measured = Eigen::Vector3d::Zero(), of_imu = Eigen::Vector3d::Zero();

  Eigen::Vector3d Excess() const { return (measured - of_imu).cwiseMax(0.0); }
};

std::optional<Spread> SpreadOver(const Recording& recording, double length, const ImuNoise& noise,
                                 const Eigen::Vector3d& gravity_W) {
  const Windows windows = Cut(recording, length, noise);
  if (windows.all.size() < kFewest) return std::nullopt;
  Spread spread;
  for (int part = 0; part < 3; ++part) {
    std::vector<double> squares, variances;
    for (const Window& w : windows.all) {
      squares.push_back(PredictionError(w, gravity_W).segment<3>(3 * part).squaredNorm());
      variances.push_back(w.imu.covariance().diagonal().segment<3>(3 * part).mean());
    }
    spread.measured[part] = UpperMedian(squares) / kMedianOfChi2;
    spread.of_imu[part] = UpperMedian(variances);
  }
  return spread;
}

// Interpolates between the neighbours of `length` by a power law.
double Interpolate(const std::map<double, double>& values, double length) {
  auto after = values.lower_bound(length);
  if (after == values.end()) return values.rbegin()->second;
  if (after == values.begin() || after->first == length) return after->second;
  const auto before = std::prev(after);
  if (before->second <= 0.0 || after->second <= 0.0) return after->second;
  const double share = std::log(length / before->first) / std::log(after->first / before->first);
  return before->second * std::pow(after->second / before->second, share);
}

}  // namespace

Eigen::Matrix<double, 9, 9> TruthNoise::Covariance(const Window& window) const {
  const ImuDelta& delta = window.imu.delta();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const auto turned = [&](const Eigen::Vector3d& x) {
    return orientation * orientation * (x.squaredNorm() * I - x * x.transpose());
  };
  const double turn = Interpolate(rotation, delta.duration);
  Eigen::Matrix<double, 9, 9> P = Eigen::Matrix<double, 9, 9>::Zero();
  P.block<3, 3>(0, 0) = turn * turn * I;
  P.block<3, 3>(3, 3) = 2.0 * velocity * velocity * I + turned(delta.v);
  P.block<3, 3>(6, 6) =
      (2.0 * position * position + std::pow(velocity * delta.duration, 2)) * I + turned(delta.p);
  return P;
}

TruthNoise EstimateTruthNoise(const Recording& recording, const ImuNoise& noise,
                              const Eigen::Vector3d& gravity_W, double left_out) {
  TruthNoise truth;
  for (double length = 0.0625; length <= kSaturated; length *= 2.0) {
    if (length == left_out) continue;
    const auto spread = SpreadOver(recording, length, noise, gravity_W);
    if (!spread) break;
    truth.rotation[length] = std::sqrt(spread->Excess()[0]);
    truth.orientation = truth.rotation[length] / std::sqrt(2.0);  // both ends; longest one counts
  }
  const double brevity = left_out == 0.1 ? 0.2 : 0.1;  // [s]
  const auto spread = SpreadOver(recording, brevity, noise, gravity_W);
  if (!spread) return truth;
  const Eigen::Vector3d brief = spread->Excess();
  // A tilt rotates two of three axes.
  const double tilt = 2.0 / 3.0 * std::pow(truth.orientation * gravity_W.norm() * brevity, 2);
  const double velocity = std::max(0.0, 0.5 * (brief[1] - tilt));
  const double position =
      0.5 * (brief[2] - velocity * brevity * brevity - 0.25 * tilt * brevity * brevity);
  truth.velocity = std::sqrt(velocity);
  truth.position = std::sqrt(std::max(0.0, position));
  return truth;
}

}  // namespace highwall::bench
