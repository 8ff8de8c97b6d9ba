#pragma once

#include <array>

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/core/silent_domain.h>
#include <highwall/core/variable.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/rgbd_projection.h>

namespace [[gnu::visibility("default")]] highwall {

// Reprojection errors of a line, in two parametrizations: a Segment3 block (two end points) and an
// OrthonormalLine block (4 degrees of freedom). Only the distance across the line is measured,
// never the position along it. Equations: docs/factors/line_reprojection.md.

// Standard deviations of an observed segment, all > 0.
struct SegmentNoise {
  double px = 1.0;           // [px] of u and of v of both ends, at their pyramid level
  double disparity_s = 1.0;  // [px] of the first end, DepthNoise::DisparitySigma
  double disparity_e = 1.0;  // [px] of the second end

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Observed segment in undistorted pixels: its end points (u, v, delta), delta being the disparity
// of the fitted 3-D line at the end point.
struct RgbdSegment {
  Eigen::Vector3d s = Eigen::Vector3d::Zero();
  Eigen::Vector3d e = Eigen::Vector3d::Zero();

  // Throws InvalidArgument unless finite, ends at least 1 px apart, disparities positive.
  void Validate() const;
};

// Residual rows of the two end points of a segment in the end-point form, for the factors below and
// for pose-only problems: rows[0] acts on the projection of the 3-D point p, rows[1] on that of q.
//   left image alone: the signed distance to the infinite line through s and e              Eq. 3
// s, e [px]; sigma_px [px] > 0. Throws InvalidArgument as the Validate()s above.
std::array<ProjectionRows<1>, 2> SegmentRows(const Eigen::Vector2d& s, const Eigen::Vector2d& e,
                                             double sigma_px);
//   with depth: that distance, and the row across it in disparity or, for kPaper, the signed
//   distance in the virtual right image                                                Eq. 4, 6, 8
std::array<ProjectionRows<2>, 2> SegmentRows(const RgbdSegment& observed, const SegmentNoise& noise,
                                             Weighting weighting);

// End-point form, left image (2 rows, one per end).
//
// Blocks:  0: T_WB  pose                 (7, PoseManifold)
//          1: p_W, q_W  end points       (6, Euclidean) [m]   (class Segment3)
// Domain: an end with z < RgbdProjection::min_depth gives r = 0, J = 0 in its rows; Evaluate
// returns true. p corresponds to the observed end s, q to e; only the depth rows depend on this.
// Source: Xiao et al. 2025, section 3.2.
class LineReprojection final : public ceres::SizedCostFunction<2, 7, 6>,
                               public SilentOutsideDomain {
 public:
  using Variables = VariableList<Pose, Segment3>;
  enum Block { kPose = 0, kSegment = 1 };

  // rows: SegmentRows(s, e, sigma_px).
  LineReprojection(const std::array<ProjectionRows<1>, 2>& rows, const RgbdProjection& projection)
      : rows_(rows), projection_(projection) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::array<ProjectionRows<1>, 2> rows_;
  const RgbdProjection projection_;
};

// End-point form with depth (4 rows: left and depth of p, left and depth of q). Blocks and domain
// as LineReprojection. Source: Xiao et al. 2025, section 3.3; the covariance is derived on the
// page.
class LineReprojectionRgbd final : public ceres::SizedCostFunction<4, 7, 6>,
                                   public SilentOutsideDomain {
 public:
  using Variables = VariableList<Pose, Segment3>;
  enum Block { kPose = 0, kSegment = 1 };

  // rows: SegmentRows(observed, noise, weighting).
  LineReprojectionRgbd(const std::array<ProjectionRows<2>, 2>& rows,
                       const RgbdProjection& projection)
      : rows_(rows), projection_(projection) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::array<ProjectionRows<2>, 2> rows_;
  const RgbdProjection projection_;
};

// Orthonormal form, left image (2 rows): signed distances of the observed ends s and e to the
// projection of the infinite line                                                           Eq. 10
//
// Blocks:  0: T_WB  pose  (7, PoseManifold)
//          1: line in W   (6, LineManifold)   (class OrthonormalLine)
// Domain: the line passes the optical centre at min_depth or more, and its image at most 100 focal
// lengths from the principal point; outside of it r = 0, J = 0 and Evaluate returns true.
// Source: Bartoli, Sturm, "Structure-from-motion using lines", CVIU 2005, section 4.
class OrthonormalLineReprojection final : public ceres::SizedCostFunction<2, 7, 6>,
                                          public SilentOutsideDomain {
 public:
  using Variables = VariableList<Pose, OrthonormalLine>;
  enum Block { kPose = 0, kLine = 1 };

  // s, e [px]; sigma_px [px] > 0. Throws InvalidArgument as SegmentRows.
  OrthonormalLineReprojection(const Eigen::Vector2d& s, const Eigen::Vector2d& e, double sigma_px,
                              const RgbdProjection& projection);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::array<Eigen::Vector2d, 2> ends_;  // s, e [px]
  const double weight_;                        // [1/px]
  const RgbdProjection projection_;
};

// Orthonormal form with depth (4 rows: left and depth of s, left and depth of e). The depth row is
// the disparity of the line at the observed end (Eq. 11) or, for kPaper, the signed distance in the
// virtual right image (Eq. 12); then the domain holds for the virtual right camera as well.
// Blocks as OrthonormalLineReprojection.
class OrthonormalLineReprojectionRgbd final : public ceres::SizedCostFunction<4, 7, 6>,
                                              public SilentOutsideDomain {
 public:
  using Variables = VariableList<Pose, OrthonormalLine>;
  enum Block { kPose = 0, kLine = 1 };

  // Throws InvalidArgument as SegmentRows.
  OrthonormalLineReprojectionRgbd(const RgbdSegment& observed, const SegmentNoise& noise,
                                  Weighting weighting, const RgbdProjection& projection);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::array<Eigen::Vector3d, 2> ends_;  // s, e as (u, v, delta) [px]
  const double weight_;                        // [1/px] of the left rows
  const std::array<double, 2> depth_weights_;  // [1/px] of the depth rows of s and e
  const Weighting weighting_;
  const RgbdProjection projection_;
};

}  // namespace highwall
