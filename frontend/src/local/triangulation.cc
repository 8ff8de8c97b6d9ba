#include <highwall/frontend/local/triangulation.h>

#include <algorithm>
#include <limits>
#include <vector>

#include <ceres/tiny_solver.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace highwall {
namespace {

// [rad^2] Rays with a smaller difference give no distance: a hundredth of a pixel of any camera.
constexpr double kParallel = 1e-9;

// The functor of ceres::TinySolver: rows of all views as a function of p_W.
class PointProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 3 };

  PointProblem(const MeasurementModel& model, std::span<const PointView> views)
      : projection_(model.projection()) {
    for (const PointView& view : views) {
      rows_.push_back(model.Rows(view.feature));
      views_.push_back(RgbdProjection::At(view.T_WC.data()));
    }
  }

  int NumResiduals() const { return 3 * static_cast<int>(rows_.size()); }

  bool operator()(const double* p_W, double* residuals, double* jacobian) const {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3>> J(jacobian, NumResiduals(), 3);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(3 * i);
      Eigen::Vector3d r;
      Eigen::Matrix3d dr_dp;
      if (!projection_.Evaluate<3>(views_[i], rows_[i], Eigen::Map<const Eigen::Vector3d>(p_W), &r,
                                   nullptr, jacobian != nullptr ? &dr_dp : nullptr)) {
        // TinySolver ignores the return value: such a step must cost more than any.
        std::fill_n(residuals, NumResiduals(), std::numeric_limits<double>::infinity());
        return false;
      }
      Eigen::Map<Eigen::Vector3d>(residuals + row) = r;
      if (jacobian != nullptr) J.middleRows<3>(row) = dr_dp;
    }
    return true;
  }

 private:
  const RgbdProjection& projection_;
  std::vector<ProjectionRows<3>> rows_;
  std::vector<RgbdProjection::View> views_;
};

// Returns the point nearest to all rays.
std::optional<Eigen::Vector3d> NearestToRays(const PinholeCamera& camera,
                                             std::span<const PointView> views) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const PointView& view : views) {
    const Eigen::Vector3d ray_W = (view.T_WC.R() * camera.Unproject(view.feature.uv, 1.0));
    const Eigen::Vector3d d = ray_W.normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * view.T_WC.p();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] > kParallel)) return std::nullopt;
  return A.ldlt().solve(b);
}

}  // namespace

std::optional<TriangulatedPoint> TriangulatePoint(const MeasurementModel& model,
                                                  std::span<const PointView> views) {
  const auto start = NearestToRays(model.camera(), views);
  if (!start) return std::nullopt;
  const PointProblem problem(model, views);
  Eigen::VectorXd r(problem.NumResiduals());
  if (!problem(start->data(), r.data(), nullptr)) return std::nullopt;

  ceres::TinySolver<PointProblem> solver;
  solver.options.max_num_iterations = 10;
  Eigen::Vector3d p_W = *start;
  solver.Solve(problem, &p_W);
  Eigen::Matrix<double, Eigen::Dynamic, 3> J(problem.NumResiduals(), 3);
  if (!p_W.allFinite() || !problem(p_W.data(), r.data(), J.data())) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix3d> information(J.transpose() * J);
  if (information.info() != Eigen::Success) return std::nullopt;
  return TriangulatedPoint{p_W, information.solve(Eigen::Matrix3d::Identity()), r.squaredNorm()};
}

}  // namespace highwall
