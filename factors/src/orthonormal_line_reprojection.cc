#include <cmath>

#include <Eigen/Geometry>

#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>
#include <highwall/factors/line_reprojection.h>

namespace highwall {
namespace {

using Eigen::Vector3d;

// Above this ratio |n_z| / |(n_x, n_y)|, the image of a line is 89.4 degrees or more off the
// optical axis: the plane through line and camera is almost parallel to the image.
constexpr double kMaxTangent = 100.0;

// Line in B and C, moment n and direction d up to one common scale; every row is homogeneous of
// degree 0.
struct SeenLine {
  Vector3d u1, u2, u3;  // columns of U, in W
  double w1, w2;
  Vector3d p_WB;
  Eigen::Matrix3d R_BW;
  Vector3d n_B, d_B;
  Vector3d n, d;  // in C

  SeenLine(const RgbdProjection& projection, const double* T_WB, const double* line)
      : w1(line[4]), w2(line[5]) {
    const Eigen::Matrix3d U = Eigen::Map<const Eigen::Quaterniond>(line).toRotationMatrix();
    u1 = U.col(0), u2 = U.col(1), u3 = U.col(2);
    const RgbdProjection::View view = RgbdProjection::At(T_WB);
    p_WB = view.p_WB;
    R_BW = view.R_BW;
    n_B = R_BW * (w1 * u1 - p_WB.cross(w2 * u2));  // Eq. 9
    d_B = R_BW * (w2 * u2);
    d = projection.R_CB() * d_B;
    n = projection.R_CB() * n_B + projection.p_CB().cross(d);
  }
};

// n: moment of a line with direction d in the frame of a camera.
bool IsVisible(const Vector3d& n, const Vector3d& d, double min_distance) {
  return n.squaredNorm() >= min_distance * min_distance * d.squaredNorm() &&
         n.z() * n.z() <= kMaxTangent * kMaxTangent * n.head<2>().squaredNorm();
}

// Residual row and its derivatives in the moment and direction of the line in C.
struct Row {
  double r;
  Vector3d dr_dn = Vector3d::Zero();
  Vector3d dr_dd = Vector3d::Zero();
};

// Image of the line with moment n, shared by the rows of both ends.
struct LineImage {
  Vector3d S;  // diag(1/fx^2, 1/fy^2, 0)
  Vector3d n;
  Vector3d k;        // S n
  double inverse_h;  // 1 / h,  h^2 = n^T S n

  LineImage(const RgbdProjection& projection, const Vector3d& moment)
      : S(1.0 / (projection.fx() * projection.fx()), 1.0 / (projection.fy() * projection.fy()),
          0.0),
        n(moment),
        k(S.cwiseProduct(n)),
        inverse_h(1.0 / std::sqrt(n.dot(k))) {}

  // Returns the signed distance [px] of the pixel with direction m.
  Row Distance(const Vector3d& m) const {
    const double r = n.dot(m) * inverse_h;                                // Eq. 10
    return {r, (m - (r * inverse_h) * k) * inverse_h, Vector3d::Zero()};  // Eq. 13
  }

  // Returns the disparity [px] of the line, whose direction is d, at the foot of the perpendicular
  // from m to its image, minus `measured`. distance: Distance(m).
  Row Disparity(double fxb, const Vector3d& d, const Vector3d& m, double measured,
                const Row& distance, bool with_derivatives) const {
    const double inverse_n2 = 1.0 / n.squaredNorm();
    const double e = distance.r * inverse_h;
    const Vector3d foot = m - e * k;
    const Vector3d q = d.cross(n) * inverse_n2;
    const double inverse_depth = foot.dot(q);
    Row row{fxb * inverse_depth - measured};  // Eq. 11
    if (with_derivatives) {
      const Vector3d de_dn = (distance.dr_dn - (e * inverse_h) * k) * inverse_h;
      row.dr_dn = fxb * ((foot.cross(d) - (2.0 * inverse_depth) * n) * inverse_n2 -
                         k.dot(q) * de_dn - e * S.cwiseProduct(q));  // Eq. 14
      row.dr_dd = (fxb * inverse_n2) * n.cross(foot);
    }
    return row;
  }
};

Vector3d Direction(const RgbdProjection& projection, double u, double v) {
  return {(u - projection.cx()) / projection.fx(), (v - projection.cy()) / projection.fy(), 1.0};
}

// Applies the chain rule from (n, d) in C to the tangents of pose and line, and lifts the result.
template <int kRows>
void WriteJacobians(const RgbdProjection& projection, const SeenLine& line,
                    const Eigen::Matrix<double, kRows, 3>& dr_dn,
                    const Eigen::Matrix<double, kRows, 3>& dr_dd, double const* const* parameters,
                    double** jacobians) {
  using Rows3 = Eigen::Matrix<double, kRows, 3>;
  const Rows3 dr_dnB = dr_dn * projection.R_CB();
  const Rows3 dr_ddB = (dr_dd + dr_dn * so3::Hat(projection.p_CB())) * projection.R_CB();
  if (jacobians[0] != nullptr) {
    const Eigen::Matrix3d hat_d = so3::Hat(line.d_B);
    Eigen::Matrix<double, kRows, 6> dr_dpose;  // Eq. 15
    dr_dpose << (dr_dnB * hat_d) * line.R_BW, dr_dnB * so3::Hat(line.n_B) + dr_ddB * hat_d;
    PoseManifold::Lift<kRows>(parameters[0], dr_dpose, jacobians[0]);
  }
  if (jacobians[1] != nullptr) {
    const Rows3 dr_dnW = dr_dnB * line.R_BW;
    const Rows3 dr_ddW = dr_ddB * line.R_BW - dr_dnW * so3::Hat(line.p_WB);
    const Eigen::Matrix<double, kRows, 1> n1 = dr_dnW * line.u1, n2 = dr_dnW * line.u2;
    Eigen::Matrix<double, kRows, 4> dr_dline;  // Eq. 16
    dr_dline.col(0) = line.w2 * (dr_ddW * line.u3);
    dr_dline.col(1) = -line.w1 * (dr_dnW * line.u3);
    dr_dline.col(2) = line.w1 * n2 - line.w2 * (dr_ddW * line.u1);
    dr_dline.col(3) = line.w1 * (dr_ddW * line.u2) - line.w2 * n1;
    LineManifold::Lift<kRows>(parameters[1], dr_dline, jacobians[1]);
  }
}

std::array<double, 2> DepthWeights(const RgbdSegment& observed, const SegmentNoise& noise,
                                   Weighting weighting) {
  // The end-point form has the same sigmas, as the factor of delta in its rows, and the same
  // preconditions.
  const auto rows = SegmentRows(observed, noise, Weighting::kCovariance);
  if (weighting == Weighting::kPaper) return {1.0 / noise.px, 1.0 / noise.px};
  return {rows[0].A(1, 2), rows[1].A(1, 2)};
}

template <int kRows>
bool SetInactive(double* residuals, double** jacobians) {
  Eigen::Map<Eigen::Matrix<double, kRows, 1>> r(residuals);
  r.setZero();
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, kRows, 7, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
  }
  if (jacobians != nullptr && jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, kRows, 6, Eigen::RowMajor>> J(jacobians[1]);
    J.setZero();
  }
  return true;
}

}  // namespace

OrthonormalLineReprojection::OrthonormalLineReprojection(const Eigen::Vector2d& s,
                                                         const Eigen::Vector2d& e, double sigma_px,
                                                         const RgbdProjection& projection)
    : ends_{s, e}, weight_(1.0 / sigma_px), projection_(projection) {
  SegmentRows(s, e, sigma_px);  // checks the same preconditions
}

bool OrthonormalLineReprojection::Evaluate(double const* const* parameters, double* residuals,
                                           double** jacobians) const {
  const SeenLine line(projection_, parameters[kPose], parameters[kLine]);
  if (!IsVisible(line.n, line.d, projection_.min_depth())) {
    return SetInactive<2>(residuals, jacobians);
  }
  const LineImage image(projection_, line.n);
  Eigen::Matrix<double, 2, 3> dr_dn;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d& end = ends_[static_cast<std::size_t>(i)];
    const Row left = image.Distance(Direction(projection_, end.x(), end.y()));
    residuals[i] = weight_ * left.r;
    dr_dn.row(i) = weight_ * left.dr_dn.transpose();
  }
  if (jacobians != nullptr) {
    WriteJacobians<2>(projection_, line, dr_dn, Eigen::Matrix<double, 2, 3>::Zero(), parameters,
                      jacobians);
  }
  return true;
}

OrthonormalLineReprojectionRgbd::OrthonormalLineReprojectionRgbd(const RgbdSegment& observed,
                                                                 const SegmentNoise& noise,
                                                                 Weighting weighting,
                                                                 const RgbdProjection& projection)
    : ends_{observed.s, observed.e},
      weight_(1.0 / noise.px),
      depth_weights_(DepthWeights(observed, noise, weighting)),
      weighting_(weighting),
      projection_(projection) {}

bool OrthonormalLineReprojectionRgbd::Evaluate(double const* const* parameters, double* residuals,
                                               double** jacobians) const {
  const SeenLine line(projection_, parameters[kPose], parameters[kLine]);
  const bool is_paper = weighting_ == Weighting::kPaper;
  const Vector3d p_CV(projection_.baseline(), 0.0, 0.0);
  const Vector3d n_V = line.n - p_CV.cross(line.d);
  if (!IsVisible(line.n, line.d, projection_.min_depth()) ||
      (is_paper && !IsVisible(n_V, line.d, projection_.min_depth()))) {
    return SetInactive<4>(residuals, jacobians);
  }
  const LineImage image(projection_, line.n), right_image(projection_, n_V);
  const double fxb = projection_.fx() * projection_.baseline();
  Eigen::Matrix<double, 4, 3> dr_dn, dr_dd;
  for (int i = 0; i < 2; ++i) {
    const Vector3d& end = ends_[static_cast<std::size_t>(i)];
    const double depth_weight = depth_weights_[static_cast<std::size_t>(i)];
    const Vector3d m = Direction(projection_, end.x(), end.y());
    const Row left = image.Distance(m);
    Row depth{};
    if (is_paper) {
      depth = right_image.Distance(Direction(projection_, end.x() - end.z(), end.y()));  // Eq. 12
      depth.dr_dd = p_CV.cross(depth.dr_dn);
    } else {
      depth = image.Disparity(fxb, line.d, m, end.z(), left, jacobians != nullptr);  // Eq. 11
    }
    residuals[2 * i] = weight_ * left.r;
    residuals[2 * i + 1] = depth_weight * depth.r;
    dr_dn.row(2 * i) = weight_ * left.dr_dn.transpose();
    dr_dn.row(2 * i + 1) = depth_weight * depth.dr_dn.transpose();
    dr_dd.row(2 * i).setZero();
    dr_dd.row(2 * i + 1) = depth_weight * depth.dr_dd.transpose();
  }
  if (jacobians != nullptr) {
    WriteJacobians<4>(projection_, line, dr_dn, dr_dd, parameters, jacobians);
  }
  return true;
}

}  // namespace highwall
