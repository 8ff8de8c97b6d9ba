#include <highwall/frontend/pose/pose_solver.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include <ceres/tiny_solver.h>
#include <Eigen/Cholesky>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/internal/median.h>

#include "pose/pose_rows.h"
#include "pose/support.h"

namespace highwall {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// J^T J and J^T r of all rows, in the tangent of PoseManifold.
struct NormalEquations {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();

  template <int kRows>
  void Add(const Eigen::Matrix<double, kRows, 1>& r, const Eigen::Matrix<double, kRows, 6>& J,
           double weight) {
    H.noalias() += weight * J.transpose() * J;
    g.noalias() += weight * J.transpose() * r;
  }
  // M: Jacobian of their unknowns by others, block-diagonal.
  void ChangeUnknowns(const Eigen::Matrix3d& M_p, const Eigen::Matrix3d& M_theta) {
    Matrix6 M = Matrix6::Zero();
    M.topLeftCorner<3, 3>() = M_p;
    M.bottomRightCorner<3, 3>() = M_theta;
    H = (M.transpose() * H * M).eval();
    g = (M.transpose() * g).eval();
  }
};

// The problem that ceres::TinySolver is given instead of J and r, which have a row for each
// measurement: R and R^-T J^T r with J^T J = R^T R, and the remaining cost in a last row. Cost,
// gradient and J^T J are the same.
struct SquareRoot {
  Eigen::Matrix<double, 7, 6> J = Eigen::Matrix<double, 7, 6>::Zero();
  Eigen::Matrix<double, 7, 1> r = Eigen::Matrix<double, 7, 1>::Zero();

  SquareRoot(const NormalEquations& normal, double cost) {
    // Pivots below this share of the diagonal are rounding: the direction is unobservable.
    constexpr double kLeastPivot = 1e-14;
    const Eigen::LDLT<Matrix6> ldlt(normal.H);  // P^T L D L^T P
    const Vector6 pivots = ldlt.vectorD();
    const Vector6 diagonal = ldlt.transpositionsP() * Vector6(normal.H.diagonal());
    const Vector6 reduced = ldlt.matrixL().solve(Vector6(ldlt.transpositionsP() * normal.g));
    Vector6 root = Vector6::Zero();
    for (int i = 0; i < 6; ++i) {
      if (pivots[i] <= kLeastPivot * diagonal[i]) continue;
      root[i] = std::sqrt(pivots[i]);
      r[i] = reduced[i] / root[i];
    }
    const Matrix6 P = ldlt.transpositionsP() * Matrix6::Identity();
    J.topRows<6>() = root.asDiagonal() * (ldlt.matrixU() * P).eval();
    const double rest = cost - r.squaredNorm();
    r[6] = rest < 0.0 ? 0.0 : std::sqrt(rest);
  }
};

// The functor of ceres::TinySolver: cost and normal equations of all inliers as a function of the
// tangent step x away from `T_start`.
class PoseProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = 7, NUM_PARAMETERS = 6 };

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
      const PoseObservations<Landmark>& of_kind = PartOf<Landmark>(seen_);
      PartOf<Landmark>(used_).assign(of_kind.size(), 0);
      RowsOf<Landmark>& rows = PartOf<Landmark>(rows_);
      rows.Reset(of_kind.size(), projection);
      for (std::size_t i = 0; i < of_kind.size(); ++i) {
        for (int end = 0; end < PoseTraits<Landmark>::Observation::kEnds; ++end) {
          rows.Set(i, end, of_kind[i].End(end), of_kind[i].RowsOf(end));
        }
        // The cost outside of the domain is that of the worst inlier: all rows are in their domain
        // where a round begins. If it were lower, a step past all landmarks would be the best fit.
        rows.SetWorst(i, std::sqrt(options.inliers.Of(of_kind[i].dimension)));
      }
    });
  }

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    const Vector6 step = Eigen::Map<const Vector6>(x);
    Eigen::Map<Eigen::Matrix<double, 7, 1>> r(residuals);
    if (!step.allFinite()) {
      r.setConstant(std::numeric_limits<double>::quiet_NaN());
      return false;
    }
    const Pose T = step.isZero(0.0) ? T_start_ : T_start_.Plus(step);
    NormalEquations normal;
    NormalEquations* const wanted = jacobian != nullptr ? &normal : nullptr;
    double cost = Evaluate(T, /*robust=*/true, wanted);
    if (known_ != nullptr) cost += EvaluateKnown(T, wanted);
    if (jacobian == nullptr) {
      r << Vector6::Zero(), std::sqrt(cost);
    } else {
      // From the tangent at the stepped pose, of the derivatives, to the tangent where the step
      // begins, of the unknowns.
      normal.ChangeUnknowns(Eigen::Matrix3d::Identity(), so3::RightJacobian(step.tail<3>()));
      const SquareRoot root(normal, cost);
      r = root.r;
      Eigen::Map<Eigen::Matrix<double, 7, 6>> J(jacobian);
      J = root.J;
    }
    return r.allFinite();
  }

  // Computes information, gradient and error from the inliers at the solution's pose.
  void Sum(PoseSolution& solution) const {
    NormalEquations normal;
    const double squares = Evaluate(solution.T_WC, /*robust=*/false, &normal);
    solution.information = normal.H;
    solution.gradient = normal.g;
    int rows = active_planes_;
    ForEachKind([&]<class Landmark>() {
      const std::vector<int>& used = PartOf<Landmark>(used_);
      rows = std::accumulate(used.begin(), used.end(), rows);
    });
    if (rows > 6) solution.error = squares / (rows - 6);
  }

  // Classifies inliers at T; former outliers may become inliers of the next round.
  void Classify(const Pose& T) {
    Project(T);
    ForEachKind([&]<class Landmark>() {
      const PoseObservations<Landmark>& seen = PartOf<Landmark>(seen_);
      const RowsOf<Landmark>& rows = PartOf<Landmark>(rows_);
      PartOf<Landmark>(active_) = 0;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const bool inside = rows.IsInside(i);
        Use<Landmark>(i,
                      inside ? seen[i].InlierRows(rows.At(i), options_.inliers, pixels_first_) : 0);
      }
    });
    active_planes_ = 0;
    const RgbdProjection::View view = RgbdProjection::At(T.data());
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
      PartOf<Landmark>(active_) = 0;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        Use<Landmark>(i, seen[i].RowsAtStart(pixels_first));
      }
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
      const std::vector<int>& used = PartOf<Landmark>(used_);
      PartOf<Landmark>(inliers).reserve(used.size());
      for (const int rows : used) PartOf<Landmark>(inliers).push_back(rows > 0);
    });
    return inliers;
  }

  // Returns the median of z in C; for a line, of its midpoint.
  double Depth(const Pose& T) const {
    Project(T);
    std::vector<double> depths;
    depths.reserve(seen_.points.size() + seen_.lines.size());
    ForEachKind([&]<class Landmark>() {
      const std::vector<int>& used = PartOf<Landmark>(used_);
      for (std::size_t i = 0; i < used.size(); ++i) {
        if (used[i] > 0) depths.push_back(PartOf<Landmark>(rows_).Depth(i));
      }
    });
    return depths.empty() ? 0.0 : UpperMedian(std::move(depths));
  }

 private:
  // Of each observation, the number of its rows that take part; 0 for an outlier.
  template <class Landmark>
  using UsedRows = std::vector<int>;
  template <class Landmark>
  using RowsOf = PoseRows<PoseTraits<Landmark>::Observation::kEndRows,
                          PoseTraits<Landmark>::Observation::kEnds>;

  template <class Landmark>
  void Use(std::size_t i, int used) {
    using Observation = typename PoseTraits<Landmark>::Observation;
    PartOf<Landmark>(used_)[i] = used;
    PartOf<Landmark>(rows_).SetActive(i, used > 0, Observation::UsesDepth(used));
    PartOf<Landmark>(active_) += used > 0 ? 1 : 0;
  }

  // Projects all landmarks, unless that was the last pose: the solver evaluates an accepted step a
  // second time, and each round begins where the last one ended.
  void Project(const Pose& T) const {
    if (projected_ && std::equal(T.data(), T.data() + Pose::kSize, projected_->data())) return;
    const RgbdProjection::View view = RgbdProjection::At(T.data());
    ForEachKind([&]<class Landmark>() { PartOf<Landmark>(rows_).Project(view); });
    projected_ = T;
  }

  // Returns the sum of squares of all inliers, robust or not; writes the normal equations in the
  // tangent at T, where not null.
  double Evaluate(const Pose& T, bool robust, NormalEquations* normal) const {
    constexpr double kNoHuber = std::numeric_limits<double>::max();
    Project(T);
    const RgbdProjection::View view = RgbdProjection::At(T.data());
    double cost = 0.0;
    PoseNormalSums sums;
    ForEachKind([&]<class Landmark>() {
      const double huber = robust ? PoseTraits<Landmark>::Observation::Huber(options_) : kNoHuber;
      const RowsOf<Landmark>& rows = PartOf<Landmark>(rows_);
      cost += normal != nullptr ? rows.AddTo(&sums, huber) : rows.Cost(huber);
    });
    if (normal != nullptr) {
      *normal = {sums.Information(), sums.Gradient()};
      const Eigen::Matrix3d R_CW = projection_.R_CB() * view.R_BW;
      normal->ChangeUnknowns(-R_CW, projection_.R_CB());
    }
    const double plane_huber = robust ? options_.plane_huber : kNoHuber;
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      if (!plane_active_[i]) continue;
      Eigen::Matrix<double, 1, 6> J;
      const double r = PlaneRow(view, planes_[i], normal != nullptr ? &J : nullptr);
      const double norm = std::abs(r), least = std::min(norm, plane_huber);
      cost += least * (2.0 * norm - least);
      if (normal == nullptr) continue;
      const double weight = plane_huber / std::max(norm, plane_huber);
      normal->Add(Eigen::Matrix<double, 1, 1>(r), J, weight);
    }
    return cost;
  }

  static double PlaneRow(const RgbdProjection::View& view, const PointToPlaneRow& row,
                         Eigen::Matrix<double, 1, 6>* J) {
    return row.Evaluate(view.R_BW.transpose(), view.p_WB, J);
  }

  // The same of the prior.
  double EvaluateKnown(const Pose& T, NormalEquations* normal) const {
    const Eigen::Vector3d theta = so3::Log(known_->T_WC.q().conjugate() * T.q());
    Vector6 e;
    e << T.p() - known_->T_WC.p(), theta;
    const Vector6 r = known_->sqrt_information * e;
    if (normal != nullptr) {
      Matrix6 J = known_->sqrt_information;
      J.rightCols<3>() = J.rightCols<3>() * so3::RightJacobianInverse(theta);
      normal->Add(r, J, 1.0);
    }
    return r.squaredNorm();
  }

  Pose T_start_;
  const RgbdProjection& projection_;
  const PerKind<PoseObservations>& seen_;
  const PoseSolverOptions& options_;
  const PoseConstraint* known_;
  std::span<const PointToPlaneRow> planes_;
  bool pixels_first_ = false;
  // The last projection is kept.
  mutable PerKind<RowsOf> rows_;
  mutable std::optional<Pose> projected_;
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
