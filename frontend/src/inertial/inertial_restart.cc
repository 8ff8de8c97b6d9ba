// Parts of InertialOdometry that follow changes of its surroundings: the map moves, another world
// begins, images contradict the IMU.
#include <utility>

#include "inertial/inertial_odometry_impl.h"
#include "map/yaw_and_shift.h"

namespace highwall {
namespace {

constexpr const char* kContradiction =
    "images and IMU contradict each other: check T_BC, the signs of the axes, units and clocks";

}  // namespace

void InertialOdometry::Impl::Judge(const Observation& observation, InertialReport& report) {
  if (observation.visual) monitor_.Add(observation.image, observation.visual->T_WC);
  const bool is_used = window_ || known_;
  const bool is_confirmed = is_used && agreement_ == ImuAgreement::kConsistent;
  auto judgement = monitor_.Check(observation.image, buffer_, calibration_, is_confirmed);
  if (!judgement) return;
  if (!IsBelieved(*judgement, is_used, observation.image)) return;
  const bool contradicted = judgement->agreement == ImuAgreement::kContradicted;
  // Once contradicted, too little motion is no reason to use it again, nor are poor images.
  const bool decided = contradicted || judgement->agreement == ImuAgreement::kConsistent ||
                       agreement_ != ImuAgreement::kContradicted;
  if (decided) agreement_ = judgement->agreement;
  if (agreement_ == ImuAgreement::kUnconfirmed) reason_ = kContradiction;
  if (!contradicted) return;
  reason_ = judgement->finding ? judgement->finding->text : kContradiction;
  report.finding = std::move(judgement->finding);
  if (is_used) GiveUp(report);
}

bool InertialOdometry::Impl::IsBelieved(const ImuJudgement& judgement, bool is_used, Stamp image) {
  constexpr double kLongUse = 20.0;  // [s]
  if (!is_used) used_since_.reset();
  if (is_used && !used_since_) used_since_ = image;
  if (judgement.agreement < ImuAgreement::kUnconfirmed) contradicted_since_.reset();
  if (!contradicted_since_) {
    if (judgement.agreement < ImuAgreement::kUnconfirmed) return true;
    contradicted_since_ = image;
  }
  const bool is_long = is_used && ToSeconds(image - *used_since_) > kLongUse;
  return !is_long || ToSeconds(image - *contradicted_since_) > ImuMonitor::kMonitored;
}

void InertialOdometry::Impl::CheckClock(Stamp image, InertialReport& report) {
  if (report.finding) return;
  if (!window_) return clock_.Interrupt();
  const double off = report.time_offset - calibration_.time_offset;
  if (!clock_.Update(image, off, report.time_offset_sigma)) return;
  report.finding = ClockFinding(report.time_offset, calibration_.time_offset);
}

void InertialOdometry::Impl::GiveUp(InertialReport& report) {
  window_.reset();
  tight_.Cancel();
  known_.reset();
  initializer_.Clear();
  visual_rest_.Clear();
  is_stationary_ = false;
  T_WO_ = Pose();
  bias_ = ImuBias::Zero();
  time_offset_ = calibration_.time_offset;
  T_BC_ = calibration_.T_BC;
  attempts_ = options_.max_attempts;
  report.abandoned = true;
}

void InertialOdometry::Impl::MoveMap(const Pose& T_new_old) {
  const Eigen::Vector3d p_W =
      window_ ? T_WO_ * window_->newest().state.T_WB.p() : Eigen::Vector3d(Eigen::Vector3d::Zero());
  T_WO_ = YawAndShift(T_new_old, p_W) * T_WO_;
  initializer_.MoveMap(T_new_old);
  monitor_.MoveMap(T_new_old);
  if (last_visual_) last_visual_->pose = T_new_old * last_visual_->pose;
}

void InertialOdometry::Impl::Restart() {
  window_.reset();
  tight_.Cancel();
  known_.reset();
  last_visual_.reset();
  visual_motion_.reset();
  initializer_.Clear();
  monitor_.Clear();
  contradicted_since_.reset();
  visual_rest_.Clear();
  is_stationary_ = false;
  T_WO_ = Pose();
  if (status_ == InertialStatus::kGivenUp) return;  // retried as rarely as before
  last_attempt_.reset();
  attempts_ = 0;
  status_ = InertialStatus::kWaiting;
}

}  // namespace highwall
