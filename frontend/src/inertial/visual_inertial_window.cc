#include "inertial/visual_inertial_window.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/so3.h>
#include <highwall/core/sqrt_information.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/zero_velocity.h>

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

// Landmarks of the window by their ids.
template <class Id>
using Known = std::vector<std::pair<Id, std::size_t>>;

template <class Landmark>
auto IndexOf(const std::vector<Landmark>& landmarks) {
  Known<decltype(Landmark::id)> known;
  known.reserve(landmarks.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i) known.emplace_back(landmarks[i].id, i);
  std::sort(known.begin(), known.end());
  return known;
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
  options.Validate();
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
      landmarks_(model.projection()),
      problem_(std::make_unique<WindowProblem>()),
      newest_V_(prior.estimate),
      newest_(prior.estimate),
      gravity_W_(prior.gravity_W),
      time_offset_(prior.time_offset),
      T_BC_(prior.T_BC),
      calibration_covariance_(prior.calibration_covariance),
      coupling_(prior.coupling) {
  graph_.unknowns = {.time_offset = options.estimate_time_offset, .T_BC = prior.T_BC.has_value()};
  graph_.values.gravity = prior.gravity_W;
  graph_.values.time_offset = prior.time_offset;
  graph_.values.T_BC = prior.T_BC.value_or(calibration.T_BC);
  const InertialEstimate& start = prior.estimate;
  graph_.values.states.push_back({start.state.T_WB, Pose(), start.state.v_WB, start.bias});
  graph_.images.emplace_back();
  graph_.factors.emplace_back();
}

bool VisualInertialWindow::Begin(const InertialPrior& prior) {
  if (!SetPrior(prior) || !problem_->Linearize(&graph_, &landmarks_).empty()) return false;
  const std::optional<Eigen::MatrixXd> covariance = problem_->Covariance();
  if (!covariance) return false;
  ReadNewest(prior.estimate.stamp);
  ReadCovariance(*covariance);
  return true;
}

bool VisualInertialWindow::SetPrior(const InertialPrior& prior) {
  std::string fault;
  const std::optional<Eigen::MatrixXd> root = internal::TrySqrtInformation(
      options_.estimate_time_offset ? prior.Joint() : prior.JointWithoutTimeOffset(), &fault);
  if (!root || !root->allFinite()) return false;
  WindowLayout layout;
  layout.OrderByState(1, graph_.unknowns);
  std::vector<int> rows;  // of the joint covariance
  for (int k = 0; k < 6; ++k) rows.push_back(layout.head[0] + k);
  for (int k = layout.tail[0]; k < layout.size; ++k) rows.push_back(k);
  WindowPrior& start = graph_.prior;
  start.at = graph_.values;
  start.H.setZero(layout.size, layout.size);
  start.g.setZero(layout.size);
  start.H(rows, rows) = root->transpose() * *root;
  const VisualNoise& noise = options_.visual_noise;
  const Matrix6 W =
      SqrtInformationOf(noise.position, noise.rotation, prior.estimate.state.T_WB.p());
  start.H.block<6, 6>(layout.head[0] + 6, layout.head[0] + 6) = W.transpose() * W;
  return start.H.allFinite();
}

void VisualInertialWindow::AddState(const InertialEstimate& predicted_V, const Step& step) {
  using Kind = WindowFactor::Kind;
  const int before = graph_.states() - 1, after = before + 1;
  const Pose T_VW = graph_.values.states.back().T_VW;
  graph_.values.states.push_back(
      {predicted_V.state.T_WB, T_VW, predicted_V.state.v_WB, predicted_V.bias});
  graph_.images.push_back({predicted_V.state.v_WB, step.omega_B, step.time_offset});
  std::vector<WindowFactor>& factors = graph_.factors.emplace_back();
  factors.push_back({"ImuGravityFactor",
                     std::make_unique<ImuGravityFactor>(*step.imu, kStandardGravity, step.weight),
                     {{Kind::kBody, before},
                      {Kind::kVelocity, before},
                      {Kind::kBias, before},
                      {Kind::kBody, after},
                      {Kind::kVelocity, after},
                      {Kind::kBias, after},
                      {Kind::kGravityDirection}}});
  const double root = std::sqrt(step.imu->delta().duration);
  const Matrix6 W =
      SqrtInformationOf(drift_.position * root, drift_.rotation * root, newest_.state.T_WB.p());
  factors.push_back({"RelativePose",
                     std::make_unique<RelativePose>(Pose(), W),
                     {{Kind::kMap, before}, {Kind::kMap, after}}});
  if (!step.stationary) return;
  factors.push_back({"ZeroVelocity", std::make_unique<ZeroVelocity>(), {{Kind::kVelocity, after}}});
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
  HIGHWALL_REQUIRE(std::isfinite(step.time_offset) && step.omega_B.allFinite(),
                   "VisualInertialWindow: time offset and angular velocity must be finite");
  if (!step.imu->HasInformation()) return "its readings have no information";
  const Eigen::Vector3d gravity_V = kStandardGravity * graph_.values.gravity.vector();
  const InertialEstimate predicted = Propagate(newest_V_, *step.imu, gravity_V);
  AddState(predicted, step);
  if (step.seen != nullptr) {
    ForEachKind([&]<class Landmark>() {
      if constexpr (LandmarkTraits<Landmark>::kInInertialWindow) {
        Observe<Landmark>(step, MostOf<Landmark>(options_.tight));
      }
    });
  }
  std::string fault = problem_->Solve(*stopped_, &graph_, &landmarks_);
  if (!fault.empty()) return fault;
  if (*stopped_) return kStopped;
  if (!graph_.values.IsFinite()) return "the solution is not finite";
  const std::optional<Eigen::MatrixXd> covariance = problem_->Covariance();
  if (!covariance) return "a direction of the new state is not observable";
  ReadNewest(predicted.stamp);
  ReadCovariance(*covariance);
  return Shrink();
}

std::string VisualInertialWindow::Shrink() {
  if (graph_.states() <= options_.window_states) return "";
  WindowFrames frames;
  frames.MoveTo(graph_.values, graph_.images, graph_.unknowns);
  leaving_.Reset(static_cast<int>(frames.frames.size()));
  if (!landmarks_.Leave(frames, &leaving_)) return "a landmark that leaves cannot be evaluated";
  WindowLayout layout;
  layout.OrderByState(graph_.states(), graph_.unknowns);
  marginal_.Reset(layout.size);
  leaving_.AddTo(frames, layout, &marginal_);
  return graph_.RemoveOldest(&marginal_);
}

// The variance is that of the image's own residuals, times a factor for their common part as in
// VisualNoise, because their errors are not independent.
WindowLoss VisualInertialWindow::LossOf(const SeenLandmarks& seen) const {
  const VisualNoise& noise = options_.visual_noise;
  const double variance = noise.scale * std::max(seen.error, noise.min_error);
  return {kHuber * std::sqrt(variance), 1.0 / variance};
}

template <class Landmark>
void VisualInertialWindow::Observe(const Step& step, int most) {
  using Seen = SeenLandmark<Landmark>;
  auto& landmarks = [&]() -> auto& {
    if constexpr (std::is_same_v<Landmark, MapPoint>) {
      return landmarks_.points();
    } else {
      return landmarks_.lines();
    }
  }
  ();
  const WindowLoss loss = LossOf(*step.seen);
  const int camera = CameraFrame(graph_.states() - 1);
  const auto add_view = [&](const Seen& one, auto* landmark) {
    landmark->views.push_back(ViewOf(one));
    landmark->views.back().frame = camera;
    landmark->views.back().loss = loss;
  };
  const auto known = IndexOf(landmarks);
  std::vector<const Seen*> fresh;
  for (const Seen& one : PartOf<Landmark>(*step.seen)) {
    const auto found =
        std::ranges::lower_bound(known, one.id, {}, [](const auto& k) { return k.first; });
    if (found == known.end() || found->first != one.id) {
      fresh.push_back(&one);
    } else {
      add_view(one, &landmarks[found->second]);
      --most;
    }
  }
  // Those with the most observations in the map come first.
  std::stable_sort(fresh.begin(), fresh.end(),
                   [](const Seen* a, const Seen* b) { return a->views.size() > b->views.size(); });
  fresh.resize(std::min(fresh.size(), static_cast<std::size_t>(std::max(most, 0))));
  const Pose T_VM = graph_.values.states.back().T_VW * step.T_WM;
  for (const Seen* one : fresh) {
    auto& landmark = landmarks.emplace_back();
    landmark.id = one->id;
    landmark.value = LandmarkTraits<Landmark>::VariableAt(T_VM * one->geometry_W);
    add_view(*one, &landmark);
    AddMapViews(step, *one, &landmark);
  }
}

void VisualInertialWindow::AddMapViews(const Step& step, const SeenLandmark<MapPoint>& seen,
                                       WindowPoint* point) const {
  const std::unique_ptr<PointInFrame> known = KnownPoint(seen, step.T_WM, model_, kHuber);
  const Eigen::Matrix3d& W = known->sqrt_information();
  point->views.push_back({.frame = MapFrame(graph_.states() - 1), .rows = {W, -W * known->p_F()}});
}

// The map is treated as a body that carries the keyframes' cameras.
void VisualInertialWindow::AddMapViews(const Step& step, const SeenLandmark<MapLine>& seen,
                                       WindowLine* line) const {
  for (const auto& [T_MC, feature] : seen.views) {
    line->views.push_back({.frame = MapFrame(graph_.states() - 1),
                           .loss = {.width = kHuber},
                           .factor = model_.MakeFactor(*feature, step.T_WM * T_MC)});
  }
}

WindowPointView VisualInertialWindow::ViewOf(const SeenLandmark<MapPoint>& seen) const {
  return {.rows = model_.Rows(*seen.feature)};
}

WindowLineView VisualInertialWindow::ViewOf(const SeenLandmark<MapLine>& seen) const {
  return {.factor = model_.MakeFactor(*seen.feature, Pose())};
}

void VisualInertialWindow::ReadNewest(Stamp stamp) {
  const WindowState& state = graph_.values.states.back();
  newest_V_.stamp = newest_.stamp = stamp;
  newest_V_.state = {state.T_VB, state.velocity};
  newest_V_.bias = newest_.bias = state.bias;
  const Pose T_WV = state.T_VW.Inverse();
  newest_.state = {T_WV * newest_V_.state.T_WB, T_WV.q() * newest_V_.state.v_WB};
  gravity_W_ = UnitDirection(T_WV.q() * graph_.values.gravity.vector());
  time_offset_ = graph_.values.time_offset;
  if (T_BC_) T_BC_ = graph_.values.T_BC;
}

void VisualInertialWindow::ReadCovariance(const Eigen::MatrixXd& covariance) {
  // From [state, n, t_d, T_BC, T_VW] in V to [state, n, t_d, T_BC] in W, where T_BC is known
  // without it, e being the step of T_VW's rotation:
  //   p_W = R_VW^T (p_V - p_VW),   R_WB = Exp(-e) R_VW^T R_VB.
  covariance_V_ = covariance;
  const Eigen::Index size = covariance.rows() - 6;
  const Eigen::Matrix3d R_WV = newest_V().T_VW.R().transpose();
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
  const UnitDirection& gravity_V = graph_.values.gravity;
  J.block<2, 2>(kN, kN) =
      basis_W.transpose() * R_WV * UnitDirectionManifold::Basis(gravity_V.data());
  J.block<2, 3>(kN, size + 3) = basis_W.transpose() * so3::Hat(gravity_W_.vector());
  const Eigen::MatrixXd joint = J * covariance * J.transpose();
  newest_.covariance = joint.topLeftCorner<kN, kN>();
  coupling_ = joint.topRightCorner(kN, size - kN);
  calibration_covariance_ = joint.bottomRightCorner(size - kN, size - kN);
}

InertialPrior VisualInertialWindow::Prior() const {
  return {newest_, gravity_W_, time_offset_, T_BC_, calibration_covariance_, coupling_};
}

}  // namespace highwall
