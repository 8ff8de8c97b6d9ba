#include "inertial/inertial_odometry_impl.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/core/sqrt_information.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/zero_velocity.h>
#include <highwall/frontend/input/imu_check.h>
#include <highwall/internal/number_text.h>

#include "inertial/imu_saturation.h"
#include "inertial/imu_vibration.h"
#include "inertial/innovation.h"

namespace highwall {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Inflation of the random walks of the biases: errors of the map along the way look like biases
// that change faster than those of the sensor.
constexpr double kWalkInflation = 4.0;
// Inflation of the prediction's covariance before it guides the search for landmarks.
constexpr double kPredictionInflation = 4.0;
constexpr double kRetryInterval = 0.5;  // [s] between attempts to initialize
// [s] The same once the IMU is given up: the images may have been at fault while tracking was poor,
// and an IMU that becomes consistent later is used.
constexpr double kLateRetryInterval = 5.0;
// [m/s] Sigma of the velocity from the displacement of two images, after readings were missing.
constexpr double kRestartVelocitySigma = 0.5;
// Gravity may be aligned again each time that its sigma shrinks by this factor, if the tilt exceeds
// so many standard deviations and is large enough to justify moving the map.
constexpr double kBetterGravity = 1.0 / 3.0;
constexpr double kSureTilt = 3.0;
constexpr double kWorthwhileTilt = 2e-3;  // [rad] 2 mm a metre
constexpr StationaryOptions kStationary;
// [m/s], and squared in its own sigmas (99.9 %): a stationary body must also be estimated slower.
constexpr double kStationarySpeed = 0.03, kRestChi2 = 16.27;

constexpr double kNeighbours = 0.2;  // [s] maximum distance of two images that give a velocity

constexpr const char* kNoStart = "the motion so far does not determine an initial state";

// Returns the shortest rotation that takes `up` to z.
Eigen::Quaterniond Upright(const Eigen::Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
}

// Limits the certainty of gravity and t_d to the accuracy of the models.
void InflateCovariance(InertialPrior& prior) {
  constexpr double kGravity = 1e-3, kTimeOffset = 1e-4;  // [rad], [s]
  const Eigen::Vector3d least(kGravity, kGravity, kTimeOffset);
  auto variances = prior.calibration_covariance.diagonal().head<3>();
  variances = variances.cwiseMax(least.cwiseAbs2()).eval();
}

ImuCalibration WithFasterWalks(ImuCalibration calibration) {
  calibration.noise.gyroscope_walk *= kWalkInflation;
  calibration.noise.accelerometer_walk *= kWalkInflation;
  return calibration;
}

std::optional<Vector6> ExtrinsicsSigma(const InertialOptions& options) {
  if (!options.estimate_extrinsics) return std::nullopt;
  Vector6 sigma;
  sigma << Eigen::Vector3d::Constant(options.extrinsics_position_sigma),
      Eigen::Vector3d::Constant(options.extrinsics_rotation_sigma);
  return sigma;
}

std::string Decimals(double value) {
  return FixedText(value, 2);
}

bool IsNearGravity(double norm) {
  return std::abs(norm / kStandardGravity - 1.0) <= kMaxGravityError;
}

std::string Explain(const InitializationReport& report) {
  switch (report.status) {
    case InitializationStatus::kTooShort:
      return "more images are needed";
    case InitializationStatus::kNoImu:
      return "readings are missing between the images";
    case InitializationStatus::kUncertain:
      return "gravity is known to " + Decimals(report.gravity_sigma * 180.0 / M_PI) + " deg only";
    case InitializationStatus::kWrongGravity:
      return "images and readings together make gravity " + Decimals(report.gravity_norm) +
             " m/s^2 where it is " + Decimals(kStandardGravity) +
             (IsNearGravity(report.reading_norm)
                  ? ", and the readings alone " + Decimals(report.reading_norm) +
                        ": the images' poses are poor here; tried again"
                  : ": check the accelerometer's unit and scale");
    case InitializationStatus::kInconsistent:
      return "images and IMU contradict each other (chi-squared " + Decimals(report.error) +
             " per degree of freedom): check T_BC, the signs of the axes, units and clocks";
    case InitializationStatus::kReady:
      return "";
  }
  return "";
}

}  // namespace

InertialOdometry::Impl::Impl(const ImuCalibration& calibration, const InertialOptions& options,
                             const std::optional<MeasurementModel>& model, bool background,
                             RunProfile* profile)
    : calibration_(WithFasterWalks((calibration.Validate(), calibration))),
      options_((options.Validate(), options)),
      model_(model),
      background_(background),
      profile_(profile),
      buffer_(options.buffer),
      initializer_(calibration_, options.initializer, options.estimate_time_offset,
                   ExtrinsicsSigma(options)),
      monitor_(options.buffer.max_step),
      weight_(options.weighting),
      time_offset_(calibration.time_offset),
      T_BC_(calibration.T_BC) {}

std::optional<Eigen::Vector3d> InertialOdometry::Impl::UpInCamera(Stamp image) const {
  constexpr Stamp kSecond = 1'000'000'000;
  const Stamp end = ImuStamp(image);
  if (buffer_.empty() || buffer_.newest() < end || buffer_.oldest() >= end) return std::nullopt;
  const auto interval = buffer_.Between(std::max(end - kSecond, buffer_.oldest()), end);
  if (!interval) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : interval->samples) mean += sample.accelerometer;
  mean /= static_cast<double>(interval->samples.size());
  if (!(std::abs(mean.norm() / kStandardGravity - 1.0) < kMaxGravityError)) {
    return std::nullopt;
  }
  return (T_BC_.q().conjugate() * mean).normalized();
}

bool InertialOdometry::Impl::IsContradicted(Stamp from, Stamp to) const {
  return std::ranges::any_of(contradicted_, [&](const auto& interval) {
    return from < interval.second && interval.first < to;
  });
}

std::optional<ImuPreintegration> InertialOdometry::Impl::Between(Stamp from, Stamp to) const {
  return IsContradicted(from, to) ? std::nullopt : AllBetween(from, to);
}

std::optional<ImuPreintegration> InertialOdometry::Impl::AllBetween(Stamp from, Stamp to) const {
  if (from >= to || buffer_.empty()) return std::nullopt;
  const auto interval = buffer_.Between(from, to);
  if (!interval || interval->HasGap()) return std::nullopt;
  const ImuNoise shaken = ShakenNoise(calibration_.noise, interval->samples);
  return ImuPreintegration(interval->samples, bias_,
                           {.noise = SaturatedNoise(shaken, interval->samples, calibration_)});
}

std::optional<PoseConstraint> InertialOdometry::Impl::Predict(Stamp image) const {
  if (!window_) return std::nullopt;
  const auto imu = Between(window_->newest().stamp, ImuStamp(image));
  if (!imu) return std::nullopt;
  const InertialPrior newest = window_->Prior();
  const CameraPoseEstimate camera = PredictCamera(newest, T_BC_, *imu, weight_.weight());
  const InertialEstimate& from = newest.estimate;
  const Eigen::Vector3d gravity = kStandardGravity * newest.gravity_W.vector();
  const ImuState body = imu->Predict(from.state, from.bias, gravity);
  const Eigen::Vector3d omega_B = imu->samples().back().gyroscope - from.bias.head<3>();
  Matrix6 J = Matrix6::Identity();  // the tangent of a pose is body-fixed in rotation
  J.topLeftCorner<3, 3>() = T_WO_.R();
  Vector6 common;
  common << Eigen::Vector3d::Constant(options_.visual_noise.position),
      Eigen::Vector3d::Constant(options_.visual_noise.rotation);
  const Matrix6 covariance =
      kPredictionInflation *
      (J * camera.covariance * J.transpose() + Matrix6(common.cwiseProduct(common).asDiagonal()));
  return PoseConstraint{T_WO_ * camera.T_WC, SqrtInformation(covariance),
                        CameraMotion(body, omega_B, T_BC_)};
}

InertialReport InertialOdometry::Impl::Update(const Observation& observation) {
  InertialReport report;
  const std::optional<Twist> motion = MotionTo(observation);
  Judge(observation, report);
  if (window_) {
    Advance(observation, report);
  } else if (known_) {
    Resume(observation, report);
  } else {
    Initialize(observation, report);
  }
  if (observation.visual) {
    // In W after a gravity alignment.
    const Pose T_gravity = report.T_gravity.value_or(Pose());
    last_visual_ = {observation.image, T_gravity * observation.visual->T_WC};
    if (report.T_gravity) monitor_.MoveMap(T_gravity);
    visual_motion_ = motion;
  }
  report.status = status_;
  report.estimate = estimate();
  report.gravity_sigma = gravity_sigma();
  report.time_offset = time_offset();
  report.time_offset_sigma = time_offset_sigma();
  report.extrinsics = extrinsics();
  CheckClock(observation.image, report);
  return report;
}

void InertialOdometry::Impl::Initialize(const Observation& observation, InertialReport& report) {
  if (buffer_.empty() || buffer_.newest() < ImuStamp(observation.image)) {
    status_ = InertialStatus::kWaiting;
    report.reason = "no readings";
    return;
  }
  const bool given_up = attempts_ >= options_.max_attempts;
  status_ = given_up ? InertialStatus::kGivenUp : InertialStatus::kInitializing;
  if (!observation.visual) {
    initializer_.Clear();
    report.reason = given_up ? reason_ : "the image gives no pose";
    return;
  }
  // The solution is the state at the newest image added, which must be this one.
  const bool is_newest = initializer_.Add(observation.image, *observation.visual);
  const double interval = given_up ? kLateRetryInterval : kRetryInterval;
  const bool is_early =
      last_attempt_ && ToSeconds(observation.image - *last_attempt_) < interval - 5e-4;
  if (!is_newest || is_early || observation.keeps_level) {
    report.reason = reason_;
    return;
  }
  if (agreement_ == ImuAgreement::kContradicted || agreement_ == ImuAgreement::kUnconfirmed) {
    last_attempt_ = observation.image;
    if (agreement_ == ImuAgreement::kContradicted) {
      attempts_ = options_.max_attempts;
      status_ = InertialStatus::kGivenUp;
    }
    report.reason = reason_;
    return;
  }
  const InitializationReport solution = SolveWithSign(*observation.visual, report);
  if (solution.status == InitializationStatus::kTooShort) {
    if (given_up) report.reason = reason_;
    return;
  }
  last_attempt_ = observation.image;
  if (report.reason.empty()) report.reason = Explain(solution);
  reason_ = report.reason;
  // Readings that are consistent by themselves are no reason to give up the IMU.
  const bool wrong_readings = solution.status == InitializationStatus::kWrongGravity &&
                              !IsNearGravity(solution.reading_norm);
  const bool contradiction =
      solution.status == InitializationStatus::kInconsistent || wrong_readings;
  if (auto finding = start_.Update(solution, wrong_readings, agreement_)) {
    report.finding = std::move(finding);
  }
  if (solution.status != InitializationStatus::kReady) {
    if (contradiction && ++attempts_ >= options_.max_attempts) status_ = InertialStatus::kGivenUp;
    attempts_ = std::min(attempts_, options_.max_attempts);
    return;
  }
  StartFrom(solution, report);
}

void InertialOdometry::Impl::StartFrom(const InitializationReport& solution,
                                       InertialReport& report) {
  const Eigen::Quaterniond q_gravity = Upright(-solution.estimate->gravity_W.vector());
  InertialPrior prior = solution.estimate->Turned(q_gravity);
  prior.gravity_W = UnitDirection(Eigen::Vector3d(0, 0, -1));
  // The covariance is inflated by the error of the solution.
  prior.SetJoint(std::max(1.0, solution.error) * prior.Joint());
  InflateCovariance(prior);
  if (!Start(prior)) {
    report.reason = reason_ = kNoStart;
    return;
  }
  report.T_gravity = Pose(q_gravity, Eigen::Vector3d::Zero());
  bias_ = prior.estimate.bias;
  T_WO_ = Pose();
  levelled_to_ = window_->Prior().gravity_sigma();
  time_offset_ = window_->time_offset();
  T_BC_ = window_->T_BC();
  reason_.clear();
}

std::optional<InertialWindow> InertialOdometry::Impl::MakeLoose(const InertialPrior& prior) const {
  return InertialWindow::Make(calibration_, {.max_states = options_.window_states}, prior,
                              options_.estimate_time_offset);
}

void InertialOdometry::Impl::StartTight(const InertialPrior& prior) {
  tight_.Cancel();
  if (options_.coupling != InertialCoupling::kTight || !model_) return;
  auto window = VisualInertialWindow::Make(calibration_, *model_, options_, prior);
  if (!window) return;  // the loosely coupled smoother continues alone
  tight_.Put(std::make_unique<TightCoupling>(options_, std::move(*window), background_, profile_));
}

bool InertialOdometry::Impl::Start(const InertialPrior& prior) {
  std::optional<InertialWindow> window = MakeLoose(prior);
  if (!window) return false;
  window_ = std::move(window);
  StartTight(prior);
  status_ = InertialStatus::kRunning;
  return true;
}

InitializationReport InertialOdometry::Impl::SolveWithSign(const VisualPose& visual,
                                                           InertialReport& report) const {
  InitializationReport solution = initializer_.Solve(buffer_);
  // A slow body fits both signs of gravity nearly as well, one of them with the world upside down.
  const bool upside_down =
      solution.estimate &&
      (visual.T_WC.q().conjugate() * solution.estimate->gravity_W.vector()).y() < -0.5;
  if (!upside_down && solution.status != InitializationStatus::kInconsistent) return solution;
  const auto all = buffer_.Between(buffer_.oldest(), buffer_.newest());
  if (!all) return solution;
  ImuBuffer reversed(options_.buffer);
  for (ImuSample sample : all->samples) {
    sample.accelerometer = -sample.accelerometer;
    reversed.Add(sample);
  }
  const InitializationReport other = initializer_.Solve(reversed);
  if (!other.estimate || !(other.error < solution.error)) return solution;
  constexpr double kClearly = 0.5;  // errors of a slow body differ by little, and by chance
  const bool is_clear = other.error < kClearly * solution.error;
  if (solution.status == InitializationStatus::kInconsistent && !is_clear) return solution;
  solution.reversed = is_clear ? ReversedFit::kClearlyBetter : ReversedFit::kBetter;
  solution.status = InitializationStatus::kInconsistent;
  report.reason = AccelerometerReversed().text;
  return solution;
}

void InertialOdometry::Impl::Advance(const Observation& observation, InertialReport& report) {
  TakeOver(&report);
  const auto imu = Between(window_->newest().stamp, ImuStamp(observation.image));
  if (!imu) {
    Suspend();
    Resume(observation, report);
    return;
  }
  ImuWeightInput input;
  input.motion = MeasureMotion(imu->samples(), bias_);
  input.motion.sharpness = observation.sharpness;
  input.motion.tracked_share = observation.tracked_share;
  report.saturated = std::ranges::any_of(
      imu->samples(), [&](const ImuSample& sample) { return IsSaturated(sample, calibration_); });

  InertialWindow::Step step;
  std::optional<VisualPose> visual;
  if (observation.visual) {
    visual = InO(*observation.visual);
    visual_rest_.Add(observation.image, visual->T_WC.p());
    step.visual = &*visual;
    step.omega_B = RateAt(buffer_, imu->end(), bias_);
    if (Innovate(*imu, *visual, observation.image, report)) {
      report.contradicted = true;
      RejectInterval(*imu);
      Suspend();
      Resume(observation, report);
      return;
    }
    input.squared_innovation = report.squared_innovation;
    input.dof = report.innovation_dof;
  }
  step.imu = &*imu;
  step.weight = report.weight = weight_.Update(input);
  step.stationary = report.stationary = is_stationary_ = IsAtRest(*imu, !observation.visual);
  if (!window_->Add(step)) {
    report.weight = 0.0;
    Suspend();
    Resume(observation, report);
    return;
  }
  if (!tight_.IsEmpty()) Couple(observation, step);
  ReadWindow();
  TakeOver(&report);
  if (!observation.keeps_level) report.T_gravity = Level();
  status_ = step.visual != nullptr ? InertialStatus::kRunning : InertialStatus::kDeadReckoning;
  if (step.visual == nullptr && last_visual_ &&
      ToSeconds(observation.image - last_visual_->stamp) > options_.max_dead_reckoning) {
    Suspend();
  }
}

void InertialOdometry::Impl::Couple(const Observation& observation,
                                    const InertialWindow::Step& step) {
  TightCoupling::Image image{.imu = *step.imu,
                             .weight = step.weight,
                             .visual = std::nullopt,
                             .time_offset = ToSeconds(step.imu->end() - observation.image),
                             .omega_B = step.omega_B,
                             .stationary = step.stationary};
  if (step.visual != nullptr) image.visual = *step.visual;
  tight_->Add(std::move(image), T_WO_.Inverse(), observation.visual ? observation.see : nullptr);
}

std::optional<InertialWindow> InertialOdometry::Impl::Follow(
    const TightCoupling::Result& result) const {
  if (!result.prior) return std::nullopt;
  std::optional<InertialWindow> window = MakeLoose(*result.prior);
  if (!window) return std::nullopt;
  for (const TightCoupling::Image& image : result.since) {
    const bool added = window->Add({.imu = &image.imu,
                                    .weight = image.weight,
                                    .visual = image.visual ? &*image.visual : nullptr,
                                    .time_offset = image.time_offset,
                                    .omega_B = image.omega_B,
                                    .stationary = image.stationary});
    if (!added) return std::nullopt;
  }
  return window;
}

void InertialOdometry::Impl::TakeOver(InertialReport* report) {
  if (tight_.IsEmpty()) return;
  const std::optional<TightCoupling::Result> result = tight_->Take();
  if (!result) return;
  report->tight = result->update;
  if (std::optional<InertialWindow> window = Follow(*result)) {
    window_ = std::move(window);
  } else {
    StartTight(window_->Prior());
  }
  ReadWindow();
}

void InertialOdometry::Impl::ReadWindow() {
  bias_ = window_->newest().bias;
  time_offset_ = window_->time_offset();
  T_BC_ = window_->T_BC();
}

std::optional<Pose> InertialOdometry::Impl::Level() {
  const double sigma = window_->Prior().gravity_sigma();
  if (sigma > kBetterGravity * levelled_to_) return std::nullopt;
  levelled_to_ = sigma;
  const Eigen::Vector3d up_W = -(T_WO_.q() * window_->gravity_W().vector());
  const double tilt = std::acos(std::clamp(up_W.z(), -1.0, 1.0));
  if (tilt < std::max(kSureTilt * sigma, kWorthwhileTilt)) return std::nullopt;
  // About the camera, which stays where it is.
  const Eigen::Quaterniond q = Upright(up_W);
  const Eigen::Vector3d p_W = T_WC()->p();
  const Pose T_gravity(q, p_W - q * p_W);
  T_WO_ = T_gravity * T_WO_;
  if (last_visual_) last_visual_->pose = T_gravity * last_visual_->pose;
  return T_gravity;
}

void InertialOdometry::Impl::Suspend() {
  known_ = window_->Prior();
  InflateCovariance(*known_);
  is_stationary_ = false;
  window_.reset();
  tight_.Cancel();
  status_ = InertialStatus::kWaiting;
}

void InertialOdometry::Impl::Resume(const Observation& observation, InertialReport& report) {
  const Stamp stamp = ImuStamp(observation.image);
  const auto latest =
      buffer_.empty() ? std::nullopt : buffer_.Between(stamp - FromSeconds(0.005), stamp);
  if (!latest || latest->HasGap()) {
    report.reason = "no readings";
    return;
  }
  if (!observation.visual || !last_visual_ ||
      ToSeconds(observation.image - last_visual_->stamp) > kNeighbours) {
    report.reason = "two consecutive images must give a pose";
    return;
  }
  const double step = ToSeconds(observation.image - last_visual_->stamp);
  const double pause = ToSeconds(stamp - known_->estimate.stamp);
  InertialPrior prior = *known_;
  InertialEstimate& estimate = prior.estimate;
  const Pose T_CB = T_BC_.Inverse();
  const Pose T_OB = InO(*observation.visual).T_WC * T_CB;
  const Pose T_OB_before = T_WO_.Inverse() * last_visual_->pose * T_CB;
  estimate.stamp = stamp;
  estimate.state.T_WB = T_OB;
  estimate.state.v_WB = (T_OB.p() - T_OB_before.p()) / step;
  // The image observes the camera: the uncertainty of T_BC is also that of the body.
  const Eigen::MatrixXd joint = prior.Joint();
  Eigen::MatrixXd J = Eigen::MatrixXd::Identity(joint.rows(), joint.cols());
  J.topRows<9>().setZero();
  if (prior.T_BC) J.topRightCorner<6, 6>() = BodyByExtrinsics(T_OB, T_BC_);
  const auto squared = [](double sigma) -> Eigen::Vector3d {
    return Eigen::Vector3d::Constant(sigma * sigma);
  };
  Eigen::Matrix<double, 15, 1> variance;
  variance << squared(0.01), squared(0.005), squared(kRestartVelocitySigma),
      pause * squared(calibration_.noise.gyroscope_walk),
      pause * squared(calibration_.noise.accelerometer_walk);
  Eigen::MatrixXd anew = J * joint * J.transpose();
  anew.diagonal().head<15>() += variance;
  prior.SetJoint(anew);
  if (!Start(prior)) {
    report.reason = kNoStart;
    return;
  }
  known_.reset();
  report.restarted = true;
}

bool InertialOdometry::Impl::Innovate(const ImuPreintegration& imu, const VisualPose& visual_O,
                                      Stamp image, InertialReport& report) const {
  const CameraPoseEstimate predicted = PredictCamera(window_->Prior(), T_BC_, imu);
  const std::optional<double> squared = SquaredInnovation(predicted, visual_O);
  if (!squared) return false;
  report.squared_innovation = *squared;
  report.innovation_dof = kInnovationDof;
  if (!visual_motion_ || !last_visual_) return false;
  const double since = ToSeconds(image - last_visual_->stamp);
  if (!(since > 0.0 && since <= kNeighbours)) return false;
  const Pose steady = T_WO_.Inverse() * last_visual_->pose * visual_motion_->Over(since);
  const bool known_bad = !contradicted_.empty() && contradicted_.back().second == imu.start();
  return AreReadingsContradicted(*squared, predicted, visual_O.T_WC, steady, known_bad);
}

void InertialOdometry::Impl::RejectInterval(const ImuPreintegration& imu) {
  std::erase_if(contradicted_,
                [&](const auto& interval) { return interval.second < buffer_.oldest(); });
  contradicted_.emplace_back(imu.start(), imu.end());
  const Stamp offset = FromSeconds(time_offset());
  monitor_.LeaveOut(imu.start() - offset, imu.end() - offset);
}

std::optional<Twist> InertialOdometry::Impl::MotionTo(const Observation& observation) const {
  if (!observation.visual || !last_visual_) return std::nullopt;
  const double since = ToSeconds(observation.image - last_visual_->stamp);
  if (!(since > 0.0 && since <= kNeighbours)) return std::nullopt;
  constexpr double kFast = 1e3;  // [m/s] above any camera's speed; not a motion if not finite
  const Pose &from = last_visual_->pose, &to = observation.visual->T_WC;
  if (!((to.p() - from.p()).norm() < kFast * since)) return std::nullopt;
  return Twist::Between(from.Inverse() * to, since);
}

bool InertialOdometry::Impl::IsAtRest(const ImuPreintegration& imu, bool is_dark) const {
  const Stamp end = imu.end();
  const Stamp start = end - FromSeconds(1.5 * kStationary.min_duration);
  const InertialEstimate& newest = window_->newest();
  const Eigen::Vector3d& v = newest.state.v_WB;
  if (v.norm() > kStationarySpeed) return false;
  const Eigen::Matrix3d covariance = newest.covariance.block<3, 3>(6, 6);
  if (!(v.dot(covariance.ldlt().solve(v)) <= kRestChi2)) return false;
  if (is_dark ? !is_stationary_ : !visual_rest_.Agrees()) return false;
  const auto interval = buffer_.Between(start, end);
  return interval && !interval->HasGap() && IsStationary(interval->samples, kStationary);
}

VisualPose InertialOdometry::Impl::InO(const VisualPose& visual_W) const {
  return Moved(visual_W, T_WO_.Inverse());
}

std::optional<InertialEstimate> InertialOdometry::Impl::estimate() const {
  if (!window_) return std::nullopt;
  InertialEstimate in_W = window_->newest();
  in_W.state.T_WB = T_WO_ * in_W.state.T_WB;
  in_W.state.v_WB = T_WO_.q() * in_W.state.v_WB;
  Eigen::Matrix<double, 15, 15> J = Eigen::Matrix<double, 15, 15>::Identity();
  J.block<3, 3>(0, 0) = J.block<3, 3>(6, 6) = T_WO_.R();
  in_W.covariance = J * in_W.covariance * J.transpose();
  return in_W;
}

std::optional<ExtrinsicsEstimate> InertialOdometry::Impl::extrinsics() const {
  constexpr double kSeen = 0.5;  // of the prior standard deviation
  if (!options_.estimate_extrinsics || (!window_ && !known_)) return std::nullopt;
  const InertialPrior prior = window_ ? window_->Prior() : *known_;
  const Vector6 sigma = prior.calibration_covariance.diagonal().tail<6>().cwiseMax(0).cwiseSqrt();
  ExtrinsicsEstimate estimate{T_BC_, sigma.head<3>(), sigma.tail<3>()};
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    estimate.lever_arm_seen[axis] = sigma[i] < kSeen * options_.extrinsics_position_sigma;
    estimate.rotation_seen[axis] = sigma[3 + i] < kSeen * options_.extrinsics_rotation_sigma;
  }
  return estimate;
}

std::optional<Pose> InertialOdometry::Impl::T_WC() const {
  if (!window_) return std::nullopt;
  return T_WO_ * window_->newest().state.T_WB * T_BC_;
}

std::optional<Eigen::Vector3d> InertialOdometry::Impl::gravity_W() const {
  if (!window_) return std::nullopt;
  return T_WO_.q() * (kStandardGravity * window_->gravity_W().vector());
}

double InertialOdometry::Impl::gravity_sigma() const {
  return window_ ? window_->Prior().gravity_sigma() : M_PI;
}

double InertialOdometry::Impl::time_offset() const {
  return time_offset_;
}

double InertialOdometry::Impl::time_offset_sigma() const {
  return window_ ? window_->Prior().time_offset_sigma() : options_.initializer.time_offset_sigma;
}

}  // namespace highwall
