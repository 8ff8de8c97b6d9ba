#include "inertial/visual_inertial_window.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/so3.h>
#include <highwall/factors/extrinsic_factor.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/time_offset_factor.h>
#include <highwall/factors/zero_velocity.h>

#include "inertial/joint_prior.h"
#include "inertial/known_point.h"

namespace highwall {
namespace {

// Columns of InertialEstimate::covariance, and of gravity's direction in InertialPrior::Joint().
using namespace state_rows;
constexpr double kHuber = 2.8;  // [sigma] on the norm of a landmark's rows, as in adjustment
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Returns the sqrt information of T_VW, about the body at p_W, where errors of distant parts of the
// map have no effect.
Matrix6 SqrtInformationOf(double position, double rotation, const Eigen::Vector3d& p_W) {
  Eigen::Matrix<double, 6, 1> w;
  w << Eigen::Vector3d::Constant(1.0 / position), Eigen::Vector3d::Constant(1.0 / rotation);
  Matrix6 about_body = Matrix6::Identity();
  about_body.topRightCorner<3, 3>() = -so3::Hat(p_W);
  return w.asDiagonal() * about_body;
}

SlidingWindowOptions SmootherOptions(const InertialOptions& options,
                                     const std::atomic<bool>* stopped) {
  SlidingWindowOptions smoother{.max_states = options.window_states,
                                .landmarks = LandmarkPolicy::kMarginalize};
  smoother.solve.stop = stopped;
  return smoother;
}

// Returns the maximum number of landmarks of one image.
template <class Landmark>
int MostOf(const TightWindowOptions& options) = delete;
template <>
int MostOf<MapPoint>(const TightWindowOptions& options) {
  return options.max_points;
}
template <>
int MostOf<MapLine>(const TightWindowOptions& options) {
  return options.max_lines;
}

}  // namespace

std::optional<VisualInertialWindow> VisualInertialWindow::Make(const ImuCalibration& calibration,
                                                               const MeasurementModel& model,
                                                               const InertialOptions& options,
                                                               const InertialPrior& prior,
                                                               const MapDrift& drift) {
  if (!prior.IsFinite()) return std::nullopt;
  VisualInertialWindow window(calibration, model, options, prior, drift);
  if (!window.Begin(prior)) return std::nullopt;
  return window;
}

VisualInertialWindow::VisualInertialWindow(const ImuCalibration& calibration,
                                           const MeasurementModel& model,
                                           const InertialOptions& options,
                                           const InertialPrior& prior, const MapDrift& drift)
    : model_(model),
      options_(options),
      drift_(drift),
      stopped_(std::make_unique<std::atomic<bool>>(false)),
      smoother_(SmootherOptions(options, stopped_.get())),
      map_loss_(std::make_shared<ceres::HuberLoss>(kHuber)),
      newest_V_(prior.estimate),
      newest_(prior.estimate),
      gravity_W_(prior.gravity_W),
      calibration_covariance_(prior.calibration_covariance),
      coupling_(prior.coupling) {
  if (prior.T_BC) T_BC_ = smoother_.AddCalibration(*prior.T_BC);
  model_.SetExtrinsics(prior.T_BC ? Pose() : calibration.T_BC);
  gravity_ = smoother_.AddCalibration(prior.gravity_W);
  time_offset_ = smoother_.AddCalibration(prior.time_offset);
  if (!options_.estimate_time_offset) smoother_.Fix(time_offset_);
  last_ = AddState(prior.estimate, Pose());
}

bool VisualInertialWindow::Begin(const InertialPrior& prior) {
  if (!AddPrior(prior)) return false;
  const UpdateReport report = smoother_.Update(QueriedVariables());
  if (!report.accepted || !report.covariance) return false;
  ReadNewest(prior.estimate.stamp);
  ReadCovariance(*report.covariance);
  return true;
}

bool VisualInertialWindow::AddPrior(const InertialPrior& prior) {
  std::vector<VariableId> ids = {last_.pose, last_.velocity, last_.bias, gravity_};
  if (options_.estimate_time_offset) ids.push_back(time_offset_);
  if (T_BC_) ids.push_back(*T_BC_);
  if (!AddJointPrior(options_.estimate_time_offset ? prior.Joint() : prior.JointWithoutTimeOffset(),
                     ids, &smoother_)) {
    return false;
  }
  const VisualNoise& noise = options_.visual_noise;
  smoother_.AddFactor(
      std::make_unique<PosePrior>(
          Pose(), SqrtInformationOf(noise.position, noise.rotation, prior.estimate.state.T_WB.p())),
      last_.T_VW);
  return true;
}

VisualInertialWindow::State VisualInertialWindow::AddState(const InertialEstimate& in_V,
                                                           const Pose& T_VW) {
  return {smoother_.AddState(in_V.stamp, in_V.state.T_WB),
          smoother_.AddState(in_V.stamp, in_V.state.v_WB),
          smoother_.AddState(in_V.stamp, in_V.bias), smoother_.AddState(in_V.stamp, T_VW)};
}

void VisualInertialWindow::AddImuFactor(const State& before, const State& after, const Step& step) {
  smoother_.AddFactor(std::make_unique<ImuGravityFactor>(*step.imu, kStandardGravity, step.weight),
                      before.pose, before.velocity, before.bias, after.pose, after.velocity,
                      after.bias, gravity_);
  const double root = std::sqrt(step.imu->delta().duration);
  const Matrix6 W =
      SqrtInformationOf(drift_.position * root, drift_.rotation * root, newest_.state.T_WB.p());
  smoother_.AddFactor(std::make_unique<RelativePose>(Pose(), W), before.T_VW, after.T_VW);
  if (step.stationary) smoother_.AddFactor(std::make_unique<ZeroVelocity>(), after.velocity);
}

bool VisualInertialWindow::Add(const Step& step, const std::stop_token& stop, std::string* reason) {
  const std::string why = TryAdd(step, stop);
  if (reason != nullptr) *reason = why;
  return why.empty();
}

std::string VisualInertialWindow::TryAdd(const Step& step, const std::stop_token& stop) {
  constexpr const char* kStopped = "it was stopped";
  *stopped_ = false;
  const std::stop_callback on_stop(stop, [this] { *stopped_ = true; });
  if (*stopped_) return kStopped;
  if (!step.imu->HasInformation()) return "its readings have no information";
  const Eigen::Vector3d gravity_V = kStandardGravity * smoother_.Value(gravity_).vector();
  const InertialEstimate predicted = Propagate(newest_V_, *step.imu, gravity_V);
  const State after = AddState(predicted, smoother_.Value(last_.T_VW));
  AddImuFactor(last_, after, step);
  if (step.seen != nullptr) {
    const ImageObservation observation{step, after, LossOf(*step.seen)};
    ForEachKind([&]<class Landmark>() {
      if constexpr (LandmarkTraits<Landmark>::kInInertialWindow) {
        Observe<Landmark>(observation, MostOf<Landmark>(options_.tight));
      }
    });
  }
  const State before = std::exchange(last_, after);
  const UpdateReport report = smoother_.Update(QueriedVariables());
  // Landmarks that were marginalized, and those of a rejected step.
  ForEachKind([&]<class Landmark>() {
    std::erase_if(PartOf<Landmark>(landmarks_),
                  [&](const auto& known) { return !smoother_.Contains(known.second); });
  });
  if (!report.accepted) {
    last_ = before;
    return report.message.empty() ? "the update was rejected" : report.message;
  }
  ReadNewest(predicted.stamp);
  if (report.covariance) ReadCovariance(*report.covariance);
  if (*stopped_) return kStopped;
  return report.covariance ? "" : "a direction of the new state is not observable";
}

std::vector<VariableId> VisualInertialWindow::QueriedVariables() const {
  std::vector<VariableId> queried = {last_.pose, last_.velocity, last_.bias, gravity_,
                                     time_offset_};
  if (T_BC_) queried.push_back(*T_BC_);
  queried.push_back(last_.T_VW);
  return queried;
}

// The variance is that of the image's own residuals, times a factor for their common part as in
// VisualNoise, because their errors are not independent.
std::shared_ptr<ceres::LossFunction> VisualInertialWindow::LossOf(const SeenLandmarks& seen) const {
  const VisualNoise& noise = options_.visual_noise;
  const double variance = noise.scale * std::max(seen.error, noise.min_error);
  return std::make_shared<ceres::ScaledLoss>(new ceres::HuberLoss(kHuber * std::sqrt(variance)),
                                             1.0 / variance, ceres::TAKE_OWNERSHIP);
}

template <class Landmark>
void VisualInertialWindow::Observe(const ImageObservation& observation, int most) {
  using Seen = SeenLandmark<Landmark>;
  Variables<Landmark>& known = PartOf<Landmark>(landmarks_);
  std::vector<const Seen*> fresh;
  for (const Seen& one : PartOf<Landmark>(*observation.step.seen)) {
    const auto found = known.find(one.id);
    if (found == known.end()) {
      fresh.push_back(&one);
    } else {
      AddObservation(observation, one, found->second);
      --most;
    }
  }
  // Those with the most observations in the map come first.
  std::stable_sort(fresh.begin(), fresh.end(),
                   [](const Seen* a, const Seen* b) { return a->views.size() > b->views.size(); });
  fresh.resize(std::min(fresh.size(), static_cast<std::size_t>(std::max(most, 0))));
  const Pose T_VM = smoother_.Value(observation.state.T_VW) * observation.step.T_WM;
  for (const Seen* one : fresh) {
    const VariableOf<Landmark> landmark =
        smoother_.AddLandmark(LandmarkTraits<Landmark>::VariableAt(T_VM * one->geometry_W));
    known.emplace(one->id, landmark);
    AddMapObservation(observation, *one, landmark);
    AddObservation(observation, *one, landmark);
  }
}

void VisualInertialWindow::AddMapObservation(const ImageObservation& observation,
                                             const SeenLandmark<MapPoint>& seen,
                                             const Variable<Point>& point) {
  smoother_.AddFactor(KnownPoint(seen, observation.step.T_WM, model_, kHuber),
                      observation.state.T_VW, point);
}

// The map is treated as a body that carries the keyframes' cameras.
void VisualInertialWindow::AddMapObservation(const ImageObservation& observation,
                                             const SeenLandmark<MapLine>& seen,
                                             const Variable<OrthonormalLine>& line) {
  for (const auto& [T_MC, feature] : seen.views) {
    smoother_.AddFactorToBlocks(model_.MakeFactor(*feature, observation.step.T_WM * T_MC),
                                map_loss_, std::vector<VariableId>{observation.state.T_VW, line});
  }
}

template <class Landmark>
void VisualInertialWindow::AddObservation(const ImageObservation& observation,
                                          const SeenLandmark<Landmark>& seen,
                                          const VariableId& landmark) {
  std::vector<VariableId> on = {observation.state.pose, landmark};
  std::shared_ptr<ceres::CostFunction> factor = model_.MakeFactor(*seen.feature);
  if (T_BC_) {
    factor = std::make_shared<ExtrinsicFactor>(std::move(factor));
    on.push_back(*T_BC_);
  }
  if (options_.estimate_time_offset) {
    factor = std::make_shared<TimeOffsetFactor>(
        std::move(factor), smoother_.Value(observation.state.velocity), observation.step.omega_B,
        observation.step.time_offset);
    on.push_back(time_offset_);
  }
  smoother_.AddFactorToBlocks(std::move(factor), observation.loss, on);
}

void VisualInertialWindow::ReadNewest(Stamp stamp) {
  newest_V_.stamp = newest_.stamp = stamp;
  newest_V_.state = {smoother_.Value(last_.pose), smoother_.Value(last_.velocity)};
  newest_V_.bias = newest_.bias = smoother_.Value(last_.bias);
  const Pose T_WV = smoother_.Value(last_.T_VW).Inverse();
  newest_.state = {T_WV * newest_V_.state.T_WB, T_WV.q() * newest_V_.state.v_WB};
  gravity_W_ = UnitDirection(T_WV.q() * smoother_.Value(gravity_).vector());
}

void VisualInertialWindow::ReadCovariance(const Eigen::MatrixXd& covariance) {
  // From [state, n, t_d, T_BC, T_VW] in V to [state, n, t_d, T_BC] in W, where T_BC is known
  // without it, e being the step of T_VW's rotation:
  //   p_W = R_VW^T (p_V - p_VW),   R_WB = Exp(-e) R_VW^T R_VB.
  const Eigen::Index size = covariance.rows() - 6;
  const Eigen::Matrix3d R_WV = smoother_.Value(last_.T_VW).R().transpose();
  const ImuState& in_W = newest_.state;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(size, size + 6);
  J.leftCols(size).setIdentity();
  J.block<3, 3>(kP, kP) = R_WV;
  J.block<3, 3>(kP, size) = -R_WV;
  J.block<3, 3>(kP, size + 3) = so3::Hat(in_W.T_WB.p());
  J.block<3, 3>(kTheta, size + 3) = -in_W.T_WB.R().transpose();
  J.block<3, 3>(kV, kV) = R_WV;
  J.block<3, 3>(kV, size + 3) = so3::Hat(in_W.v_WB);
  const auto basis_W = UnitDirectionManifold::Basis(gravity_W_.data());
  const UnitDirection gravity_V = smoother_.Value(gravity_);
  J.block<2, 2>(kN, kN) =
      basis_W.transpose() * R_WV * UnitDirectionManifold::Basis(gravity_V.data());
  J.block<2, 3>(kN, size + 3) = basis_W.transpose() * so3::Hat(gravity_W_.vector());
  const Eigen::MatrixXd joint = J * covariance * J.transpose();
  newest_.covariance = joint.topLeftCorner<kN, kN>();
  coupling_ = joint.topRightCorner(kN, size - kN);
  calibration_covariance_ = joint.bottomRightCorner(size - kN, size - kN);
}

InertialPrior VisualInertialWindow::Prior() const {
  const std::optional<Pose> T_BC = T_BC_ ? std::optional(smoother_.Value(*T_BC_)) : std::nullopt;
  return {newest_, gravity_W_, time_offset(), T_BC, calibration_covariance_, coupling_};
}

}  // namespace highwall
