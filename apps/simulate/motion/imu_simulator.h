#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>

#include "simulate/motion/camera_path.h"
#include "simulate/motion/imu_faults.h"
#include "simulate/noise_ratio.h"
#include "simulate/random.h"

namespace highwall::simulate {

// The IMU of a RealSense D435i. Noise densities: Bosch, "BMI055 data sheet", BST-BMI055-DS000,
// 0.014 deg/s/sqrt(Hz) and 150 ug/sqrt(Hz), typical; random walks of the order that Burri et al.
// give for the EuRoC sequences, since the data sheet has none. The lever arm is that of
// librealsense; the axes of B are x forward, y left, z up, so that a missing rotation is always
// detected.
struct ImuSimulationOptions {
  bool enabled = true;  // false: the camera has no IMU
  bool ideal = false;   // no noise, no bias, no vibration
  double rate = 200.0;  // [Hz] in [20, 10000]
  Pose T_BC{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d(0.01174, 0.00552, -0.0051)};
  ImuNoise noise{.gyroscope = 2.44e-4,  // of the data sheet and calibration.yaml
                 .accelerometer = 1.47e-3,
                 .gyroscope_walk = 2e-5,
                 .accelerometer_walk = 1e-3};
  double noise_ratio = kUsualNoiseRatio;  // > 0; true densities relative to `noise`
  double gyroscope_bias = 0.005;          // [rad/s] >= 0, initial sigma of each axis
  double accelerometer_bias = 0.05;       // [m/s^2] >= 0, likewise
  ImuFaults faults{};                     // in addition to noise and biases; none in ideal readings
  double time_offset = 0.0;               // [s] in [-0.2, 0.2]: t_imu = t_cam + t_d
  // Vehicle vibration measured by the accelerometer, RMS along the axes of B at intensity 1 of the
  // scene [m/s^2] >= 0, within a band [Hz], 0 < low < high < rate / 2.
  Eigen::Vector3d vibration{1.5, 1.5, 3.0};
  double vibration_low = 20.0, vibration_high = 70.0;

  // Returns the true densities of the readings.
  ImuNoise TrueNoise() const;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// State of the body at an instant: the estimator's unknowns.
struct TrueState {
  Stamp stamp = 0;  // [ns] of the camera's clock
  ImuState state;
  ImuBias bias = ImuBias::Zero();
};

// Ground vibration of the camera, in [0, 1], as a function of the position on the spline (in its
// seconds, any). It fades out where the camera is stationary. Empty: none.
using VibrationIntensity = std::function<double(double s)>;

// Readings of an IMU attached to the camera: analytic motion with vibration, sensor axes, bias and
// white noise, and faults (ImuFaults). Everything is a function of options, seed and time. World: z
// up, g = 9.81 m/s^2.
class ImuSimulator {
 public:
  // begin, end [ns]: of the camera's clock, first and last frame; the readings extend at least half
  // a second beyond both, in either clock. Throws InvalidArgument.
  ImuSimulator(const ImuSimulationOptions& options, std::uint64_t seed, Stamp begin, Stamp end);

  // Returns the readings in order, with stamps of the IMU's clock. motion(t), t [s] since `begin`.
  std::vector<ImuSample> Samples(const CameraPath& path, const VibrationIntensity& intensity) const;
  // stamp [ns]: of the camera's clock. Biases are interpolated linearly between readings. The
  // velocity includes vibration, as the integrated readings do; the vibration of the position is
  // below 0.1 mm RMS and is ignored.
  TrueState StateAt(const CameraPath& path, const VibrationIntensity& intensity, Stamp stamp) const;

 private:
  struct Wave {
    Eigen::Vector3d frequency, phase;  // [rad/s], [rad], of each axis
  };

  // Along the axes of B [m/s^2], [m/s].
  struct Shaking {
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();
  };

  Stamp StampOf(std::size_t sample) const;  // [ns] of the camera's clock
  double PathSeconds(Stamp stamp) const { return ToSeconds(stamp - begin_); }
  ImuSample Ideal(const CameraMotion& motion) const;
  Shaking ShakingAt(const CameraPath& path, const VibrationIntensity& intensity, double t) const;

  ImuSimulationOptions options_;
  CounterRandom random_;
  FaultyImu sensor_;
  Stamp begin_, first_;          // [ns] of the camera's clock: first frame, first reading
  std::vector<ImuBias> biases_;  // of every reading
  std::vector<Wave> waves_;
};

}  // namespace highwall::simulate
