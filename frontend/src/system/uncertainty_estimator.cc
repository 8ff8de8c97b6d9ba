#include "system/uncertainty_estimator.h"

#include <algorithm>

#include "map/pose_covariance.h"

namespace highwall {
namespace {

using Covariance = UncertaintyEstimator::Covariance;

// Standard deviations of the accelerations of a camera in a hand or on a vehicle.
constexpr double kAcceleration = 3.0;          // [m/s^2]
constexpr double kAngularAcceleration = 10.0;  // [rad/s^2]

// Returns the covariance of the motion over dt [s] that is predicted at constant velocity.
Covariance PredictionNoise(double dt) {
  constexpr double kShortest = 5e-3;  // [s] Stamps that repeat or jitter promise nothing.
  dt = std::max(dt, kShortest);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Eigen::Vector3d::Constant(kAcceleration),
      Eigen::Vector3d::Constant(kAngularAcceleration);
  sigma *= dt * dt;  // half of it by the mean velocity, half by the one that is predicted
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

PoseUncertainty UncertaintyEstimator::OfImage(Stamp stamp, const AnchoredPose& pose,
                                              const Image& image) {
  // The errors of the landmarks, each of which is the mean of its observations, add to that of the
  // image.
  const double scale = 1.0 + 1.0 / image.observers;
  const Covariance information =
      image.information_C / (scale * std::max(image.error, noise_.min_error));
  const Covariance predicted =
      measured_ ? Covariance(covariance_ + PredictionNoise(ToSeconds(stamp - *measured_)))
                : Covariance(1e6 * Covariance::Identity());
  const Covariance in_keyframe = LowerCovariance(predicted, information);
  // The errors of neighbouring keyframes are not independent, and add up.
  of_keyframe_ = std::max(1.0, noise_.scale / scale) * in_keyframe;
  of_keyframe_.diagonal().head<3>().array() += noise_.position * noise_.position;
  of_keyframe_.diagonal().tail<3>().array() += noise_.rotation * noise_.rotation;
  if (!image.information_C.isZero(0.0)) {
    measured_ = stamp;
    covariance_ = in_keyframe;
  }
  return {pose.reference, in_keyframe, InMap(pose.reference, pose.T_reference_C, in_keyframe)};
}

PoseUncertainty UncertaintyEstimator::OfSmoother(Stamp stamp, const AnchoredPose& pose,
                                                 const Covariance& covariance_C) {
  measured_ = stamp;
  covariance_ = of_keyframe_ = covariance_C;
  return {pose.reference, covariance_C, InMap(pose.reference, pose.T_reference_C, covariance_C)};
}

PoseUncertainty UncertaintyEstimator::Predicted(PoseUncertainty now, double dt) {
  const Covariance noise = PredictionNoise(dt);
  now.in_keyframe += noise;
  now.in_map += noise;
  return now;
}

PoseUncertainty UncertaintyEstimator::OfOrigin(Stamp stamp) {
  measured_ = stamp;
  covariance_.setZero();
  of_keyframe_.setZero();
  return {};
}

void UncertaintyEstimator::AddKeyFrame(KeyFrameId id, Map* map) {
  KeyFrame& keyframe = *map->keyframe(id);
  // A metre and a radian at most: in single precision, more would hide what is known.
  const Covariance rounding = 1e-12 * Covariance::Identity();
  keyframe.covariance =
      LowerCovariance(of_keyframe_ + rounding, Covariance::Identity()).cast<float>();
  std::optional<Covariance> best;
  const auto covisible = map->Covisible(id, 1);
  for (const auto& [other, shared] : covisible) {
    if (2 * shared < covisible.front().second) break;
    const Covariance by_other =
        InMap(other, map->keyframe(other)->T_WC.Inverse() * keyframe.T_WC, of_keyframe_);
    if (!best || by_other.topLeftCorner<3, 3>().trace() < best->topLeftCorner<3, 3>().trace()) {
      best = by_other;
    }
  }
  keyframes_[id] = best.value_or(of_keyframe_).cast<float>();
}

Covariance UncertaintyEstimator::InMap(KeyFrameId keyframe, const Pose& T_keyframe_C,
                                       const Covariance& in_keyframe) const {
  const auto of_keyframe = keyframes_.find(keyframe);
  if (of_keyframe == keyframes_.end()) return in_keyframe;
  return in_keyframe + CarriedTo(T_keyframe_C.Inverse(), of_keyframe->second.cast<double>());
}

}  // namespace highwall
