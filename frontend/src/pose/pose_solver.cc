#include <highwall/frontend/pose/pose_solver.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <ceres/tiny_solver.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/internal/median.h>

#include "pose/support.h"

namespace highwall {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Scaling of rows r with Jacobian J by which least squares minimizes the Huber cost rho(|r|^2):
// both are scaled by `factor`, and the square of `missing` is added to the cost. Cost and gradient
// are then those of rho, and J^T J is weighted as in iteratively reweighted least squares. (Scaling
// r to |r|^2 = rho alone would halve J^T J for large residuals, and steps would be twice too long.)
struct HuberWeight {
  double factor = 1.0;
  double missing_squared = 0.0;
};

HuberWeight WeighHuber(double squared_norm, double threshold) {
  if (squared_norm <= threshold * threshold) return {};
  const double norm = std::sqrt(squared_norm);
  return {std::sqrt(threshold / norm), threshold * (norm - threshold)};
}

// Output of residuals and Jacobian of a pose-only problem, row by row, with robust weights.
class Output {
 public:
  // jacobian: column-major, rows x 6, or null. step_jacobian: from the tangent at the stepped pose,
  // of the rows' derivatives, to the tangent where the step begins, of the unknowns.
  Output(double* residuals, double* jacobian, int rows, const Eigen::Matrix3d& step_jacobian)
      : r_(residuals, rows),
        J_(jacobian, jacobian != nullptr ? rows : 0, 6),
        step_jacobian_(step_jacobian) {}

  template <int kRows>
  void Append(const Eigen::Matrix<double, kRows, 1>& r, const Eigen::Matrix<double, kRows, 6>& J,
              double huber) {
    const HuberWeight weight = WeighHuber(r.squaredNorm(), huber);
    missing_squared_ += weight.missing_squared;
    r_.segment<kRows>(row_) = weight.factor * r;
    if (J_.rows() > 0) {
      auto rows = J_.middleRows<kRows>(row_);
      rows.template leftCols<3>() = weight.factor * J.template leftCols<3>();
      rows.template rightCols<3>().noalias() =
          (weight.factor * J.template rightCols<3>()) * step_jacobian_;
    }
    row_ += kRows;
  }

  // Adds the last row; returns false if a residual is not finite.
  bool Finish() {
    r_[row_] = std::sqrt(missing_squared_);
    if (J_.rows() > 0) J_.row(row_).setZero();
    return r_.allFinite();
  }

 private:
  Eigen::Map<Eigen::VectorXd> r_;
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6>> J_;
  const Eigen::Matrix3d& step_jacobian_;
  Eigen::Index row_ = 0;
  double missing_squared_ = 0.0;
};

// The functor of ceres::TinySolver: rows of all inliers as a function of the tangent step x away
// from `T_start`.
class PoseProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  PoseProblem(const Pose& T_start, const RgbdProjection& projection,
              const PerKind<PoseObservations>& seen, const PoseSolverOptions& options,
              const PoseConstraint* known, std::span<const PointToPlaneRow> planes)
      : T_start_(T_start),
        projection_(projection),
        seen_(seen),
        options_(options),
        known_(known),
        planes_(planes),
        plane_active_(planes.size(), true) {
    ForEachKind([&]<class Landmark>() {
      PartOf<Landmark>(used_).assign(PartOf<Landmark>(seen_).size(), 0);
    });
  }

  // The last row is the missing cost of robust rows.
  int NumResiduals() const {
    int rows = active_planes_ + (known_ != nullptr ? 6 : 0) + 1;
    ForEachKind([&]<class Landmark>() {
      rows += PoseTraits<Landmark>::Observation::kRows * PartOf<Landmark>(active_);
    });
    return rows;
  }

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    const Vector6 step = Eigen::Map<const Vector6>(x);
    if (!step.allFinite()) return false;
    const Pose T = T_start_.Plus(step);
    const RgbdProjection::View view = RgbdProjection::At(T.data());
    const Eigen::Matrix3d step_jacobian = so3::RightJacobian(step.tail<3>());

    Output out(residuals, jacobian, NumResiduals(), step_jacobian);
    ForEachKind([&]<class Landmark>() {
      using Observation = typename PoseTraits<Landmark>::Observation;
      constexpr int kRows = Observation::kRows;
      const PoseObservations<Landmark>& seen = PartOf<Landmark>(seen_);
      const std::vector<int>& used = PartOf<Landmark>(used_);
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (used[i] == 0) continue;
        Eigen::Matrix<double, kRows, 1> r;
        Eigen::Matrix<double, kRows, 6> J;
        if (!seen[i].Evaluate(projection_, view, used[i], &r, jacobian != nullptr ? &J : nullptr)) {
          r[0] = WorstInlier(seen[i].dimension);
        }
        out.Append<kRows>(r, J, Observation::Huber(options_));
      }
    });
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      if (!plane_active_[i]) continue;
      Eigen::Matrix<double, 1, 6> J;
      const double r = PlaneRow(view, planes_[i], jacobian != nullptr ? &J : nullptr);
      out.Append<1>(Eigen::Matrix<double, 1, 1>(r), J, options_.plane_huber);
    }
    if (known_ != nullptr) AppendKnown(T, out);
    return out.Finish();
  }

  // Computes information, gradient and error from the inliers at the solution's pose.
  void Sum(PoseSolution& solution) const {
    const RgbdProjection::View view = RgbdProjection::At(solution.T_WC.data());
    int rows = 0;
    double squares = 0.0;
    const auto add = [&](const auto& r, const auto& J, int dimension) {
      solution.information.noalias() += J.transpose() * J;
      solution.gradient.noalias() += J.transpose() * r;
      squares += r.squaredNorm();
      rows += dimension;
    };
    ForEachKind([&]<class Landmark>() {
      constexpr int kRows = PoseTraits<Landmark>::Observation::kRows;
      const PoseObservations<Landmark>& seen = PartOf<Landmark>(seen_);
      const std::vector<int>& used = PartOf<Landmark>(used_);
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (used[i] == 0) continue;
        Eigen::Matrix<double, kRows, 1> r;
        Eigen::Matrix<double, kRows, 6> J;
        seen[i].Evaluate(projection_, view, used[i], &r, &J);
        add(r, J, used[i]);
      }
    });
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      if (!plane_active_[i]) continue;
      Eigen::Matrix<double, 1, 6> J;
      const double r = PlaneRow(view, planes_[i], &J);
      add(Eigen::Matrix<double, 1, 1>(r), J, 1);
    }
    if (rows > 6) solution.error = squares / (rows - 6);
  }

  // Classifies inliers at T; former outliers may become inliers of the next round.
  void Classify(const Pose& T) {
    const RgbdProjection::View view = RgbdProjection::At(T.data());
    ForEachKind([&]<class Landmark>() {
      const PoseObservations<Landmark>& seen = PartOf<Landmark>(seen_);
      int& active = PartOf<Landmark>(active_);
      active = 0;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        Eigen::Matrix<double, PoseTraits<Landmark>::Observation::kRows, 1> r;
        int& used = PartOf<Landmark>(used_)[i];
        used = seen[i].Evaluate(projection_, view, seen[i].dimension, &r, nullptr)
                   ? seen[i].InlierRows(r, options_.inliers, pixels_first_)
                   : 0;
        active += used > 0 ? 1 : 0;
      }
    });
    active_planes_ = 0;
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      const double r = PlaneRow(view, planes_[i], nullptr);
      plane_active_[i] = r * r <= options_.inliers.Of(1);
      active_planes_ += plane_active_[i] ? 1 : 0;
    }
  }

  void Restart(const Pose& T_start) { T_start_ = T_start; }
  // pixels_first: start without the depth of points.
  void ActivateAll(bool pixels_first) {
    pixels_first_ = pixels_first;
    ForEachKind([&]<class Landmark>() {
      const PoseObservations<Landmark>& seen = PartOf<Landmark>(seen_);
      std::ranges::transform(seen, PartOf<Landmark>(used_).begin(), [&](const auto& observation) {
        return observation.RowsAtStart(pixels_first);
      });
      PartOf<Landmark>(active_) = static_cast<int>(seen.size());
    });
    std::fill(plane_active_.begin(), plane_active_.end(), true);
    active_planes_ = static_cast<int>(planes_.size());
  }

  int CurrentSupport() const { return Support(active_); }
  int active_points() const { return active_.points; }
  int active_lines() const { return active_.lines; }
  int active_planes() const { return active_planes_; }
  PerKind<PoseInliers> Inliers() const {
    PerKind<PoseInliers> inliers;
    ForEachKind([&]<class Landmark>() {
      for (const int rows : PartOf<Landmark>(used_)) PartOf<Landmark>(inliers).push_back(rows > 0);
    });
    return inliers;
  }

  // Returns the median of z in C; for a line, of its midpoint.
  double Depth(const Pose& T) const {
    const Pose T_CW = T.Inverse();
    std::vector<double> depths;
    ForEachKind([&]<class Landmark>() {
      const PoseObservations<Landmark>& seen = PartOf<Landmark>(seen_);
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (PartOf<Landmark>(used_)[i] > 0) depths.push_back((T_CW * seen[i].Centre()).z());
      }
    });
    return depths.empty() ? 0.0 : UpperMedian(std::move(depths));
  }

 private:
  // Of each observation, the number of its rows that take part; 0 for an outlier.
  template <class Landmark>
  using UsedRows = std::vector<int>;

  // Cost outside the domain, that of the worst inlier: all rows are in their domain where a round
  // begins. If it were lower, a step past all landmarks would be the best fit.
  double WorstInlier(int dimension) const { return std::sqrt(options_.inliers.Of(dimension)); }

  static double PlaneRow(const RgbdProjection::View& view, const PointToPlaneRow& row,
                         Eigen::Matrix<double, 1, 6>* J) {
    return row.Evaluate(view.R_BW.transpose(), view.p_WB, J);
  }

  void AppendKnown(const Pose& T, Output& out) const {
    const Eigen::Vector3d theta = so3::Log(known_->T_WC.q().conjugate() * T.q());
    Vector6 e;
    e << T.p() - known_->T_WC.p(), theta;
    const Vector6 r = known_->sqrt_information * e;
    Matrix6 J = known_->sqrt_information;
    J.rightCols<3>() = J.rightCols<3>() * so3::RightJacobianInverse(theta);
    out.Append<6>(r, J, std::numeric_limits<double>::infinity());
  }

  Pose T_start_;
  const RgbdProjection& projection_;
  const PerKind<PoseObservations>& seen_;
  const PoseSolverOptions& options_;
  const PoseConstraint* known_;
  std::span<const PointToPlaneRow> planes_;
  bool pixels_first_ = false;
  PerKind<UsedRows> used_;
  PerKind<NumOfKind> active_{};
  std::vector<bool> plane_active_;
  int active_planes_ = 0;
};

// Solves round by round; empty if too few inliers remain.
std::optional<Pose> Solve(PoseProblem& problem, const Pose& T_WC,
                          const PoseSolverOptions& options) {
  ceres::TinySolver<PoseProblem> solver;
  // TinySolver counts the evaluation at the start as an iteration.
  solver.options.max_num_iterations = options.max_iterations + 1;
  solver.options.parameter_tolerance = 1e-7;
  solver.options.gradient_tolerance = 1e-6;

  // Absolute, of the sum of squares. The rounds before the last only classify inliers: a tenth of a
  // standard deviation suffices for that, but would leave a lag in the final pose.
  constexpr double kToClassify = 1e-2, kToEnd = 1e-6;

  Pose T = T_WC;
  for (int round = 0; round < options.rounds; ++round) {
    if (problem.CurrentSupport() < options.min_support) return std::nullopt;
    problem.Restart(T);
    solver.options.function_tolerance = round + 1 < options.rounds ? kToClassify : kToEnd;
    Vector6 x = Vector6::Zero();
    solver.Solve(problem, &x);
    if (!x.allFinite()) return std::nullopt;
    T = T.Plus(x);
    problem.Classify(T);
  }
  if (problem.CurrentSupport() < options.min_support) return std::nullopt;
  return T;
}

PoseSolution Solution(const PoseProblem& problem, const Pose& T_WC) {
  PoseSolution solution;
  solution.T_WC = T_WC;
  problem.Sum(solution);
  solution.inliers = problem.Inliers();
  solution.num_points = problem.active_points();
  solution.num_lines = problem.active_lines();
  solution.num_planes = problem.active_planes();
  solution.depth = problem.Depth(T_WC);
  return solution;
}

}  // namespace

std::optional<PoseSolution> SolvePose(const Pose& T_WC, const RgbdProjection& projection,
                                      const PerKind<PoseObservations>& seen,
                                      const PoseSolverOptions& options, const PoseConstraint* known,
                                      std::span<const PointToPlaneRow> planes) {
  PoseProblem problem(T_WC, projection, seen, options, known, planes);
  for (const bool pixels_first : {false, true}) {
    if (pixels_first && seen.points.empty()) break;
    problem.ActivateAll(pixels_first);
    if (const auto T = Solve(problem, T_WC, options)) return Solution(problem, *T);
  }
  return std::nullopt;
}

std::optional<Segment3> TrimToObservation(const PluckerLine& line_C, const Eigen::Vector2d& s,
                                          const Eigen::Vector2d& e, const RgbdProjection& camera) {
  const Eigen::Vector3d a = line_C.ClosestToOrigin(), d = line_C.d.normalized();
  // Point a + t d nearest to the ray through the origin along m.
  const auto nearest = [&](const Eigen::Vector2d& uv) -> std::optional<Eigen::Vector3d> {
    const Eigen::Vector3d m = Eigen::Vector3d((uv.x() - camera.cx()) / camera.fx(),
                                              (uv.y() - camera.cy()) / camera.fy(), 1.0)
                                  .normalized();
    const double cosine = m.dot(d);
    const double denominator = 1.0 - cosine * cosine;
    if (denominator < 1e-6) return std::nullopt;
    const Eigen::Vector3d p = a + d * (cosine * m.dot(a) / denominator);
    if (p.z() < camera.min_depth()) return std::nullopt;
    return p;
  };
  const auto p = nearest(s), q = nearest(e);
  if (!p || !q) return std::nullopt;
  return Segment3(*p, *q);
}

}  // namespace highwall
