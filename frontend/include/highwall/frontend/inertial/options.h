#pragma once

#include <highwall/core/sliding_window_smoother.h>
#include <highwall/factors/imu_buffer.h>

namespace [[gnu::visibility("default")]] highwall {

// How the inertial residuals are weighed against the visual ones (docs/equations.md, section 4);
// the classes are of factors, their options as they are there.
enum class ImuWeighting {
  kPaper,       // by the motion: PaperImuWeight
  kConsistent,  // 1, less where the innovations are too large: ConsistentImuWeight
  kFixed,       // a constant
};

// "paper", "consistent", "fixed".
const char* ToString(ImuWeighting policy);

// What an image is to the window of states (docs/inertial_odometry.md).
enum class InertialCoupling {
  kTight,  // the points and lines that it sees, in one optimization with the readings
  kLoose,  // one Gaussian, of the pose that it was given by itself
};

// "tight", "loose".
const char* ToString(InertialCoupling coupling);

// Which weight the IMU has.
struct ImuWeightingOptions {
  ImuWeighting policy = ImuWeighting::kConsistent;
  double fixed_weight = 1.0;  // > 0; of kFixed

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// When gravity, biases and velocity count as known.
struct InertialInitializerOptions {
  double interval = 0.1;                  // [s] > 0; between the images that are used
  double min_duration = 1.0;              // [s] > 0; from the first of them to the last
  double max_duration = 8.0;              // [s] > min_duration; older ones are forgotten
  double gyroscope_bias_sigma = 0.02;     // [rad/s] > 0; what is known of the biases before
  double accelerometer_bias_sigma = 0.1;  // [m/s^2] > 0
  double time_offset_sigma = 0.02;        // [s] > 0; of the calibration's guess
  // [rad] > 0; more certain of gravity's direction it is good enough to start. At rest the bias
  // of the accelerometer and a tilt look the same: 0.1 m/s^2 are 0.01 rad.
  double max_gravity_sigma = 0.015;
  double max_error = 20.0;          // > 0; chi-squared per degree of freedom
  double max_gravity_error = 0.06;  // (0, 1); of the magnitude of gravity

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How well an image tells the pose of its camera.
struct VisualNoise {
  // Standard deviations of what all landmarks of an image have in common, the error of the map
  // foremost: no number of landmarks makes a pose more certain than this.
  double position = 3e-4;  // [m] > 0
  double rotation = 5e-5;  // [rad] > 0
  // > 0; by which the landmarks' own part of the covariance counts more than they show, whether
  // each is a row of the window or they are summed up as a pose: their errors are not independent.
  double scale = 4.0;
  double min_error = 0.02;  // > 0; the least |r|^2 per degree of freedom that is believed

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The window of landmarks (InertialCoupling::kTight).
struct TightWindowOptions {
  // [s] > 0; between states. Images in between are poses, as where loosely coupled, until the next.
  double interval = 0.06;
  int max_points = 500;  // >= 0; of one image
  int max_lines = 100;   // >= 0
  // Which state leaves where there are more than InertialOptions::window_states.
  LeavingPolicy leaving = LeavingPolicy::kOldestFirst;
  // Standard deviations of how the map's error changes at the body, which no number of landmarks
  // tells: of its place and its direction, as a random walk.
  double map_drift = 6e-4;  // [m/sqrt(s)] > 0
  double map_turn = 2e-4;   // [rad/sqrt(s)] > 0
  // On a thread of its own; else images wait for it, and a run is the same every time.
  bool background = true;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How images and IMU are fused.
struct InertialOptions {
  // Of landmarks, with that of poses between its states, or that of poses alone.
  InertialCoupling coupling = InertialCoupling::kTight;
  ImuWeightingOptions weighting{};
  bool estimate_time_offset = true;
  // T_BC is an unknown, about that of the calibration; else that stands.
  bool estimate_extrinsics = false;
  // Standard deviations of the calibration's T_BC then: a ruler's and a mount's.
  double extrinsics_position_sigma = 0.01;  // [m] > 0
  double extrinsics_rotation_sigma = 0.01;  // [rad] > 0
  InertialInitializerOptions initializer{};
  int max_attempts = 20;  // >= 1; that end in a contradiction, then the IMU is given up
  ImuBufferOptions buffer{};
  int window_states = 10;  // >= 2; that are estimated together, of either window
  TightWindowOptions tight{};
  VisualNoise visual_noise{};
  double max_dead_reckoning = 5.0;  // [s] > 0; without any image, then the frame is lost

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
