#include "system/motion_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <highwall/core/so3.h>
#include <highwall/internal/median.h>

#include "tracking/constant_velocity.h"

namespace highwall {
namespace {

constexpr std::size_t kFewest = 30;       // second differences, each of three axes
constexpr double kMedianOfChi2 = 0.4549;  // of one degree of freedom

// Mean variance of an axis of position [m^2] and rotation [rad^2] by the stated information.
struct StatedVariance {
  double position, rotation;
};

std::optional<StatedVariance> Stated(const MeasuredPose& pose) {
  if (!pose.information) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(pose.information->cast<double>());
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix<double, 6, 1> variances =
      llt.solve(Eigen::Matrix<double, 6, 6>::Identity()).diagonal();
  if (!variances.allFinite() || variances.minCoeff() <= 0.0) return std::nullopt;
  return StatedVariance{variances.head<3>().mean(), variances.tail<3>().mean()};
}

// Squared second difference of an axis of three poses, with what its variance consists of: that of
// the stated noise, and that of white noise on the acceleration of density one.
struct SecondDifference {
  double square, stated, motion;
};
using SecondDifferences = std::vector<SecondDifference>;

void Add(const Eigen::Vector3d& difference, double stated, double motion,
         SecondDifferences* differences) {
  for (const double e : difference) differences->push_back({e * e, stated, motion});
}

// Second differences over `steps` frames, by position and rotation.
std::array<SecondDifferences, 2> Collect(std::span<const MeasuredPose> poses,
                                         const std::vector<std::optional<StatedVariance>>& stated,
                                         std::size_t steps) {
  std::array<SecondDifferences, 2> all;
  for (std::size_t a = 0; a + 2 * steps < poses.size(); ++a) {
    const std::size_t b = a + steps, c = b + steps;
    if (!stated[a] || !stated[b] || !stated[c]) continue;
    const double before = ToSeconds(poses[b].stamp - poses[a].stamp);
    const double after = ToSeconds(poses[c].stamp - poses[b].stamp);
    if (std::max(before, after) > ConstantVelocity::kLongestPrediction) continue;
    // A camera that reverses its motion in between has no random acceleration: what two steps then
    // differ by would count as noise of the poses, which readings of an IMU do not need to predict.
    if (poses[c].readings == nullptr && before + after > ConstantVelocity::kLongestPrediction) {
      continue;
    }
    const double ratio = after / before;
    if (ratio > 2.0 || ratio < 0.5) continue;             // a missing image
    const auto noise = [&](double StatedVariance::*of) {  // Eq. 7
      return (*stated[c]).*of + (1 + ratio) * (1 + ratio) * ((*stated[b]).*of) +
             ratio * ratio * ((*stated[a]).*of);
    };
    const double of_motion = after * after * (before + after) / 3.0;  // Eq. 8
    const Pose &A = poses[a].T_WB, &B = poses[b].T_WB, &C = poses[c].T_WB;
    Add(C.p() - B.p() - ratio * (B.p() - A.p()), noise(&StatedVariance::position), of_motion,
        &all[0]);
    Add(so3::Log(B.q().conjugate() * C.q()) - ratio * so3::Log(A.q().conjugate() * B.q()),
        noise(&StatedVariance::rotation), of_motion, &all[1]);
  }
  return all;
}

// Variance of the noise over the stated one, and the density of the acceleration.
struct Shares {
  double noise = 1.0, motion = 0.0;

  double Of(const SecondDifference& d) const { return noise * d.stated + motion * d.motion; }
};

template <class Function>
double MedianOf(const SecondDifferences& differences, const Function& function) {
  std::vector<double> values;
  values.reserve(differences.size());
  for (const SecondDifference& d : differences) values.push_back(function(d));
  return UpperMedian(std::move(values));
}

// A typical second difference: its square is the median square that `shares` leave unexplained,
// times what they expect.
SecondDifference Typical(const SecondDifferences& differences, const Shares& shares) {
  SecondDifference typical{
      0.0, MedianOf(differences, [](const SecondDifference& d) { return d.stated; }),
      MedianOf(differences, [](const SecondDifference& d) { return d.motion; })};
  typical.square =
      shares.Of(typical) / kMedianOfChi2 *
      MedianOf(differences, [&](const SecondDifference& d) { return d.square / shares.Of(d); });
  return typical;
}

// Solves Eq. 9: shares by which the squares of both lists are chi-squared in the median.
Shares Solve(const SecondDifferences& one, const SecondDifferences& two) {
  // Neither share vanishes: a camera at rest is smoothed over many frames, not over all, and a fast
  // one keeps its poses.
  constexpr double kLeast = 0.01;
  constexpr int kIterations = 10;  // where steps are equal the first is exact
  Shares shares;
  for (int i = 0; i < kIterations; ++i) {
    const SecondDifference a = Typical(one, shares), b = Typical(two, shares);
    const double determinant = a.stated * b.motion - b.stated * a.motion;
    const double noise = (a.square * b.motion - b.square * a.motion) / determinant;
    const double motion = (a.stated * b.square - b.stated * a.square) / determinant;
    shares = {std::max(noise, kLeast * a.square / a.stated),
              std::max(motion, kLeast * b.square / b.motion)};
  }
  return shares;
}

}  // namespace

std::optional<MotionNoise> EstimateMotionNoise(std::span<const MeasuredPose> poses) {
  std::vector<std::optional<StatedVariance>> stated;
  stated.reserve(poses.size());
  for (const MeasuredPose& pose : poses) stated.push_back(Stated(pose));
  const auto one = Collect(poses, stated, 1), two = Collect(poses, stated, 2);
  if (std::min(one[0].size(), two[0].size()) < 3 * kFewest) return std::nullopt;
  const Shares position = Solve(one[0], two[0]), rotation = Solve(one[1], two[1]);
  for (const double share : {position.noise, position.motion, rotation.noise, rotation.motion}) {
    // Not so where poses do not differ at all.
    if (!std::isfinite(share) || share <= 0.0) return std::nullopt;
  }
  return MotionNoise{
      {position.motion, rotation.motion}, std::sqrt(position.noise), std::sqrt(rotation.noise)};
}

Eigen::Matrix<double, 6, 6> RootInformation(const MeasuredPose& pose, const MotionNoise& noise) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(pose.information->cast<double>());
  const Matrix6 root_B =
      eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  Matrix6 root = root_B;
  root.leftCols<3>() = root_B.leftCols<3>() * pose.T_WB.R().transpose() / noise.position_scale;
  root.rightCols<3>() = root_B.rightCols<3>() / noise.rotation_scale;
  return root;
}

}  // namespace highwall
