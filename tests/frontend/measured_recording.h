#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include <highwall/core/so3.h>
#include <highwall/factors/white_acceleration.h>

#include "system/pose_smoother.h"

// Shared by the tests of smoothing: motions with measured poses.
namespace highwall::smoothing_test {

inline constexpr double kStep = 1.0 / 30.0;  // [s]

inline Eigen::Vector3d Normal(std::mt19937& rng, double sigma) {
  std::normal_distribution<double> normal(0.0, sigma);
  const double x = normal(rng), y = normal(rng), z = normal(rng);
  return {x, y, z};
}

inline ImageInformation Information(double position_sigma, double rotation_sigma) {
  Eigen::Matrix<float, 6, 1> diagonal;
  diagonal << Eigen::Vector3f::Constant(
      static_cast<float>(1.0 / (position_sigma * position_sigma))),
      Eigen::Vector3f::Constant(static_cast<float>(1.0 / (rotation_sigma * rotation_sigma)));
  return diagonal.asDiagonal();
}

using Vector6 = Eigen::Matrix<double, 6, 1>;

// A recording of a motion, as it is and as it is measured.
struct Recording {
  std::vector<Pose> truth;
  std::vector<Vector6> velocities;  // v_WB and omega_B of each, where they are known
  std::vector<MeasuredPose> measured;

  // Adds a frame. The measured pose has an error of both sigmas and states `information`.
  void Add(double seconds, const Pose& T_WC, double position_sigma, double rotation_sigma,
           const ImageInformation& information, std::mt19937& rng) {
    truth.push_back(T_WC);
    const Eigen::Vector3d turn = Normal(rng, rotation_sigma), shift = Normal(rng, position_sigma);
    measured.push_back({static_cast<Stamp>(std::llround(seconds * 1e9)),
                        Pose(T_WC.q() * so3::Exp(turn), T_WC.p() + shift), information});
  }
};

// White noise on the accelerations, integrated in ten steps a frame.
inline Recording RandomMotion(int frames, const AccelerationNoise& noise, double position_sigma,
                              double rotation_sigma, const ImageInformation& information,
                              unsigned seed) {
  std::mt19937 rng(seed);
  Recording recording;
  constexpr int kSteps = 10;
  const double dt = kStep / kSteps;
  Eigen::Vector3d p(1, 2, 3), v(0.2, 0, -0.1), w(0.3, -0.2, 0.1);
  Eigen::Quaterniond q = so3::Exp({0.3, -0.5, 1.0});
  for (int i = 0; i < frames; ++i) {
    recording.Add(i * kStep, Pose(q, p), position_sigma, rotation_sigma, information, rng);
    recording.velocities.emplace_back() << v, w;
    for (int k = 0; k < kSteps; ++k) {
      const Eigen::Vector3d dv = Normal(rng, std::sqrt(noise.linear * dt));
      const Eigen::Vector3d dw = Normal(rng, std::sqrt(noise.angular * dt));
      p += dt * (v + 0.5 * dv);
      q = (q * so3::Exp(dt * (w + 0.5 * dw))).normalized();
      v += dv;
      w += dw;
    }
  }
  return recording;
}

// The motion of a hand.
inline constexpr AccelerationNoise kHand{.linear = 0.02, .angular = 0.3};
inline constexpr double kPosition = 2e-3, kRotation = 2e-3;  // [m], [rad]

inline Recording Hand(int frames, unsigned seed) {
  return RandomMotion(frames, kHand, kPosition, kRotation, Information(kPosition, kRotation), seed);
}

inline double PositionRmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) sum += (poses[i].p() - truth[i].p()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

inline double RotationRmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    sum += so3::Log(poses[i].q().conjugate() * truth[i].q()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

inline std::vector<Pose> Measured(const Recording& recording) {
  std::vector<Pose> poses;
  for (const MeasuredPose& pose : recording.measured) poses.push_back(pose.T_WB);
  return poses;
}

// The poses after smoothing; those that are not smoothed are as they were measured.
inline std::vector<Pose> Smooth(const std::vector<MeasuredPose>& measured,
                                const std::optional<Eigen::Vector3d>& gravity_W = std::nullopt) {
  const std::vector<std::optional<SmoothedPose>> smoothed = SmoothPoses(measured, gravity_W);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    poses.push_back(smoothed[i] ? smoothed[i]->T_WB : measured[i].T_WB);
  }
  return poses;
}

// Largest errors of the way from one pose to the next [m], where another window of a thousand
// frames begins, and elsewhere.
struct StepErrors {
  double at_seams = 0.0, elsewhere = 0.0;
};

inline StepErrors ErrorsOfSteps(const std::vector<Pose>& smoothed, const std::vector<Pose>& truth) {
  StepErrors errors;
  for (std::size_t i = 1; i < smoothed.size(); ++i) {
    const Eigen::Vector3d step = smoothed[i].p() - smoothed[i - 1].p();
    double& largest = i % 1000 == 0 ? errors.at_seams : errors.elsewhere;
    largest = std::max(largest, (step - (truth[i].p() - truth[i - 1].p())).norm());
  }
  return errors;
}

// Of the velocities of a recording.
struct VelocityErrors {
  int frames = 0;
  double linear = 0.0, angular = 0.0;        // RMS [m/s], [rad/s]
  double of_linear = 0.0, of_angular = 0.0;  // means of e^T C^-1 e
};

inline VelocityErrors ErrorsOfVelocities(const Recording& recording,
                                         const std::optional<Eigen::Vector3d>& gravity_W) {
  const auto smoothed = SmoothPoses(recording.measured, gravity_W);
  VelocityErrors errors;
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    if (!smoothed[i] || !smoothed[i]->velocity) continue;
    const BodyVelocity& velocity = *smoothed[i]->velocity;
    const Eigen::Vector3d v = velocity.v_WB - recording.velocities[i].head<3>();
    const Eigen::Vector3d w = velocity.omega_B - recording.velocities[i].tail<3>();
    const Eigen::Matrix3d C_v = velocity.covariance.topLeftCorner<3, 3>();
    const Eigen::Matrix3d C_w = velocity.covariance.bottomRightCorner<3, 3>();
    ++errors.frames;
    errors.linear += v.squaredNorm();
    errors.angular += w.squaredNorm();
    errors.of_linear += v.dot(C_v.inverse() * v);
    errors.of_angular += w.dot(C_w.inverse() * w);
  }
  errors.linear = std::sqrt(errors.linear / errors.frames);
  errors.angular = std::sqrt(errors.angular / errors.frames);
  errors.of_linear /= errors.frames;
  errors.of_angular /= errors.frames;
  return errors;
}

}  // namespace highwall::smoothing_test
