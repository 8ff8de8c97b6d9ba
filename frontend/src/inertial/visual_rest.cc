#include "inertial/visual_rest.h"

#include <algorithm>
#include <cmath>

namespace highwall {
namespace {

constexpr double kRestSeconds = 2.0;      // [s] of images
constexpr double kRestStep = 0.5;         // [s] between two of them
constexpr double kRestScatter = 3e-4;     // [m] lower bound of the position noise of an image
constexpr double kRestSpeedChi2 = 16.27;  // 99.9 % of three degrees of freedom
// [m/s] A camera that moves faster is not stationary, however large the scatter of its positions.
constexpr double kRestSpeed = 3e-3;

}  // namespace

void VisualRest::Add(Stamp stamp, const Eigen::Vector3d& p) {
  const bool is_continuous =
      !positions_.empty() && ToSeconds(stamp - positions_.back().stamp) <= kRestStep;
  if (!is_continuous) positions_.clear();
  positions_.push_back({stamp, p});
  // The newest position that is old enough is kept, so that the positions cover the full time.
  while (positions_.size() > 2 && ToSeconds(stamp - positions_[1].stamp) >= kRestSeconds) {
    positions_.pop_front();
  }
}

bool VisualRest::Agrees() const {
  if (positions_.size() < 5) return false;
  const Stamp first = positions_.front().stamp;
  if (ToSeconds(positions_.back().stamp - first) < kRestSeconds - 5e-4) return false;
  const auto n = static_cast<double>(positions_.size());
  double mean_t = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Position& at : positions_) {
    mean_t += ToSeconds(at.stamp - first) / n;
    mean += at.p / n;
  }
  double squared_t = 0.0, squared = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (const Position& at : positions_) {
    const double t = ToSeconds(at.stamp - first) - mean_t;
    squared_t += t * t;
    moment += t * (at.p - mean);
  }
  const Eigen::Vector3d v = moment / squared_t;
  for (const Position& at : positions_) {
    squared += (at.p - mean - (ToSeconds(at.stamp - first) - mean_t) * v).squaredNorm();
  }
  const double scatter = std::max(kRestScatter, std::sqrt(squared / (3.0 * (n - 2.0))));
  const double sigma = scatter / std::sqrt(squared_t);
  return v.squaredNorm() <= std::min(kRestSpeedChi2 * sigma * sigma, kRestSpeed * kRestSpeed);
}

}  // namespace highwall
