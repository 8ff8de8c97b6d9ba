#include "calibration/axes_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <highwall/core/so3.h>
#include <highwall/core/stamp.h>

#include "inertial/imu_saturation.h"

namespace highwall {
namespace {

constexpr std::size_t kFewest = 8;

// The same rotation measured by the gyroscope and by the camera.
struct Turn {
  Eigen::Vector3d body, camera;  // [rad]
  double duration = 0.0;         // [s]
};

// Returns the rotation vector of the integrated gyroscope, without bias: over a tenth of a second
// the error of the trapezoidal rule is below that of a pose. Empty if readings are missing or
// saturated at `range`.
std::optional<Eigen::Vector3d> GyroscopeTurn(const ImuBuffer& readings, Stamp begin, Stamp end,
                                             double range) {
  const auto interval = readings.Between(begin, end);
  if (!interval || interval->HasGap()) return std::nullopt;
  const auto is_saturated = [range](const ImuSample& s) { return EndsAt(s.gyroscope, range); };
  if (std::ranges::any_of(interval->samples, is_saturated)) return std::nullopt;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (std::size_t i = 1; i < interval->samples.size(); ++i) {
    const ImuSample &a = interval->samples[i - 1], &b = interval->samples[i];
    q = q * so3::Exp(0.5 * ToSeconds(b.stamp - a.stamp) * (a.gyroscope + b.gyroscope));
  }
  return so3::Log(q);
}

std::vector<Turn> TurnsAt(const Trajectory& poses, const ImuBuffer& readings, double time_offset,
                          double max_interval, double gyroscope_range) {
  std::vector<Turn> turns;
  const Stamp shift = FromSeconds(time_offset);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double duration = ToSeconds(poses[i].stamp - poses[i - 1].stamp);
    if (duration <= 0.0 || duration > max_interval) continue;
    const auto body = GyroscopeTurn(readings, poses[i - 1].stamp + shift, poses[i].stamp + shift,
                                    gyroscope_range);
    if (!body) continue;
    turns.push_back(
        {*body, so3::Log(poses[i - 1].pose.q().conjugate() * poses[i].pose.q()), duration});
  }
  return turns;
}

// Least squares over rotation and bias: body = R camera + bias * duration.
AxesAlignment Align(const std::vector<Turn>& turns) {
  double time = 0.0;
  Eigen::Vector3d body = Eigen::Vector3d::Zero(), camera = Eigen::Vector3d::Zero();
  for (const Turn& turn : turns) {
    time += turn.duration;
    body += turn.body;
    camera += turn.camera;
  }
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero(), spread = Eigen::Matrix3d::Zero();
  for (const Turn& turn : turns) {
    const Eigen::Vector3d c = turn.camera - turn.duration / time * camera;
    H += c * (turn.body - turn.duration / time * body).transpose();
    spread += turn.camera * turn.camera.transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d sign = Eigen::Matrix3d::Identity();
  sign(2, 2) = (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d R_BC = svd.matrixV() * sign * svd.matrixU().transpose();

  AxesAlignment alignment;
  alignment.q_BC = Eigen::Quaterniond(R_BC);
  alignment.gyroscope_bias = (body - R_BC * camera) / time;
  const auto count = static_cast<double>(turns.size());
  for (const Turn& turn : turns) {
    alignment.error +=
        (turn.body - R_BC * turn.camera - turn.duration * alignment.gyroscope_bias).squaredNorm();
  }
  alignment.error = std::sqrt(alignment.error / count);
  // Two axes suffice for a rotation: the second smallest of the three eigenvalues.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  alignment.excitation = std::sqrt(std::max(0.0, axes.eigenvalues()[1]) / count);
  return alignment;
}

}  // namespace

std::optional<AxesAlignment> AlignAxes(const Trajectory& poses, const ImuBuffer& readings,
                                       double max_time_offset, double max_interval,
                                       double gyroscope_range) {
  AxesAlignment best;
  best.error = std::numeric_limits<double>::infinity();
  const auto attempt = [&](double time_offset) {
    const std::vector<Turn> turns =
        TurnsAt(poses, readings, time_offset, max_interval, gyroscope_range);
    if (turns.size() < kFewest) return;
    AxesAlignment alignment = Align(turns);
    alignment.time_offset = time_offset;
    if (alignment.error < best.error) best = alignment;
  };
  constexpr double kCoarse = 0.01, kFine = 0.001;  // [s]
  const int coarse = static_cast<int>(std::floor(max_time_offset / kCoarse));
  for (int i = -coarse; i <= coarse; ++i) attempt(i * kCoarse);
  if (!std::isfinite(best.error)) return std::nullopt;
  const double middle = best.time_offset;
  for (int i = -9; i <= 9; ++i) attempt(middle + i * kFine);
  return best;
}

}  // namespace highwall
