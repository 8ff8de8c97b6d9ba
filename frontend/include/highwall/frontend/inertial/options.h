#pragma once

#include <highwall/factors/imu_buffer.h>

namespace [[gnu::visibility("default")]] highwall {

// Weighting of the inertial residuals against the visual ones (docs/equations.md, section 4); the
// named classes are in factors, with their options.
enum class ImuWeighting {
  kPaper,       // by the motion: PaperImuWeight
  kConsistent,  // 1, less where the innovations are too large: ConsistentImuWeight
  kFixed,       // a constant
};

// Returns "paper", "consistent" or "fixed".
const char* ToString(ImuWeighting policy);

// Coupling of an image to the sliding window of states (docs/inertial_odometry.md).
enum class InertialCoupling {
  kTight,  // its point and line observations, in one optimization with the readings
  kLoose,  // one Gaussian: the pose estimated from the image alone
};

// Returns "tight" or "loose".
const char* ToString(InertialCoupling coupling);

// Options of the IMU weighting.
struct ImuWeightingOptions {
  ImuWeighting policy = ImuWeighting::kConsistent;
  double fixed_weight = 1.0;  // > 0; of kFixed

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the initialization of gravity, biases and velocity.
struct InertialInitializerOptions {
  double gyroscope_bias_sigma = 0.02;     // [rad/s] > 0; prior of the biases
  double accelerometer_bias_sigma = 0.1;  // [m/s^2] > 0
  double time_offset_sigma = 0.02;        // [s] > 0; of the initial guess of the calibration

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Noise model of the pose estimated from an image.
struct VisualNoise {
  // Standard deviations of the error common to all landmarks of an image, mainly that of the map:
  // no number of landmarks makes a pose more certain than this.
  double position = 3e-4;  // [m] > 0
  double rotation = 5e-5;  // [rad] > 0
  // > 0; factor on the part of the covariance due to the individual landmarks, whether each is a
  // row of the smoother or they are summarized as a pose: their errors are not independent.
  double scale = 4.0;
  double min_error = 0.02;  // > 0; lower bound of |r|^2 per degree of freedom

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the tightly coupled smoother (InertialCoupling::kTight).
struct TightWindowOptions {
  // [s] > 0; between states. Images in between are loosely coupled poses until the next state.
  double interval = 0.06;
  int max_points = 500;  // >= 0; per image
  int max_lines = 100;   // >= 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the fusion of images and IMU.
struct InertialOptions {
  // Tightly coupled, with the loosely coupled smoother between its states, or loosely coupled
  // alone.
  InertialCoupling coupling = InertialCoupling::kTight;
  ImuWeightingOptions weighting{};
  bool estimate_time_offset = true;
  // T_BC is estimated, with that of the calibration as prior; otherwise it is fixed.
  bool estimate_extrinsics = false;
  // Standard deviations of the calibration's T_BC in that case: those of a ruler and a mount.
  double extrinsics_position_sigma = 0.01;  // [m] > 0
  double extrinsics_rotation_sigma = 0.01;  // [rad] > 0
  InertialInitializerOptions initializer{};
  int max_attempts = 20;  // >= 1; attempts that end inconsistent before the IMU is given up
  ImuBufferOptions buffer{};
  int window_states = 10;  // >= 2; estimated together, in either smoother
  TightWindowOptions tight{};
  VisualNoise visual_noise{};
  double max_dead_reckoning = 5.0;  // [s] > 0; without any image, then the frame is lost

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
