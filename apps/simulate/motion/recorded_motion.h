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
  // Of motion capture, an axis, and how long an error of it stays what it is: what
  // highwall_bench_imu finds on three recordings.
  double position_sigma = 1e-3;     // [m] > 0
  double orientation_sigma = 5e-3;  // [rad] > 0
  double error_lasts = 2.0;         // [s] > 0
  double interval = 0.025;          // [s] in [1e-3, 0.5]; of the states that are estimated

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Medians.
struct MotionConsistency {
  double position = 0.0;       // [m] motion minus captured
  double orientation = 0.0;    // [rad] likewise
  double gyroscope = 0.0;      // [rad/s] reading minus bias and motion
  double accelerometer = 0.0;  // [m/s^2] likewise
};

// The motion of an IMU as motion capture and its own readings have it together.
struct RecordedMotion {
  Stamp begin = 0;                  // [ns] of the first state, in the clock of the recording
  double interval = 0.0;            // [s]
  std::vector<ImuState> states;     // z up
  std::vector<ImuBias> biases;      // of each state
  std::vector<ImuSample> readings;  // as recorded
  MotionConsistency consistency;

  // The pose of a camera [T_BC] that rides along, through every state, from state `first` on. The
  // spline closes: for half a second before its last state and after its first it is no motion.
  SplineTrajectory PathOf(const Pose& T_BC, std::size_t first) const;
};

// The most likely motion by Ceres: captured poses, whose errors last, readings between them, a bias
// that walks, and the direction of gravity. captured: T_WB. Both in the order of their stamps.
// Throws InvalidArgument where the two share less than three seconds, readings have gaps there,
// more than half of it was not captured, or they contradict each other.
RecordedMotion FitRecordedMotion(const Trajectory& captured, std::span<const ImuSample> readings,
                                 const RecordedMotionOptions& options = {});

}  // namespace highwall::simulate
