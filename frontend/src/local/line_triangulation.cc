#include <highwall/frontend/local/triangulation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <ceres/tiny_solver.h>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {
namespace {

// [m^2] Below it the cameras are within a micrometre of the planes: distances are unobservable.
constexpr double kInOnePlane = 1e-12;

Eigen::Vector3d Ray(const PinholeCamera& camera, const Eigen::Vector2f& uv) {
  return camera.Unproject(uv.cast<double>(), 1.0);
}

// The first view: rays of its segment's ends, and their derivative by a shift across of 1 px.
struct FirstView {
  FirstView(const PinholeCamera& camera, const LineSegment& segment)
      : s(Ray(camera, segment.s)), e(Ray(camera, segment.e)) {
    const Eigen::Vector2d d = (segment.e - segment.s).cast<double>().normalized();
    across = {-d.y() / camera.fx, d.x() / camera.fy, 0.0};
  }
  Eigen::Vector3d s, e, across;
};

// A view in the form used by the problem; C is the camera of the first view.
struct SeenFrom {
  Eigen::Matrix3d R_VC;
  Eigen::Vector3d p_VC;
  std::array<Eigen::Vector3d, 2> ends;  // rays
  double weight;                        // [1/px]
};

// The functor of ceres::TinySolver: rows across the image of all views, in pixels over their noise,
// as a function of (offset, inverse depth) in the first view.
class LineProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 4 };
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, 4>;

  LineProblem(const MeasurementModel& model, std::span<const LineView> views)
      : first_(model.camera(), views.front().segment),
        S_(std::pow(model.camera().fx, -2), std::pow(model.camera().fy, -2), 0.0) {
    for (const LineView& view : views) {
      const Pose T_VC = view.T_WC.Inverse() * views.front().T_WC;
      views_.push_back({T_VC.R(),
                        T_VC.p(),
                        {Ray(model.camera(), view.segment.s), Ray(model.camera(), view.segment.e)},
                        1.0 / view.sigma});
    }
  }

  int NumResiduals() const { return 2 * static_cast<int>(views_.size()); }

  // TinySolver ignores the return value: a step with non-finite rows must cost more than any.
  bool operator()(const double* x, double* residuals, double* jacobian) const {
    const Eigen::Vector3d s = first_.s + x[0] * first_.across, e = first_.e + x[1] * first_.across;
    Eigen::Map<Jacobian> J(jacobian, jacobian != nullptr ? NumResiduals() : 0, 4);
    Eigen::Map<Eigen::VectorXd> r(residuals, NumResiduals());
    Eigen::Index row = 0;
    for (const SeenFrom& view : views_) {
      const Eigen::Vector3d p = view.R_VC * s + x[2] * view.p_VC;  // times z: at infinity as well
      const Eigen::Vector3d q = view.R_VC * e + x[3] * view.p_VC;
      // Moment of the line in the view, to a scale that cancels.
      const Eigen::Vector3d n = p.cross(q), k = S_.cwiseProduct(n), a = view.R_VC * first_.across;
      const double inverse_h = 1.0 / std::sqrt(n.dot(k));
      Eigen::Matrix<double, 3, 4> dn_dx;
      dn_dx << a.cross(q), p.cross(a), view.p_VC.cross(q), p.cross(view.p_VC);
      for (const Eigen::Vector3d& m : view.ends) {
        const double distance = n.dot(m) * inverse_h;  // docs/factors/line_reprojection.md, Eq. 10
        r[row] = view.weight * distance;
        if (jacobian != nullptr) {
          const Eigen::Vector3d dr_dn = (m - (distance * inverse_h) * k) * inverse_h;  // Eq. 13
          J.row(row) = view.weight * dr_dn.transpose() * dn_dx;
        }
        ++row;
      }
    }
    if (r.allFinite()) return true;
    r.setConstant(std::numeric_limits<double>::infinity());
    return false;
  }

  // Returns the least-squares intersection of the first view's rays with the planes of the others;
  // offsets are zero.
  std::optional<Eigen::Vector4d> Start() const {
    Eigen::Vector4d x = Eigen::Vector4d::Zero();
    for (const int end : {0, 1}) {
      double a = 0.0, b = 0.0;
      for (std::size_t i = 1; i < views_.size(); ++i) {
        const SeenFrom& view = views_[i];
        const Eigen::Vector3d n = view.ends[0].cross(view.ends[1]).normalized();
        const double along = n.dot(view.p_VC);
        a += along * along;
        b -= along * n.dot(view.R_VC * (end == 0 ? first_.s : first_.e));
      }
      if (!(a > kInOnePlane)) return std::nullopt;
      x[2 + end] = b / a;
    }
    return x;
  }

  // [m] in the first view; requires positive inverse depths.
  Segment3 Segment(const Eigen::Vector4d& x) const {
    return {(first_.s + x[0] * first_.across) / x[2], (first_.e + x[1] * first_.across) / x[3]};
  }

 private:
  const FirstView first_;
  const Eigen::Vector3d S_;  // diag(1/fx^2, 1/fy^2, 0)
  std::vector<SeenFrom> views_;
};

// Returns whether every camera has its part of the line in front of it.
bool IsBeforeAll(const MeasurementModel& model, const Segment3& segment_W,
                 std::span<const LineView> views) {
  if (!(segment_W.Length() > 1e-6)) return false;
  const PluckerLine line_W = PluckerLine::FromPoints(segment_W.p(), segment_W.q());
  return std::all_of(views.begin(), views.end(), [&](const LineView& view) {
    return TrimToObservation(view.T_WC.Inverse() * line_W, view.segment.s.cast<double>(),
                             view.segment.e.cast<double>(), model.projection())
        .has_value();
  });
}

}  // namespace

std::optional<TriangulatedLine> TriangulateLine(const MeasurementModel& model,
                                                std::span<const LineView> views) {
  HIGHWALL_REQUIRE(views.size() >= 2, "TriangulateLine: a line needs at least two views, has " +
                                          std::to_string(views.size()));
  const LineProblem problem(model, views);
  const auto start = problem.Start();
  if (!start) return std::nullopt;
  ceres::TinySolver<LineProblem> solver;
  solver.options.max_num_iterations = 10;
  Eigen::Vector4d x = *start;
  solver.Solve(problem, &x);

  Eigen::VectorXd r(problem.NumResiduals());
  LineProblem::Jacobian J(problem.NumResiduals(), 4);
  if (!x.allFinite() || !(x.tail<2>().minCoeff() > 0.0) || !problem(x.data(), r.data(), J.data())) {
    return std::nullopt;
  }
  const Eigen::LLT<Eigen::Matrix4d> information(J.transpose() * J);
  if (information.info() != Eigen::Success) return std::nullopt;
  TriangulatedLine line{views.front().T_WC * problem.Segment(x),
                        {x.head<2>(), x.tail<2>(), information.solve(Eigen::Matrix4d::Identity())},
                        {}};
  if (!IsBeforeAll(model, line.segment_W, views)) return std::nullopt;
  for (Eigen::Index i = 0; i < r.size(); i += 2) {
    line.squared_errors.push_back(r.segment<2>(i).squaredNorm());
  }
  return line;
}

}  // namespace highwall
