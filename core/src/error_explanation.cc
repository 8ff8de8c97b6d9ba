#include <highwall/core/trajectory_error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/internal/number_text.h>

#include "trajectory_alignment.h"

namespace highwall {
namespace {

// Columns of the linear model: six of a global rotation and translation, then the causes.
constexpr int kTime = 6, kScale = 7, kLever = 8, kUnknowns = 11;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
constexpr int kIterations = 10;
constexpr double kMinInformation =
    1e-9;  // least eigenvalue of the scaled information of observable causes
constexpr double kVelocityStep =
    0.05;  // [s] to each side, to differentiate the position of the reference

// Selects the causes to be estimated.
struct Causes {
  bool time_shift = false, scale = false, lever_arm = false;

  std::vector<int> Columns() const {
    std::vector<int> columns{0, 1, 2, 3, 4, 5};
    if (time_shift) columns.push_back(kTime);
    if (scale) columns.push_back(kScale);
    if (lever_arm) columns.insert(columns.end(), {kLever, kLever + 1, kLever + 2});
    return columns;
  }
};

// Information matrix and right-hand side of a piece of the trajectory.
struct NormalEquations {
  Matrix H = Matrix::Zero();
  Vector b = Vector::Zero();
};

class Model {
 public:
  Model(const Trajectory& reference, const TrajectoryError& error,
        const ErrorExplanationOptions& options)
      : reference_(reference), error_(error), options_(options) {}

  // Returns the errors after correction of a cause, aligned anew; empty in a gap of the reference.
  std::vector<std::optional<Eigen::Vector3d>> Residuals(const ErrorCause& cause) const {
    return Evaluate(cause).residuals;
  }

  // Gauss-Newton; empty if the causes are not observable from the motion.
  std::optional<ErrorCause> Solve(const Causes& causes) const {
    ErrorCause cause;
    const std::vector<int> columns = causes.Columns();
    for (int i = 0; i < kIterations; ++i) {
      const std::optional<Vector> step = Step(Sum(Evaluate(cause).pieces), columns);
      if (!step) return std::nullopt;
      Apply(*step, &cause);
      if (std::abs(cause.time_shift) > options_.max_time_shift) return std::nullopt;
      if (step->tail<kUnknowns - kTime>().cwiseAbs().maxCoeff() < 1e-10) break;
    }
    const Evaluation last = Evaluate(cause);
    cause.rmse = Rms(last.residuals);
    Jackknife(last.pieces, columns, &cause);
    return cause;
  }

  static double Rms(const std::vector<std::optional<Eigen::Vector3d>>& residuals) {
    double squares = 0.0;
    int count = 0;
    for (const auto& r : residuals) {
      if (!r) continue;
      squares += r->squaredNorm();
      ++count;
    }
    return count > 0 ? std::sqrt(squares / count) : 0.0;
  }

 private:
  struct Evaluation {
    std::vector<std::optional<Eigen::Vector3d>> residuals;
    std::vector<NormalEquations> pieces;
  };

  // Empty in a gap of the reference.
  std::optional<Eigen::Vector3d> Reference(Stamp stamp) const {
    const auto after = std::ranges::lower_bound(reference_, stamp, {}, &StampedPose::stamp);
    if (after == reference_.end()) return std::nullopt;
    const bool in_between = after->stamp != stamp && after != reference_.begin();
    if (in_between && after->stamp - std::prev(after)->stamp > error_.max_gap) return std::nullopt;
    const std::optional<Pose> pose = Interpolate(reference_, stamp);
    return pose ? std::optional<Eigen::Vector3d>(pose->p()) : std::nullopt;
  }

  Evaluation Evaluate(const ErrorCause& cause) const {
    const std::size_t n = error_.estimate.size();
    const Stamp shift = FromSeconds(cause.time_shift), step = FromSeconds(kVelocityStep);
    Eigen::Matrix3Xd a(3, static_cast<Eigen::Index>(n)), b = a, velocity = a;
    std::vector<std::size_t> used;
    for (std::size_t i = 0; i < n; ++i) {
      const Stamp stamp = error_.estimate[i].stamp + shift;
      const auto at = Reference(stamp), before = Reference(stamp - step),
                 after = Reference(stamp + step);
      if (!at || !before || !after) continue;
      const auto k = static_cast<Eigen::Index>(used.size());
      const Pose& T = error_.estimate[i].pose;
      a.col(k) = *at;
      b.col(k) = cause.scale * T.p() + T.q() * cause.lever_arm;
      velocity.col(k) = (*after - *before) / (2.0 * kVelocityStep);
      used.push_back(i);
    }
    const auto count = static_cast<Eigen::Index>(used.size());
    HIGHWALL_REQUIRE(count >= 4 * options_.pieces,
                     std::to_string(count) +
                         " poses at stamps that the reference covers without a hole are too few "
                         "to explain the error: it takes " +
                         std::to_string(4 * options_.pieces));
    std::string none;  // sixteen positions without a scale always have an alignment
    const Similarity S =
        internal::AlignPositions(a.leftCols(count), b.leftCols(count), false, &none).value().S_AB;
    Evaluation result{std::vector<std::optional<Eigen::Vector3d>>(n),
                      std::vector<NormalEquations>(static_cast<std::size_t>(options_.pieces))};
    for (Eigen::Index k = 0; k < count; ++k) {
      const std::size_t i = used[static_cast<std::size_t>(k)];
      const Eigen::Vector3d p = S.T_AB * Eigen::Vector3d(b.col(k));
      const Eigen::Vector3d r = a.col(k) - p;
      const Pose& T = error_.estimate[i].pose;
      // r = rotation x p + translation - v d(shift) + d(scale) R p_estimate + R R_i d(lever).
      Eigen::Matrix<double, 3, kUnknowns> J;
      J << -so3::Hat(p), Eigen::Matrix3d::Identity(), -velocity.col(k), S.T_AB.q() * T.p(),
          S.T_AB.R() * T.R();
      result.residuals[i] = r;
      NormalEquations& piece = result.pieces[static_cast<std::size_t>(k * options_.pieces / count)];
      piece.H += J.transpose() * J;
      piece.b += J.transpose() * r;
    }
    return result;
  }

  static NormalEquations Sum(const std::vector<NormalEquations>& pieces) {
    NormalEquations sum;
    for (const NormalEquations& piece : pieces) {
      sum.H += piece.H;
      sum.b += piece.b;
    }
    return sum;
  }

  static std::optional<Vector> Step(const NormalEquations& normal,
                                    const std::vector<int>& columns) {
    const Eigen::MatrixXd H = normal.H(columns, columns);
    const Eigen::VectorXd unit = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = unit.asDiagonal() * H * unit.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled, Eigen::EigenvaluesOnly);
    if (!(eigen.eigenvalues()(0) > kMinInformation)) return std::nullopt;
    Vector step = Vector::Zero();
    step(columns) = unit.cwiseProduct(
        scaled.ldlt().solve(unit.cwiseProduct(Eigen::VectorXd(normal.b(columns)))));
    return step;
  }

  static void Apply(const Vector& step, ErrorCause* cause) {
    cause->time_shift += step(kTime);
    cause->scale += step(kScale);
    cause->lever_arm += step.segment<3>(kLever);
  }

  // Jackknife (Efron) over the pieces. Infinite if the causes are observable from one piece only.
  static void Jackknife(const std::vector<NormalEquations>& pieces, const std::vector<int>& columns,
                        ErrorCause* cause) {
    const NormalEquations all = Sum(pieces);
    std::vector<Vector> steps;
    for (const NormalEquations& piece : pieces) {
      const auto step = Step({all.H - piece.H, all.b - piece.b}, columns);
      steps.push_back(step.value_or(Vector::Constant(std::numeric_limits<double>::infinity())));
    }
    const auto n = static_cast<double>(steps.size());
    Vector mean = Vector::Zero(), squares = Vector::Zero();
    for (const Vector& step : steps) mean += step / n;
    for (const Vector& step : steps) squares += (step - mean).cwiseAbs2();
    Vector sigma = ((n - 1.0) / n * squares).cwiseSqrt();
    if (!mean.allFinite()) sigma.setConstant(std::numeric_limits<double>::infinity());
    cause->time_shift_sigma = sigma(kTime);
    cause->scale_sigma = sigma(kScale);
    cause->lever_arm_sigma = sigma.segment<3>(kLever);
  }

  const Trajectory& reference_;
  const TrajectoryError& error_;
  const ErrorExplanationOptions& options_;
};

// Splits the errors into their mean over a window around each, and the rest.
void SplitBySpeed(const std::vector<std::optional<Eigen::Vector3d>>& residuals,
                  const Trajectory& estimate, double seconds, ErrorExplanation* explanation) {
  const Stamp half = FromSeconds(0.5 * seconds);
  std::vector<std::optional<Eigen::Vector3d>> slow(residuals.size()), fast(residuals.size());
  std::size_t begin = 0, end = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  const auto add = [&](std::size_t i, int sign) {
    if (!residuals[i]) return;
    sum += sign * *residuals[i];
    count += sign;
  };
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    while (end < residuals.size() && estimate[end].stamp <= estimate[i].stamp + half) add(end++, 1);
    while (estimate[begin].stamp < estimate[i].stamp - half) add(begin++, -1);
    if (!residuals[i]) continue;
    slow[i] = sum / count;
    fast[i] = *residuals[i] - *slow[i];
  }
  explanation->slow = Model::Rms(slow);
  explanation->fast = Model::Rms(fast);
}

// Estimates the mean rotation from the estimate's to the reference's axes, and what remains.
void ExplainRotation(const TrajectoryError& error, int pieces, ErrorExplanation* explanation) {
  const std::size_t n = error.estimate.size();
  Eigen::Quaterniond mean = Eigen::Quaterniond::Identity();
  std::vector<Eigen::Vector3d> left(n);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      left[i] = so3::Log(mean.conjugate() * error.estimate[i].pose.q().conjugate() *
                         error.reference[i].pose.q());
      sum += left[i] / static_cast<double>(n);
    }
    if (iteration == 0) {
      double squares = 0.0;
      for (const Eigen::Vector3d& r : left) squares += r.squaredNorm();
      explanation->angle_rmse = std::sqrt(squares / static_cast<double>(n));
    }
    if (sum.norm() < 1e-12) break;
    mean = mean * so3::Exp(sum);
  }
  double squares = 0.0;
  std::vector<Eigen::Vector3d> means(static_cast<std::size_t>(pieces), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    squares += left[i].squaredNorm();
    const std::size_t piece = i * means.size() / n;
    means[piece] += left[i] * static_cast<double>(means.size()) / static_cast<double>(n);
  }
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& m : means) variance += m.cwiseAbs2();
  explanation->hand_eye = so3::Log(mean);
  explanation->hand_eye_sigma = (variance / (pieces * (pieces - 1.0))).cwiseSqrt();
  explanation->angle_rmse_without = std::sqrt(squares / static_cast<double>(n));
}

}  // namespace

void ErrorExplanationOptions::Validate() const {
  HIGHWALL_REQUIRE(
      slow_seconds > 0.0 && std::isfinite(slow_seconds),
      "ErrorExplanationOptions::slow_seconds must be positive, is " + FixedText(slow_seconds));
  HIGHWALL_REQUIRE(
      max_time_shift > 0.0 && std::isfinite(max_time_shift),
      "ErrorExplanationOptions::max_time_shift must be positive, is " + FixedText(max_time_shift));
  HIGHWALL_REQUIRE(pieces >= 4, "ErrorExplanationOptions::pieces must be at least 4, is " +
                                    std::to_string(pieces));
}

ErrorExplanation ExplainError(const Trajectory& reference, const TrajectoryError& error,
                              const ErrorExplanationOptions& options) {
  options.Validate();
  HIGHWALL_REQUIRE(error.scale == 1.0,
                   "the error of an estimate that was scaled cannot be explained");
  const Model model(reference, error, options);
  ErrorExplanation explanation;
  const auto as_it_is = model.Residuals({});
  explanation.rmse = Model::Rms(as_it_is);
  explanation.time_shift = model.Solve({.time_shift = true});
  explanation.scale = model.Solve({.scale = true});
  explanation.time_shift_and_scale = model.Solve({.time_shift = true, .scale = true});
  explanation.lever_arm = model.Solve({.lever_arm = true});
  explanation.all = model.Solve({.time_shift = true, .scale = true, .lever_arm = true});
  SplitBySpeed(as_it_is, error.estimate, options.slow_seconds, &explanation);
  ExplainRotation(error, options.pieces, &explanation);
  const auto& best = explanation.all ? explanation.all : explanation.time_shift_and_scale;
  for (const auto& r : best ? model.Residuals(*best) : as_it_is) {
    explanation.left.push_back(r ? r->norm() : std::numeric_limits<double>::quiet_NaN());
  }
  return explanation;
}

}  // namespace highwall
