#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <ceres/loss_function.h>

#include <highwall/core/prior.h>
#include <highwall/core/sliding_window_smoother.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/point_reprojection.h>

// What your tracker says about one feature of an image.
struct Feature {
  int landmark;        // the same number in every image that shows it
  Eigen::Vector2d uv;  // [px] without distortion
  double depth;        // [m]
};

class InertialTrajectory {
 public:
  InertialTrajectory(const highwall::PinholeCamera& camera, const highwall::Pose& T_BC,
                     const highwall::ImuNoise& noise, const highwall::ImuState& start)
      : camera_(camera), T_BC_(T_BC), projection_(camera, T_BC), noise_(noise), state_(start) {}

  // Every reading, until at least one after the next image.
  void AddReading(const highwall::ImuSample& reading) { readings_.Add(reading); }

  // The pose of the body when the image was taken; empty where readings are missing.
  std::optional<highwall::Pose> AddImage(highwall::Stamp stamp,
                                         const std::vector<Feature>& features) {
    using namespace highwall;
    std::optional<ImuPreintegration> imu;
    if (last_) {
      const std::optional<ImuInterval> interval = readings_.Between(last_->stamp, stamp);
      if (!interval || interval->HasGap()) return std::nullopt;
      imu.emplace(interval->samples, bias_, ImuPreintegrationOptions{.noise = noise_});
      state_ = imu->Predict(state_, bias_, kGravity_W);
    }
    const Image now{stamp, smoother_.AddState(stamp, state_.T_WB),
                    smoother_.AddState(stamp, state_.v_WB), smoother_.AddState(stamp, bias_)};
    if (imu) {
      smoother_.AddFactor(std::make_unique<ImuFactor>(*imu, kGravity_W), last_->pose,
                          last_->velocity, last_->bias, now.pose, now.velocity, now.bias);
    } else {
      AddPriors(now);
    }
    for (const Feature& feature : features) See(now, feature);
    if (!smoother_.Update().accepted) return std::nullopt;
    state_ = {smoother_.Value(now.pose), smoother_.Value(now.velocity)};
    bias_ = smoother_.Value(now.bias);
    last_ = now;
    return state_.T_WB;
  }

  const highwall::ImuState& state() const { return state_; }
  const highwall::ImuBias& bias() const { return bias_; }

 private:
  struct Image {
    highwall::Stamp stamp;
    highwall::Variable<highwall::Pose> pose;
    highwall::Variable<Eigen::Vector3d> velocity;
    highwall::Variable<highwall::ImuBias> bias;
  };

  // What is known before the first image: the origin is where it is taken, up is known to half a
  // degree, velocity to 5 cm/s, the biases as the data sheet says.
  void AddPriors(const Image& first) {
    using namespace highwall;
    Eigen::Matrix<double, 6, 1> pose, bias;
    pose << 1e-4, 1e-4, 1e-4, 0.01, 0.01, 1e-4;  // [m], [rad]
    bias << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1;     // [rad/s], [m/s^2]
    smoother_.AddFactor(
        std::make_unique<PosePrior>(state_.T_WB, pose.cwiseInverse().asDiagonal().toDenseMatrix()),
        first.pose);
    smoother_.AddFactor(
        std::make_unique<VectorPrior<3>>(state_.v_WB, Eigen::Matrix3d::Identity() / 0.05),
        first.velocity);
    smoother_.AddFactor(
        std::make_unique<VectorPrior<6>>(bias_, bias.cwiseInverse().asDiagonal().toDenseMatrix()),
        first.bias);
  }

  void See(const Image& image, const Feature& feature) {
    using namespace highwall;
    const Eigen::Vector3d p_C = camera_.Unproject(feature.uv, feature.depth);
    const auto known = landmarks_.find(feature.landmark);
    if (known == landmarks_.end() || !smoother_.Contains(known->second)) {
      landmarks_[feature.landmark] = smoother_.AddLandmark(Point(state_.T_WB * (T_BC_ * p_C)));
    }
    const VirtualRightCamera right{.fx = camera_.fx, .baseline = projection_.baseline()};
    const Eigen::Matrix3d W = PointSqrtInformation(
        Weighting::kCovariance, 1.0, DepthNoise().DisparitySigma(feature.depth, right));
    smoother_.AddFactor(
        std::make_unique<PointReprojectionRgbd>(projection_.Project(p_C), W, projection_),
        std::make_shared<ceres::HuberLoss>(2.5), image.pose, landmarks_[feature.landmark]);
  }

  const Eigen::Vector3d kGravity_W{0.0, 0.0, -highwall::kStandardGravity};
  const highwall::PinholeCamera camera_;
  const highwall::Pose T_BC_;
  const highwall::RgbdProjection projection_;
  const highwall::ImuNoise noise_;
  highwall::ImuBuffer readings_;
  highwall::SlidingWindowSmoother smoother_;
  std::map<int, highwall::Variable<highwall::Point>> landmarks_;
  std::optional<Image> last_;
  highwall::ImuState state_;
  highwall::ImuBias bias_ = highwall::ImuBias::Zero();
};
