#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/zero_velocity.h>
#include <highwall/frontend/input/imu_calibration.h>
#include <highwall/frontend/inertial/imu_weighting.h>
#include <highwall/frontend/inertial/inertial_initializer.h>
#include <highwall/frontend/inertial/inertial_window.h>
#include <highwall/frontend/pose/pose_solver.h>
#include <highwall/frontend/inertial/visual_pose.h>

namespace highwall {

struct InertialOptions {
  ImuWeightingOptions weighting{};
  bool estimate_time_offset = true;
  InertialInitializerOptions initializer{};
  double retry_interval = 0.5;  // [s] > 0; between attempts to initialize
  int max_attempts = 20;        // >= 1; that end in a contradiction, then the IMU is given up
  SlidingWindowOptions window{.max_states = 10};
  ImuBufferOptions buffer{};
  VisualNoise visual_noise{};
  // Of the walks of the biases, >= 1: what the map gets wrong along the way looks like biases that
  // move faster than those of the sensor do.
  double walk_inflation = 4.0;
  // Of the prediction's covariance before it guides the search for landmarks, >= 1.
  double prediction_inflation = 4.0;
  double max_dead_reckoning = 5.0;  // [s] > 0; without any image, then the frame is lost
  // After readings were missing: of the velocity that the displacement of two images shows.
  double restart_velocity_sigma = 0.5;  // [m/s] > 0
  StationaryOptions stationary{};
  double stationary_speed = 0.03;  // [m/s] > 0; the estimate must be slower as well

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

enum class InertialStatus {
  kWaiting,        // no readings around the images yet
  kInitializing,   // gravity, biases and velocity are not known yet
  kRunning,        // images and IMU
  kDeadReckoning,  // the IMU alone
  kGivenUp,        // images and IMU contradict each other: the images alone from now on
};
// "waiting", "initializing", "running", "dead reckoning", "given up".
const char* ToString(InertialStatus status);

// What became of one image.
struct InertialReport {
  InertialStatus status = InertialStatus::kWaiting;
  std::string reason;               // in kInitializing and kGivenUp: what is amiss, one line
  double weight = 0.0;              // of the interval's IMU factor
  double squared_innovation = 0.0;  // of the image's pose against the prediction
  int innovation_dof = 0;           // 0 where it was not formed
  bool stationary = false;
  bool restarted = false;  // readings were missing before this image
  // The rotation that makes z point up, to be applied to the whole map; in the report of the image
  // that ends the initialization only.
  std::optional<Pose> T_level;
  // After the image, once initialized; in W.
  std::optional<InertialEstimate> estimate;
  double gravity_sigma = 0.0;                         // [rad]
  double time_offset = 0.0, time_offset_sigma = 0.0;  // [s] t_d
};

// Fuses the poses that images give with an IMU: initialization, a sliding window of states, the
// weight of the IMU, the time offset, dead reckoning where images show nothing.
//
//   for each image:
//     AddSample() every reading until some 50 ms after it
//     Predict()   where the camera should be
//     Update()    with what the image says, if anything
//     T_WC()      the pose by both
//
// States live in a frame O with its z axis up that stands still; the map's frame W moves with
// respect to it when the map is corrected (MoveMap), by a turn about the vertical and a shift.
class InertialOdometry {
 public:
  // Throws InvalidArgument on bad options.
  explicit InertialOdometry(const ImuCalibration& calibration, const InertialOptions& options = {});

  ImuSampleStatus AddSample(const ImuSample& sample) { return buffer_.Add(sample); }

  // The unit vector in C that points up, by the mean reading of the accelerometer over the second
  // before an image: good for a camera at rest or in calm motion. Empty without readings.
  std::optional<Eigen::Vector3d> UpInCamera(Stamp image) const;

  // The pose of the camera that the IMU predicts; empty before the initialization, without
  // readings, and after dead reckoning for too long.
  std::optional<KnownPose> Predict(Stamp image) const;

  // What an image told, besides its stamp [ns, camera's clock].
  struct Observation {
    Stamp image = 0;
    std::optional<VisualPose> visual;  // in W
    double sharpness = 1.0;            // MotionMeasures
    double tracked_share = 1.0;
  };
  InertialReport Update(const Observation& observation);

  // The map was moved, T_new_old in W, where the camera is now.
  void MoveMap(const Pose& T_new_old);

  // The latest image's state in W; empty unless running or dead reckoning.
  std::optional<InertialEstimate> estimate() const;
  std::optional<Pose> T_WC() const;
  // [m/s^2] in W, as estimated; empty before the initialization.
  std::optional<Eigen::Vector3d> gravity_W() const;
  double gravity_sigma() const;  // [rad]
  double time_offset() const;    // [s] t_d
  double time_offset_sigma() const;
  InertialStatus status() const { return status_; }
  double weight() const { return weight_.weight(); }  // of the latest IMU factor
  const ImuCalibration& calibration() const { return calibration_; }

  // The readings between two instants of the IMU's clock, preintegrated with the present bias;
  // empty where some are missing.
  std::optional<ImuPreintegration> Between(Stamp from, Stamp to) const;

 private:
  void Initialize(const Observation& observation, InertialReport& report);
  // Solves the initialization; inconsistent, with a reason, where the images agree better with
  // the readings once the accelerometer's sign is turned.
  InitializationReport SolveWithSign(const VisualPose& visual, InertialReport& report) const;
  void Advance(const Observation& observation, InertialReport& report);
  // Starts a window; none where the prior cannot be used.
  bool Start(const InertialPrior& prior);
  // Ends the window, and keeps what holds on: biases, gravity, t_d.
  void Suspend();
  // Starts a window anew with what was kept, once there are readings and poses again.
  void Resume(const Observation& observation, InertialReport& report);
  // The innovation of an image's pose, where all its directions are known.
  void Innovate(const InertialEstimate& predicted, const VisualPose& visual_O,
                InertialReport& report) const;
  bool Rests(const ImuPreintegration& imu) const;
  Stamp ImuStamp(Stamp image) const { return image + FromSeconds(time_offset()); }
  VisualPose InO(const VisualPose& visual_W) const;

  ImuCalibration calibration_;
  InertialOptions options_;
  ImuBuffer buffer_;
  InertialInitializer initializer_;
  ImuWeight weight_;
  std::optional<InertialWindow> window_;
  InertialStatus status_ = InertialStatus::kWaiting;
  std::string reason_;
  int attempts_ = 0;
  std::optional<Stamp> last_attempt_;
  std::optional<StampedPose> last_visual_;  // T_WC of the last image that told it, image stamp
  std::optional<InertialPrior> known_;      // between Suspend() and Resume()
  // Kept over a pause.
  ImuBias bias_ = ImuBias::Zero();
  double time_offset_;
  Pose T_WO_;
};

}  // namespace highwall
