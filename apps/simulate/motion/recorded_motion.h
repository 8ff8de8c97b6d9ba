#pragma once

#include <span>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>

#include "simulate/motion/spline_trajectory.h"

namespace highwall::simulate {

struct RecordedMotionOptions {
  ImuNoise noise = {};  // of the IMU; default: EuRoC's
  // Errors of motion capture per axis, and their correlation time, as highwall_bench_imu estimates
  // them from three recordings.
  double position_sigma = 1e-3;     // [m] > 0
  double orientation_sigma = 5e-3;  // [rad] > 0
  double error_lasts = 2.0;         // [s] > 0
  double interval = 0.025;          // [s] in [1e-3, 0.5]; between estimated states

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Median differences.
struct MotionConsistency {
  double position = 0.0;       // [m] motion minus captured
  double orientation = 0.0;    // [rad] likewise
  double gyroscope = 0.0;      // [rad/s] reading minus bias and motion
  double accelerometer = 0.0;  // [m/s^2] likewise
};

// Motion of an IMU estimated from motion capture and its own readings.
struct RecordedMotion {
  Stamp begin = 0;                  // [ns] of the first state, in the clock of the recording
  double interval = 0.0;            // [s]
  std::vector<ImuState> states;     // z up
  std::vector<ImuBias> biases;      // of each state
  std::vector<ImuSample> readings;  // as recorded
  MotionConsistency consistency;

  // Returns the path of a camera [T_BC] fixed to the IMU, through every state from state `first`
  // on. The spline is closed: within half a second before its last state and after its first it
  // does not represent the motion.
  SplineTrajectory PathOf(const Pose& T_BC, std::size_t first) const;
};

// Estimates the most likely motion with Ceres from captured poses with correlated errors, IMU
// readings, a bias random walk, and the direction of gravity. captured: T_WB. Both in the order of
// their stamps. Throws InvalidArgument if the two overlap by less than three seconds, if readings
// have gaps there, if more than half of it was not captured, or if they are inconsistent.
RecordedMotion FitRecordedMotion(const Trajectory& captured, std::span<const ImuSample> readings,
                                 const RecordedMotionOptions& options = {});

}  // namespace highwall::simulate
