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

std::vector<std::optional<StatedVariance>> StatedOf(std::span<const MeasuredPose> poses) {
  std::vector<std::optional<StatedVariance>> stated;
  stated.reserve(poses.size());
  for (const MeasuredPose& pose : poses) stated.push_back(Stated(pose));
  return stated;
}

// Returns the variance of a second difference of three values with the variances given, the second
// step being `ratio` times as long as the first.                                           Eq. 7
double StatedNoise(const std::array<double, 3>& variances, double ratio) {
  return variances[2] + (1 + ratio) * (1 + ratio) * variances[1] + ratio * ratio * variances[0];
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
    if (ratio > 2.0 || ratio < 0.5) continue;  // a missing image
    const auto noise = [&](double StatedVariance::*of) {
      return StatedNoise({(*stated[a]).*of, (*stated[b]).*of, (*stated[c]).*of}, ratio);
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

// Second differences of three poses that readings do not explain.
struct Unexplained {
  Eigen::Vector3d position, rotation;
  double ratio;  // of the second step to the first
};

// steps: readings of both. The velocity of the first pose is that by which it comes to the second,
// and a bias of the gyroscope is the same in both steps.
Unexplained UnexplainedBy(const std::array<Pose, 3>& T_WB, const std::array<ImuDelta, 2>& steps,
                          const Eigen::Vector3d& gravity_W) {
  const auto& [A, B, C] = T_WB;
  const auto& [first, second] = steps;
  const double t = first.duration, ratio = second.duration / t;
  const Eigen::Vector3d v_A = (B.p() - A.p() - 0.5 * t * t * gravity_W - A.R() * first.p) / t;
  const Eigen::Vector3d v_B = v_A + t * gravity_W + A.R() * first.v;
  const double u = second.duration;
  const Eigen::Vector3d p_C = B.p() + u * v_B + 0.5 * u * u * gravity_W + B.R() * second.p;
  const auto turn = [](const Pose& from, const Pose& to, const ImuDelta& step) {
    return so3::Log(step.q.conjugate() * from.q().conjugate() * to.q());
  };
  return {C.p() - p_C, turn(B, C, second) - ratio * turn(A, B, first), ratio};
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
  const std::vector<std::optional<StatedVariance>> stated = StatedOf(poses);
  const auto one = Collect(poses, stated, 1), two = Collect(poses, stated, 2);
  if (std::min(one[0].size(), two[0].size()) < 3 * kFewest) return std::nullopt;
  const Shares position = Solve(one[0], two[0]), rotation = Solve(one[1], two[1]);
  for (const double share : {position.noise, position.motion, rotation.noise, rotation.motion}) {
    // Not so where poses do not differ at all.
    if (!std::isfinite(share) || share <= 0.0) return std::nullopt;
  }
  return MotionNoise{{position.motion, rotation.motion},
                     {std::sqrt(position.noise), std::sqrt(rotation.noise)}};
}

std::optional<PoseNoise> EstimatePoseNoise(std::span<const MeasuredPose> poses,
                                           std::span<const ImuPreintegration> readings,
                                           const Eigen::Vector3d& gravity_W) {
  const std::vector<std::optional<StatedVariance>> stated = StatedOf(poses);
  SecondDifferences position, rotation;
  for (std::size_t a = 0; a + 2 < poses.size(); ++a) {
    if (!stated[a] || !stated[a + 1] || !stated[a + 2]) continue;
    const Unexplained unexplained =
        UnexplainedBy({poses[a].T_WB, poses[a + 1].T_WB, poses[a + 2].T_WB},
                      {readings[a].delta(), readings[a + 1].delta()}, gravity_W);
    const auto noise = [&](double StatedVariance::*of) {
      return StatedNoise({(*stated[a]).*of, (*stated[a + 1]).*of, (*stated[a + 2]).*of},
                         unexplained.ratio);
    };
    Add(unexplained.position, noise(&StatedVariance::position), 0.0, &position);
    Add(unexplained.rotation, noise(&StatedVariance::rotation), 0.0, &rotation);
  }
  if (position.size() < 3 * kFewest) return std::nullopt;
  const auto scale = [](const SecondDifferences& differences) {
    return std::sqrt(
        MedianOf(differences, [](const SecondDifference& d) { return d.square / d.stated; }) /
        kMedianOfChi2);
  };
  const PoseNoise noise{scale(position), scale(rotation)};
  for (const double value : {noise.position, noise.rotation}) {
    if (!std::isfinite(value) || value <= 0.0) return std::nullopt;
  }
  return noise;
}

Eigen::Matrix<double, 6, 6> RootInformation(const MeasuredPose& pose, const PoseNoise& noise) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(pose.information->cast<double>());
  const Matrix6 root_B =
      eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  Matrix6 root = root_B;
  root.leftCols<3>() = root_B.leftCols<3>() * pose.T_WB.R().transpose() / noise.position;
  root.rightCols<3>() = root_B.rightCols<3>() / noise.rotation;
  return root;
}

}  // namespace highwall
