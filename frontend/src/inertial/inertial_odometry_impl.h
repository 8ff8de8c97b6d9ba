#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>

#include <highwall/core/trajectory.h>
#include <highwall/internal/background_job.h>

#include <highwall/frontend/features/twist.h>
#include "inertial/imu_weighting.h"
#include "inertial/inertial_initializer.h"
#include "inertial/inertial_odometry.h"
#include "inertial/inertial_window.h"
#include "inertial/tight_coupling.h"
#include "inertial/visual_rest.h"

namespace highwall {

// The public functions have their docs in inertial_odometry.h.
class InertialOdometry::Impl {
 public:
  Impl(const ImuCalibration& calibration, const InertialOptions& options,
       const std::optional<MeasurementModel>& model);

  ImuSampleStatus AddSample(const ImuSample& sample) { return buffer_.Add(sample); }
  std::optional<Eigen::Vector3d> UpInCamera(Stamp image) const;
  std::optional<KnownPose> Predict(Stamp image) const;
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

 private:
  void Initialize(const Observation& observation, InertialReport& report);
  // Solves the initialization; inconsistent, with a reason, where the images agree better with
  // the readings once the accelerometer's sign is turned.
  InitializationReport SolveWithSign(const VisualPose& visual, InertialReport& report) const;
  void Advance(const Observation& observation, InertialReport& report);
  // Starts the windows; none where the prior cannot be used.
  bool Start(const InertialPrior& prior);
  void StartTight(const InertialPrior& prior);
  InertialWindow MakeLoose(const InertialPrior& prior) const;
  // The image joins the tightly coupled window as well. step: of the other's.
  void Couple(const Observation& observation, const InertialWindow::Step& step);
  // The window of poses goes on from what the other one has come to know. report: is told of it.
  void TakeOver(InertialReport* report);
  // A window of poses from there on, with the images since; empty where that cannot be.
  std::optional<InertialWindow> Follow(const TightCoupling::Result& result) const;
  // What is kept over a pause.
  void ReadWindow();
  // The turn that makes the map's z point up, where gravity has become known much better than when
  // this was asked last, and the map is off by more than that.
  std::optional<Pose> Level();
  // Ends the window, and keeps what holds on: biases, gravity, t_d.
  void Suspend();
  // Starts a window anew with what was kept, once there are readings and poses again.
  void Resume(const Observation& observation, InertialReport& report);
  // What the image says against what the readings since the newest state predict, in the report;
  // whether it contradicts them.
  bool Innovate(const ImuPreintegration& imu, const VisualPose& visual_O, Stamp image,
                InertialReport& report) const;
  // The readings of that interval are not used from now on.
  void Disbelieve(const ImuPreintegration& imu);
  // From the last image that told its pose to this one; none where that is long ago.
  std::optional<Twist> MotionTo(const Observation& observation) const;
  std::optional<ExtrinsicsEstimate> extrinsics() const;
  // By the readings, the velocity within its own sigmas, and the images; where these show nothing,
  // what rested before still does.
  bool Rests(const ImuPreintegration& imu, bool is_dark) const;
  Stamp ImuStamp(Stamp image) const { return image + FromSeconds(time_offset()); }
  VisualPose InO(const VisualPose& visual_W) const;

  ImuCalibration calibration_;
  InertialOptions options_;
  std::optional<MeasurementModel> model_;
  ImuBuffer buffer_;
  InertialInitializer initializer_;
  ImuWeight weight_;
  std::optional<InertialWindow> window_;
  JobSlot<TightCoupling> tight_;
  InertialStatus status_ = InertialStatus::kWaiting;
  std::string reason_;
  int attempts_ = 0;
  std::optional<Stamp> last_attempt_;
  std::optional<StampedPose> last_visual_;  // T_WC of the last image that told it, image stamp
  std::optional<Twist> visual_motion_;      // that led there from the image before
  VisualRest visual_rest_;                  // of the camera in O
  bool rests_ = false;                      // at the latest image
  std::optional<InertialPrior> known_;      // between Suspend() and Resume()
  std::deque<std::pair<Stamp, Stamp>> contradicted_;  // intervals of readings, IMU stamps
  // Kept over a pause.
  ImuBias bias_ = ImuBias::Zero();
  double time_offset_;
  Pose T_BC_;
  Pose T_WO_;
  double levelled_to_ = 0.0;  // [rad] gravity's standard deviation when it was asked last
};

}  // namespace highwall
