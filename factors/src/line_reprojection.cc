#include <highwall/factors/line_reprojection.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

constexpr double kMinLength = 1.0;  // [px] a shorter segment has no reliable direction

// Observed image line: unit direction along it, unit normal across it, one of its points.
struct ImageLine {
  ImageLine(const Eigen::Vector2d& s, const Eigen::Vector2d& e)
      : point(s), length((e - s).norm()), along((e - s) / length), across(-along.y(), along.x()) {}

  Eigen::Vector2d point;
  double length;
  Eigen::Vector2d along;
  Eigen::Vector2d across;
};

// Evaluates both end-point factors: kRows rows for each end.
template <int kRows>
void EvaluateSegment(const RgbdProjection& projection,
                     const std::array<ProjectionRows<kRows>, 2>& rows,
                     double const* const* parameters, double* residuals, double** jacobians) {
  const double* T_WB = parameters[0];
  double* J_pose = jacobians ? jacobians[0] : nullptr;
  double* J_segment = jacobians ? jacobians[1] : nullptr;
  const RgbdProjection::View view = RgbdProjection::At(T_WB);

  Eigen::Matrix<double, 2 * kRows, 6> dr_dpose;
  Eigen::Matrix<double, 2 * kRows, 6> dr_dsegment = Eigen::Matrix<double, 2 * kRows, 6>::Zero();
  for (int i = 0; i < 2; ++i) {
    const Eigen::Map<const Eigen::Vector3d> p_W(parameters[1] + 3 * i);
    Eigen::Matrix<double, kRows, 1> r;
    Eigen::Matrix<double, kRows, 6> dr_dpose_i;
    Eigen::Matrix<double, kRows, 3> dr_dp_W;
    if (!projection.Evaluate<kRows>(view, rows[static_cast<std::size_t>(i)], p_W, &r,
                                    J_pose ? &dr_dpose_i : nullptr,
                                    J_segment ? &dr_dp_W : nullptr)) {
      r.setZero();
      dr_dpose_i.setZero();
      dr_dp_W.setZero();
    }
    Eigen::Map<Eigen::Matrix<double, kRows, 1>> out(residuals + kRows * i);
    out = r;
    if (J_pose) dr_dpose.template middleRows<kRows>(kRows * i) = dr_dpose_i;
    if (J_segment) dr_dsegment.template block<kRows, 3>(kRows * i, 3 * i) = dr_dp_W;
  }
  if (J_pose) PoseManifold::Lift<2 * kRows>(T_WB, dr_dpose, J_pose);
  if (J_segment) {
    Eigen::Map<Eigen::Matrix<double, 2 * kRows, 6, Eigen::RowMajor>> J(J_segment);
    J = dr_dsegment;
  }
}

}  // namespace

void SegmentNoise::Validate() const {
  RequirePositiveFinite(px, "SegmentNoise::px");
  RequirePositiveFinite(disparity_s, "SegmentNoise::disparity_s");
  RequirePositiveFinite(disparity_e, "SegmentNoise::disparity_e");
}

void RgbdSegment::Validate() const {
  HIGHWALL_REQUIRE(s.allFinite() && e.allFinite(), "RgbdSegment: both ends must be finite");
  HIGHWALL_REQUIRE((e - s).head<2>().norm() >= kMinLength, "RgbdSegment: ends closer than 1 px");
  RequirePositiveFinite(s.z(), "RgbdSegment: disparity of s");
  RequirePositiveFinite(e.z(), "RgbdSegment: disparity of e");
}

std::array<ProjectionRows<1>, 2> SegmentRows(const Eigen::Vector2d& s, const Eigen::Vector2d& e,
                                             double sigma_px) {
  HIGHWALL_REQUIRE(s.allFinite() && e.allFinite(), "SegmentRows: both ends must be finite");
  HIGHWALL_REQUIRE((e - s).norm() >= kMinLength, "SegmentRows: ends closer than 1 px");
  RequirePositiveFinite(sigma_px, "SegmentRows: sigma_px");
  const ImageLine line(s, e);
  ProjectionRows<1> row;
  row.A << line.across.transpose() / sigma_px, 0.0;  // Eq. 3
  row.b << -line.across.dot(s) / sigma_px;
  return {row, row};
}

std::array<ProjectionRows<2>, 2> SegmentRows(const RgbdSegment& observed, const SegmentNoise& noise,
                                             Weighting weighting) {
  observed.Validate();
  noise.Validate();
  const Eigen::Vector2d s = observed.s.head<2>(), e = observed.e.head<2>();
  const double delta_s = observed.s.z(), delta_e = observed.e.z();
  const std::array<ProjectionRows<1>, 2> left = SegmentRows(s, e, noise.px);
  std::array<ProjectionRows<2>, 2> rows;
  for (std::size_t i = 0; i < 2; ++i) {
    rows[i].A.row(0) = left[i].A;
    rows[i].b(0) = left[i].b(0);
  }
  if (weighting == Weighting::kPaper) {
    const Eigen::Vector2d s_R(s.x() - delta_s, s.y()), e_R(e.x() - delta_e, e.y());
    const std::array<ProjectionRows<1>, 2> right = SegmentRows(s_R, e_R, noise.px);
    for (std::size_t i = 0; i < 2; ++i) {
      const double a_R = right[i].A(0), b_R = right[i].A(1);
      rows[i].A.row(1) << a_R, b_R, -a_R;  // Eq. 8: u_R = u - delta
      rows[i].b(1) = right[i].b(0);
    }
    return rows;
  }
  const ImageLine line(s, e);
  const double g = (delta_e - delta_s) / line.length;
  const double sigma_delta[2] = {noise.disparity_s, noise.disparity_e};
  for (std::size_t i = 0; i < 2; ++i) {
    const double weight = 1.0 / std::hypot(sigma_delta[i], g * noise.px);  // Eq. 6
    rows[i].A.row(1) << -g * line.along.transpose() * weight, weight;      // Eq. 4
    rows[i].b(1) = (g * line.along.dot(s) - delta_s) * weight;
  }
  return rows;
}

bool LineReprojection::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  EvaluateSegment(projection_, rows_, parameters, residuals, jacobians);
  return true;
}

bool LineReprojectionRgbd::Evaluate(double const* const* parameters, double* residuals,
                                    double** jacobians) const {
  EvaluateSegment(projection_, rows_, parameters, residuals, jacobians);
  return true;
}

}  // namespace highwall
