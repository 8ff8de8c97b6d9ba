#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/features/twist.h>
#include <highwall/frontend/inertial/inertial_odometry.h>
#include <highwall/internal/background_job.h>

#include "inertial/clock_check.h"
#include "inertial/imu_monitor.h"
#include "inertial/imu_weighting.h"
#include "inertial/inertial_initializer.h"
#include "inertial/inertial_window.h"
#include "inertial/start_check.h"
#include "inertial/tight_coupling.h"
#include "inertial/visual_rest.h"

namespace highwall {

// The public functions are documented in inertial_odometry.h.
class InertialOdometry::Impl {
 public:
  Impl(const ImuCalibration& calibration, const InertialOptions& options,
       const std::optional<MeasurementModel>& model, bool background, RunProfile* profile);

  ImuSampleStatus AddSample(const ImuSample& sample) { return buffer_.Add(sample); }
  std::optional<Eigen::Vector3d> UpInCamera(Stamp image) const;
  std::optional<PoseConstraint> Predict(Stamp image) const;
  InertialReport Update(const Observation& observation);
  void MoveMap(const Pose& T_new_old);
  void Restart();
  std::optional<InertialEstimate> estimate() const;
  std::optional<Pose> T_WC() const;
  std::optional<Eigen::Vector3d> gravity_W() const;
  double gravity_sigma() const;
  double time_offset() const;
  double time_offset_sigma() const;
  InertialStatus status() const { return status_; }
  double weight() const { return weight_.weight(); }
  const ImuCalibration& calibration() const { return calibration_; }
  const Pose& T_BC() const { return T_BC_; }
  std::optional<ImuPreintegration> Between(Stamp from, Stamp to) const;
  std::optional<ImuPreintegration> AllBetween(Stamp from, Stamp to) const;
  bool IsContradicted(Stamp from, Stamp to) const;

 private:
  // Tests the configuration against the images; on a contradiction the IMU is given up.
  void Judge(const Observation& observation, InertialReport& report);
  // Whether a judgement counts. That of an IMU which was used for long does once it has been
  // contradicted for as long as poses are monitored, because errors of poses last for seconds.
  bool IsBelieved(const ImuJudgement& judgement, bool is_used, Stamp image);
  void GiveUp(InertialReport& report);
  // Reports an offset of the clocks that is estimated, so that the IMU is used, but contradicts the
  // stated one.
  void CheckClock(Stamp image, InertialReport& report);
  void Initialize(const Observation& observation, InertialReport& report);
  // Starts the smoothers from a solution that is ready.
  void StartFrom(const InitializationReport& solution, InertialReport& report);
  // Solves the initialization; inconsistent, with a reason, if the images fit the readings better
  // with the accelerometer's sign reversed.
  InitializationReport SolveWithSign(const VisualPose& visual, InertialReport& report) const;
  void Advance(const Observation& observation, InertialReport& report);
  // Starts both smoothers; returns false if the prior cannot be used.
  bool Start(const InertialPrior& prior);
  void StartTight(const InertialPrior& prior);
  std::optional<InertialWindow> MakeLoose(const InertialPrior& prior) const;
  // Adds the image to the tightly coupled smoother as well. step: that of the loosely coupled one.
  void Couple(const Observation& observation, const InertialWindow::Step& step);
  // Restarts the loosely coupled smoother from the result of the tightly coupled one, if there is
  // one. report: output.
  void TakeOver(InertialReport* report);
  // Returns a loosely coupled smoother started there, with the images since; empty on failure.
  std::optional<InertialWindow> Follow(const TightCoupling::Result& result) const;
  // Copies the estimates that are kept over a pause.
  void ReadWindow();
  // Returns the gravity alignment that makes the map's z axis point up, if gravity has become much
  // more accurate since the last check and the map's tilt exceeds the uncertainty.
  std::optional<Pose> Level();
  // Ends the smoothers and keeps the estimates that remain valid: biases, gravity, t_d.
  void Suspend();
  // Restarts the smoothers with the kept estimates as soon as there are readings and poses again.
  void Resume(const Observation& observation, InertialReport& report);
  // Computes the innovation of the image's pose against the prediction from the readings since the
  // newest state, for the report; returns whether the readings are contradicted.
  bool Innovate(const ImuPreintegration& imu, const VisualPose& visual_O, Stamp image,
                InertialReport& report) const;
  // Rejects the readings of that interval from now on.
  void RejectInterval(const ImuPreintegration& imu);
  // Returns the motion from the last image with a pose to this one; empty if that is long ago.
  std::optional<Twist> MotionTo(const Observation& observation) const;
  std::optional<ExtrinsicsEstimate> extrinsics() const;
  // Returns whether the body is stationary by the readings, the velocity within its own sigmas, and
  // the images; if these give no pose, a stationary body remains stationary.
  bool IsAtRest(const ImuPreintegration& imu, bool is_dark) const;
  Stamp ImuStamp(Stamp image) const { return image + FromSeconds(time_offset()); }
  VisualPose InO(const VisualPose& visual_W) const;

  ImuCalibration calibration_;
  InertialOptions options_;
  std::optional<MeasurementModel> model_;
  bool background_;  // the tightly coupled smoother is on a thread of its own
  RunProfile* profile_;
  ImuBuffer buffer_;
  InertialInitializer initializer_;
  ImuMonitor monitor_;
  ImuWeight weight_;
  std::optional<InertialWindow> window_;
  JobSlot<TightCoupling> tight_;
  InertialStatus status_ = InertialStatus::kWaiting;
  std::string reason_;
  ImuAgreement agreement_ = ImuAgreement::kUndecided;     // the last that was decided
  std::optional<Stamp> used_since_, contradicted_since_;  // at judgements, without a break
  ClockCheck clock_;
  StartCheck start_;
  int attempts_ = 0;
  std::optional<Stamp> last_attempt_;
  std::optional<StampedPose> last_visual_;  // T_WC of the last image with a pose, image stamp
  std::optional<Twist> visual_motion_;      // motion to it from the image before
  VisualRest visual_rest_;                  // of the camera in O
  bool is_stationary_ = false;              // at the latest image
  std::optional<InertialPrior> known_;      // between Suspend() and Resume()
  std::deque<std::pair<Stamp, Stamp>> contradicted_;  // intervals of readings, IMU stamps
  // Kept over a pause.
  ImuBias bias_ = ImuBias::Zero();
  double time_offset_;
  Pose T_BC_;
  Pose T_WO_;
  double levelled_to_ = 0.0;  // [rad] gravity's sigma at the last check for alignment
};

}  // namespace highwall
