#include "sensor/imu_alignment.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <highwall/core/so3.h>
#include <highwall/core/stamp.h>

namespace highwall {
namespace {

constexpr double kTurnSpan = 0.1,
                 kArc = 0.2;           // [s] of a rotation; of each half of a second difference
constexpr double kLongestStep = 0.15;  // [s] between poses that follow each other
// Errors of the pose of a good image: less is not believed of the residuals of a free fit, which
// follows the errors of a short recording.
constexpr double kRotationSigma = 4e-4, kPositionSigma = 1e-3;  // [rad], [m]
// What a right calibration leaves open, as standard deviations. Their priors weigh as much as the
// readings: however many there are, larger errors do not explain them.
constexpr double kMisalignment = 0.1;       // [rad]
constexpr double kAccelerometerBias = 0.5;  // [m/s^2]
constexpr double kLeverArm = 0.03;          // [m]
constexpr double kFree = 1e3, kFreeLeverArm = 10.0;

double TurnVariance() {
  return 2.0 * kRotationSigma * kRotationSigma;
}

// Returns the rotation R that maximizes the trace of R^T M.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d sign = Eigen::Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

double ArcVariance() {
  return 6.0 * kPositionSigma * kPositionSigma / (kArc * kArc);
}

}  // namespace

void GyroscopeFit::Add(const Eigen::Vector3d& camera, const Eigen::Vector3d& body,
                       double duration) {
  ++n_;
  camera_camera_ += camera.squaredNorm();
  time_time_ += duration * duration;
  body_body_ += body * body.transpose();
  camera_body_ += camera * body.transpose();
  camera_time_ += duration * camera;
  body_time_ += duration * body;
}

Eigen::Matrix3d GyroscopeFit::BodyBody() const {
  return body_body_ - body_time_ * body_time_.transpose() / time_time_;
}

Eigen::Matrix3d GyroscopeFit::CameraBody() const {
  return camera_body_ - camera_time_ * body_time_.transpose() / time_time_;
}

double GyroscopeFit::Signal() const {
  return n_ > 0 ? camera_camera_ - camera_time_.squaredNorm() / time_time_ : 0.0;
}

double GyroscopeFit::Squared(const Eigen::Matrix3d& A) const {
  if (n_ == 0) return 0.0;
  const double squared = Signal() - 2.0 * (A.transpose() * CameraBody()).trace() +
                         (A * BodyBody() * A.transpose()).trace();
  return std::max(squared, 0.0);
}

Eigen::Matrix3d GyroscopeFit::Free() const {
  if (n_ == 0) return Eigen::Matrix3d::Identity();
  // Axes without rotation stay near zero.
  Eigen::Matrix3d B = BodyBody();
  B.diagonal().array() += 1e-9 * B.trace() + 1e-15;
  return B.ldlt().solve(CameraBody().transpose()).transpose();
}

Eigen::Matrix3d GyroscopeFit::Rotation() const {
  return n_ == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : NearestRotation(CameraBody());
}

Eigen::Matrix3d GyroscopeFit::RotationNear(const Eigen::Matrix3d& A0, double weight) const {
  return n_ == 0 ? A0 : NearestRotation(CameraBody() + weight * A0);
}

double GyroscopeFit::Variance() const {
  constexpr int kUnknowns = 12;
  const int dof = 3 * n_ - kUnknowns;
  return dof > 0 ? std::max(Squared(Free()) / dof, TurnVariance()) : TurnVariance();
}

void AccelerometerFit::Add(const Eigen::Vector3d& y, const Row& X, double weight) {
  ++n_;
  weight_ += weight;
  y_ += y;
  yy_ += y.squaredNorm();
  H_.noalias() += X.transpose() * X;
  v_.noalias() += X.transpose() * y;
}

double AccelerometerFit::Signal() const {
  return n_ > 0 ? std::max(yy_ - y_.squaredNorm() / n_, 0.0) : 0.0;
}

AccelerometerFit::Solution AccelerometerFit::Solve(const Eigen::Matrix<double, kUnknowns, 1>& start,
                                                   const Eigen::MatrixXd& basis,
                                                   const Eigen::VectorXd& sigma) const {
  const Eigen::Matrix<double, kUnknowns, 1> slope = v_ - H_ * start;
  Eigen::MatrixXd H = basis.transpose() * H_ * basis;
  H.diagonal() += std::max(n_, 1) * ArcVariance() * sigma.cwiseAbs2().cwiseInverse();
  const Eigen::VectorXd v = basis.transpose() * slope;
  const Eigen::VectorXd x = H.ldlt().solve(v);
  const double squared = yy_ - start.dot(v_ + slope) - v.dot(x);
  return {std::max(squared, 0.0), start + basis * x};
}

AccelerometerFit::Solution AccelerometerFit::Near(const Eigen::Matrix3d& A,
                                                  const Eigen::Vector3d& lever_arm,
                                                  double lever_sigma) const {
  constexpr int kRest = 3, kOpen = 12;  // l, g, b
  Eigen::Matrix<double, kUnknowns, 1> start = Eigen::Matrix<double, kUnknowns, 1>::Zero();
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(kUnknowns, kOpen);
  const auto put = [](const Eigen::Matrix3d& M, auto column) {
    for (int row = 0; row < 3; ++row) {
      column.template segment<3>(3 * row) = M.row(row).transpose();
    }
  };
  put(A, start.col(0));
  start.segment<3>(9) = lever_arm;
  for (int axis = 0; axis < 3; ++axis) {
    put(so3::Hat(Eigen::Vector3d::Unit(axis)) * A, basis.col(axis));
  }
  basis.block<9, 9>(9, kRest).setIdentity();
  Eigen::VectorXd sigma(kOpen);
  sigma << Eigen::Vector3d::Constant(kMisalignment), Eigen::Vector3d::Constant(lever_sigma),
      Eigen::Vector3d::Constant(kFree), Eigen::Vector3d::Constant(kAccelerometerBias);
  return Solve(start, basis, sigma);
}

double AccelerometerFit::Squared(const Eigen::Matrix3d& A, const Eigen::Vector3d& lever_arm,
                                 double lever_sigma) const {
  return Near(A, lever_arm, lever_sigma).squared;
}

Eigen::Matrix<double, AccelerometerFit::kUnknowns, 1> AccelerometerFit::Unknowns(
    const Eigen::Matrix3d& A, const Eigen::Vector3d& lever_arm) const {
  return Near(A, lever_arm, kLeverArm).x;
}

Eigen::Vector3d AccelerometerFit::LeverArm(const Eigen::Matrix3d& A) const {
  return Near(A, Eigen::Vector3d::Zero(), kFreeLeverArm).x.segment<3>(9);
}

double AccelerometerFit::FreeSquared() const {
  Eigen::VectorXd sigma(kUnknowns);
  sigma << Eigen::Matrix<double, 9, 1>::Constant(kFree), Eigen::Vector3d::Constant(kFreeLeverArm),
      Eigen::Vector3d::Constant(kFree), Eigen::Vector3d::Constant(kAccelerometerBias);
  return Solve(Eigen::Matrix<double, kUnknowns, 1>::Zero(),
               Eigen::MatrixXd::Identity(kUnknowns, kUnknowns), sigma)
      .squared;
}

double AccelerometerFit::Variance() const {
  // Second differences of 0.4 s each 0.1 s share poses: half of them count.
  const double dof = 1.5 * n_ - kUnknowns;
  return dof > 0.0 ? std::max(FreeSquared() / (2.0 * dof), ArcVariance()) : ArcVariance();
}

ImuAlignment::ImuAlignment(const Trajectory& poses, std::span<const ImuSample> readings,
                           double max_step, double gyroscope_range, double accelerometer_range) {
  if (readings.empty()) return;
  const Stamp origin = readings.front().stamp;
  for (const StampedPose& pose : poses) {
    poses_.push_back({ToSeconds(pose.stamp - origin), pose.pose.R(), pose.pose.p()});
  }
  const auto is_saturated = [&](const ImuSample& s) {
    return s.gyroscope.cwiseAbs().maxCoeff() >= 0.999 * gyroscope_range ||
           s.accelerometer.cwiseAbs().maxCoeff() >= 0.999 * accelerometer_range;
  };
  Vector6 sum = Vector6::Zero();
  int bad = 0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (i > 0) {
      const double step = ToSeconds(readings[i].stamp - readings[i - 1].stamp);
      sum.head<3>() += 0.5 * step * (readings[i - 1].gyroscope + readings[i].gyroscope);
      sum.tail<3>() += 0.5 * step * (readings[i - 1].accelerometer + readings[i].accelerometer);
      if (step > max_step || is_saturated(readings[i])) ++bad;
    }
    times_.push_back(ToSeconds(readings[i].stamp - origin));
    integrals_.push_back(sum);
    bad_.push_back(bad);
  }
}

double ImuAlignment::duration() const {
  return poses_.empty() ? 0.0 : poses_.back().time - poses_.front().time;
}

double ImuAlignment::middle() const {
  return poses_.empty() ? 0.0 : 0.5 * (poses_.front().time + poses_.back().time);
}

ImuAlignment::Vector6 ImuAlignment::IntegralAt(std::size_t after, double time) const {
  const double share = (time - times_[after - 1]) / (times_[after] - times_[after - 1]);
  return integrals_[after - 1] + share * (integrals_[after] - integrals_[after - 1]);
}

std::optional<ImuAlignment::Vector6> ImuAlignment::Between(double begin, double end,
                                                           const ClockRelation& clock) const {
  const double from = clock.rate * begin + clock.offset, to = clock.rate * end + clock.offset;
  if (times_.size() < 2 || from < times_.front() || to >= times_.back()) return std::nullopt;
  const auto first = std::upper_bound(times_.begin(), times_.end(), from);
  const auto last = std::upper_bound(first, times_.end(), to);
  const auto i = static_cast<std::size_t>(first - times_.begin());
  const auto j = static_cast<std::size_t>(last - times_.begin());
  if (bad_[j] != bad_[i - 1]) return std::nullopt;
  // Per second of the camera.
  return (IntegralAt(j, to) - IntegralAt(i, from)) / clock.rate;
}

std::size_t ImuAlignment::After(std::size_t i, double span) const {
  constexpr double kRounding = 1e-3;  // [s]
  for (std::size_t j = i + 1; j < poses_.size(); ++j) {
    if (poses_[j].time - poses_[j - 1].time > kLongestStep) break;
    if (poses_[j].time - poses_[i].time > span - kRounding) return j;
  }
  return poses_.size();
}

std::vector<ImuAlignment::Turn> ImuAlignment::Turns(const ClockRelation& clock) const {
  std::vector<Turn> turns;
  for (std::size_t i = 0; i < poses_.size();) {
    const std::size_t j = After(i, kTurnSpan);
    if (j == poses_.size()) {
      ++i;
      continue;
    }
    const auto body = Between(poses_[i].time, poses_[j].time, clock);
    if (body && !poses_[i].skips_turn) {
      const Eigen::Matrix3d turn = poses_[i].R_WC.transpose() * poses_[j].R_WC;
      turns.push_back({i, so3::Log(Eigen::Quaterniond(turn)), body->head<3>(),
                       poses_[j].time - poses_[i].time});
    }
    i = j;
  }
  return turns;
}

std::vector<ImuAlignment::Interval> ImuAlignment::Intervals(const ClockRelation& clock) const {
  const Eigen::Matrix3d A = Gyroscope(clock).Free();
  std::vector<Interval> intervals;
  for (std::size_t i = 0; i + 1 < poses_.size(); ++i) {
    const CameraPose &a = poses_[i], &b = poses_[i + 1];
    const double duration = b.time - a.time;
    const auto body = Between(a.time, b.time, clock);
    if (!body || duration <= 0.0) {
      intervals.push_back({});
      continue;
    }
    const Eigen::Vector3d turn =
        so3::Log(Eigen::Quaterniond(Eigen::Matrix3d(a.R_WC.transpose() * b.R_WC)));
    intervals.push_back(
        {true, 0.5 * (a.time + b.time), duration, a.R_WC * so3::Exp(0.5 * turn).toRotationMatrix(),
         so3::Exp(A * body->head<3>()).toRotationMatrix(), body->tail<3>() / duration});
  }
  return intervals;
}

std::optional<ImuAlignment::Arc> ImuAlignment::ArcOf(std::size_t i, std::size_t j, std::size_t k,
                                                     std::span<const Interval> intervals) const {
  const CameraPose &a = poses_[i], &b = poses_[j], &c = poses_[k];
  const double before = b.time - a.time, after = c.time - b.time;
  Arc arc{.pose = i, .y = (c.p_WC - b.p_WC) / after - (b.p_WC - a.p_WC) / before};
  Eigen::Matrix3d to_b = Eigen::Matrix3d::Identity(), from_b = to_b;  // rotations a to b, b to c
  for (std::size_t m = i; m < k; ++m) {
    const Interval& interval = intervals[m];
    if (!interval.usable) return std::nullopt;
    const double w = interval.duration * (m < j ? (interval.middle - a.time) / before
                                                : (c.time - interval.middle) / after);
    for (int axis = 0; axis < 3; ++axis) {
      arc.X.middleCols<3>(3 * axis) += w * interval.R_WC.col(axis) * interval.force.transpose();
    }
    arc.X.rightCols<3>() += w * interval.R_WC;
    arc.weight += w;
    (m < j ? to_b : from_b) *= interval.turn;
  }
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  arc.X.middleCols<3>(9) = b.R_WC * ((from_b - I) / after - (I - to_b.transpose()) / before);
  arc.X.middleCols<3>(12) = arc.weight * I;
  return arc;
}

std::vector<ImuAlignment::Arc> ImuAlignment::Arcs(const ClockRelation& clock) const {
  const std::vector<Interval> intervals = Intervals(clock);
  std::vector<Arc> arcs;
  for (std::size_t i = 0; i < poses_.size();) {
    const std::size_t j = After(i, kArc);
    const std::size_t k = j < poses_.size() ? After(j, kArc) : j;
    if (k < poses_.size() && !poses_[i].skips_arc) {
      if (const auto arc = ArcOf(i, j, k, intervals)) arcs.push_back(*arc);
    }
    const std::size_t next = After(i, kTurnSpan);
    i = next < poses_.size() ? next : i + 1;
  }
  return arcs;
}

GyroscopeFit ImuAlignment::Gyroscope(const ClockRelation& clock) const {
  GyroscopeFit fit;
  for (const Turn& turn : Turns(clock)) fit.Add(turn.camera, turn.body, turn.duration);
  return fit;
}

AccelerometerFit ImuAlignment::Accelerometer(const ClockRelation& clock) const {
  AccelerometerFit fit;
  for (const Arc& arc : Arcs(clock)) fit.Add(arc.y, arc.X, arc.weight);
  return fit;
}

void ImuAlignment::Trim(const Eigen::Matrix3d& A, const Eigen::Vector3d& lever_arm,
                        const ClockRelation& clock) {
  constexpr double kTurns = 0.1, kArcs = 0.2;       // four arcs overlap: a shock is in all of them
  using Residual = std::pair<double, std::size_t>;  // squared, pose
  const auto worst = [](std::vector<Residual> residuals, double share) {
    std::ranges::sort(residuals, std::greater{});
    residuals.resize(
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(residuals.size()))));
    return residuals;
  };
  std::vector<Residual> of_turns, of_arcs;
  for (const Turn& turn : Turns(clock)) {
    of_turns.emplace_back((turn.camera - A * turn.body).squaredNorm(), turn.pose);
  }
  const Eigen::Matrix<double, AccelerometerFit::kUnknowns, 1> x =
      Accelerometer(clock).Unknowns(A, lever_arm);
  for (const Arc& arc : Arcs(clock)) {
    of_arcs.emplace_back((arc.y - arc.X * x).squaredNorm(), arc.pose);
  }
  for (const Residual& turn : worst(of_turns, kTurns)) poses_[turn.second].skips_turn = true;
  for (const Residual& arc : worst(of_arcs, kArcs)) poses_[arc.second].skips_arc = true;
}

}  // namespace highwall
