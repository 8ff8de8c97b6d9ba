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

// Returns the scale of residuals for the inlier test: bounds are those of the a priori noise, or
// wider if the estimated noise is larger: noise learnt on images with many features must not reject
// those of images with few.
Eigen::Vector2d Judged(const NoiseFactors& noise) {
  return {std::min(1.0, static_cast<double>(noise.px)),
          std::min(1.0, static_cast<double>(noise.depth))};
}

// The functor of ceres::TinySolver: rows of all inliers as a function of the tangent step x away
// from `T_start`.
class PoseProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  PoseProblem(const Pose& T_start, const RgbdProjection& projection,
              std::span<const PosePoint> points, std::span<const PoseLine> lines,
              const PoseSolverOptions& options, const PoseConstraint* known,
              std::span<const PointToPlaneRow> planes)
      : T_start_(T_start),
        projection_(projection),
        points_(points),
        lines_(lines),
        options_(options),
        known_(known),
        planes_(planes),
        point_rows_(points.size(), 0),
        line_active_(lines.size(), true),
        plane_active_(planes.size(), true) {}

  // The last row is the missing cost of robust rows.
  int NumResiduals() const {
    return 3 * active_points_ + 4 * active_lines_ + active_planes_ + (known_ != nullptr ? 6 : 0) +
           1;
  }

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    const Vector6 step = Eigen::Map<const Vector6>(x);
    if (!step.allFinite()) return false;
    const Pose T = T_start_.Plus(step);
    const RgbdProjection::View view = RgbdProjection::At(T.data());
    const Eigen::Matrix3d step_jacobian = so3::RightJacobian(step.tail<3>());

    Output out(residuals, jacobian, NumResiduals(), step_jacobian);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (point_rows_[i] == 0) continue;
      Eigen::Vector3d r;
      Eigen::Matrix<double, 3, 6> J;
      if (!PointRows(view, i, r, jacobian != nullptr ? &J : nullptr)) {
        r.x() = WorstInlier(points_[i].dimension);
      }
      out.Append<3>(r, J, options_.point_huber);
    }
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (!line_active_[i]) continue;
      Eigen::Vector4d r;
      Eigen::Matrix<double, 4, 6> J;
      if (!LineRows(view, lines_[i], r, jacobian != nullptr ? &J : nullptr)) {
        r = WorstInlier(lines_[i].dimension) * Eigen::Vector4d::UnitX();
        J.setZero();
      }
      out.Append<4>(r, J, options_.line_huber);
    }
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
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (point_rows_[i] == 0) continue;
      Eigen::Vector3d r;
      Eigen::Matrix<double, 3, 6> J;
      PointRows(view, i, r, &J);
      add(r, J, point_rows_[i]);
    }
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (!line_active_[i]) continue;
      Eigen::Vector4d r;
      Eigen::Matrix<double, 4, 6> J;
      LineRows(view, lines_[i], r, &J);
      add(r, J, lines_[i].dimension);
    }
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      if (!plane_active_[i]) continue;
      Eigen::Matrix<double, 1, 6> J;
      const double r = PlaneRow(view, planes_[i], &J);
      add(Eigen::Matrix<double, 1, 1>(r), J, 1);
    }
    if (rows > 6) solution.error = squares / (rows - 6);
  }

  // Classifies inliers at T; former outliers may become inliers of the next round. With
  // pixels_first, a point whose depth alone is inconsistent is kept without it.
  void Classify(const Pose& T) {
    const RgbdProjection::View view = RgbdProjection::At(T.data());
    active_points_ = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Eigen::Vector3d r;
      point_rows_[i] = points_[i].dimension;
      const double bound = options_.inliers.Of(points_[i].dimension);
      const bool inside = PointRows(view, i, r, nullptr);
      const Eigen::Vector2d judged = Judged(points_[i].noise);
      r.head<2>() *= judged[0];
      r[2] *= judged[1];
      if (!inside || r.squaredNorm() > bound) {
        const bool pixel_fits = inside && r.head<2>().squaredNorm() <= options_.inliers.Of(2);
        point_rows_[i] = pixels_first_ && pixel_fits ? 2 : 0;
      }
      active_points_ += point_rows_[i] > 0 ? 1 : 0;
    }
    active_lines_ = 0;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      Eigen::Vector4d r;
      const double bound = options_.inliers.Of(lines_[i].dimension);
      const Eigen::Vector2d judged = Judged(lines_[i].noise);
      line_active_[i] = LineRows(view, lines_[i], r, nullptr) &&
                        r.cwiseProduct(judged.replicate<2, 1>()).squaredNorm() <= bound;
      active_lines_ += line_active_[i] ? 1 : 0;
    }
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
    std::transform(points_.begin(), points_.end(), point_rows_.begin(),
                   [&](const PosePoint& point) { return pixels_first ? 2 : point.dimension; });
    std::fill(line_active_.begin(), line_active_.end(), true);
    std::fill(plane_active_.begin(), plane_active_.end(), true);
    active_points_ = static_cast<int>(points_.size());
    active_lines_ = static_cast<int>(lines_.size());
    active_planes_ = static_cast<int>(planes_.size());
  }

  int CurrentSupport() const { return Support(active_points_, active_lines_); }
  int active_points() const { return active_points_; }
  int active_lines() const { return active_lines_; }
  int active_planes() const { return active_planes_; }
  std::vector<bool> PointActive() const {
    std::vector<bool> active;
    for (const int rows : point_rows_) active.push_back(rows > 0);
    return active;
  }
  const std::vector<bool>& line_active() const { return line_active_; }

  // Returns the median of z in C; for a line, of its midpoint.
  double Depth(const Pose& T) const {
    const Pose T_CW = T.Inverse();
    std::vector<double> depths;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (point_rows_[i] > 0) depths.push_back((T_CW * points_[i].p_W).z());
    }
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (!line_active_[i]) continue;
      const Segment3& segment_W = lines_[i].segment_W;
      depths.push_back((T_CW * Eigen::Vector3d(0.5 * (segment_W.p() + segment_W.q()))).z());
    }
    return depths.empty() ? 0.0 : UpperMedian(std::move(depths));
  }

 private:
  // Cost outside the domain, that of the worst inlier: all rows are in their domain where a round
  // begins. If it were lower, a step past all landmarks would be the best fit.
  double WorstInlier(int dimension) const { return std::sqrt(options_.inliers.Of(dimension)); }

  // Returns zero rows and false outside the domain; the row of an unused depth is zero.
  bool PointRows(const RgbdProjection::View& view, std::size_t i, Eigen::Vector3d& r,
                 Eigen::Matrix<double, 3, 6>* J) const {
    const PosePoint& point = points_[i];
    const bool inside = projection_.Evaluate<3>(view, point.rows, point.p_W, &r, J, nullptr);
    if (!inside) r.setZero();
    if (!inside && J != nullptr) J->setZero();
    if (point_rows_[i] == 2) r.z() = 0.0;
    if (point_rows_[i] == 2 && J != nullptr) J->row(2).setZero();
    return inside;
  }

  bool LineRows(const RgbdProjection::View& view, const PoseLine& line, Eigen::Vector4d& r,
                Eigen::Matrix<double, 4, 6>* J) const {
    bool inside = true;
    for (int end = 0; end < 2; ++end) {
      const Eigen::Vector3d p_W = end == 0 ? line.segment_W.p() : line.segment_W.q();
      Eigen::Vector2d r_end;
      Eigen::Matrix<double, 2, 6> J_end;
      if (!projection_.Evaluate<2>(view, line.rows[static_cast<std::size_t>(end)], p_W, &r_end,
                                   J != nullptr ? &J_end : nullptr, nullptr)) {
        r_end.setZero();
        J_end.setZero();
        inside = false;
      }
      r.segment<2>(2 * end) = r_end;
      if (J != nullptr) J->middleRows<2>(2 * end) = J_end;
    }
    return inside;
  }

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
  std::span<const PosePoint> points_;
  std::span<const PoseLine> lines_;
  const PoseSolverOptions& options_;
  const PoseConstraint* known_;
  std::span<const PointToPlaneRow> planes_;
  bool pixels_first_ = false;
  std::vector<int> point_rows_;  // 0: outlier, 2: without depth, 3: with depth
  std::vector<bool> line_active_, plane_active_;
  int active_points_ = 0, active_lines_ = 0, active_planes_ = 0;
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
  solution.point_inliers = problem.PointActive();
  solution.line_inliers = problem.line_active();
  solution.num_points = problem.active_points();
  solution.num_lines = problem.active_lines();
  solution.num_planes = problem.active_planes();
  solution.depth = problem.Depth(T_WC);
  return solution;
}

}  // namespace

std::optional<PoseSolution> SolvePose(const Pose& T_WC, const RgbdProjection& projection,
                                      std::span<const PosePoint> points,
                                      std::span<const PoseLine> lines,
                                      const PoseSolverOptions& options, const PoseConstraint* known,
                                      std::span<const PointToPlaneRow> planes) {
  PoseProblem problem(T_WC, projection, points, lines, options, known, planes);
  for (const bool pixels_first : {false, true}) {
    if (pixels_first && points.empty()) break;
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
