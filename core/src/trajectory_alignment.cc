#include "trajectory_alignment.h"

#include <cmath>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace internal {
namespace {

// Relative to the largest singular value of the covariance. Positions on a line that is not
// parallel to an axis deviate from it by the rounding of their digits.
constexpr double kLine = 1e-9;
constexpr double kRounding = 1e-12;  // relative to the largest coordinate

Eigen::Matrix3Xd Centred(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& mean) {
  const Eigen::Matrix3Xd centred = points.colwise() - mean;
  const double rounding = kRounding * points.cwiseAbs().maxCoeff();
  if (centred.cwiseAbs().maxCoeff() <= rounding) {
    return Eigen::Matrix3Xd::Zero(3, points.cols());
  }
  return centred;
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d s = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) s(2) = -1.0;
  return svd.matrixU() * s.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3Xd Positions(const Trajectory& trajectory) {
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(trajectory.size()));
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    positions.col(i) = trajectory[static_cast<std::size_t>(i)].pose.p();
  }
  return positions;
}

// Returns the rotation that brings the attitudes of b, rotated by R, nearest to those of a (chordal
// distance): with M = sum R_a (R R_b)^T, the rotation X maximizes tr(X^T M).
Eigen::Matrix3d TurnOfAttitudes(const Trajectory& a, const Trajectory& b, const Eigen::Matrix3d& R,
                                const PositionAlignment& alignment) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    M += a[i].pose.R() * (R * b[i].pose.R()).transpose();
  }
  if (alignment.open == OpenRotation::kAll) return NearestRotation(M);
  // X = u u^T + cos (I - u u^T) + sin [u]: tr(X^T M) = const + cos c + sin s.
  const Eigen::Vector3d& u = alignment.line_A;
  const double c = M.trace() - u.dot(M * u);
  const double s = (so3::Hat(u).transpose() * M).trace();
  return Eigen::AngleAxisd(std::atan2(s, c), u).toRotationMatrix();
}

}  // namespace

std::optional<PositionAlignment> AlignPositions(const Eigen::Matrix3Xd& a,
                                                const Eigen::Matrix3Xd& b, bool with_scale,
                                                std::string* fault) {
  HIGHWALL_REQUIRE(a.cols() == b.cols(),
                   "an alignment needs as many points on one side as on the other");
  HIGHWALL_REQUIRE(a.allFinite() && b.allFinite(), "the points of an alignment must be finite");
  if (a.cols() < 3) {
    *fault = "alignment by se3 or sim3 needs three matched poses, found " +
             std::to_string(a.cols()) + ": align by origin or none";
    return std::nullopt;
  }
  const auto n = static_cast<double>(a.cols());
  const Eigen::Vector3d mean_a = a.rowwise().mean();  // Eq. 35
  const Eigen::Vector3d mean_b = b.rowwise().mean();  // Eq. 34
  const Eigen::Matrix3Xd centred_b = Centred(b, mean_b);
  const double variance_b = centred_b.squaredNorm() / n;                              // Eq. 36
  const Eigen::Matrix3d covariance = Centred(a, mean_a) * centred_b.transpose() / n;  // Eq. 38
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d d = svd.singularValues();
  PositionAlignment alignment{.mean_A = mean_a};
  if (!(d(0) > 0.0)) {
    alignment.open = OpenRotation::kAll;
  } else if (!(d(1) > kLine * d(0))) {
    alignment.open = OpenRotation::kAboutLine;
    alignment.line_A = svd.matrixU().col(0);
  }
  if (with_scale && alignment.open == OpenRotation::kAll) {
    *fault =
        "alignment with a scale is not determined, since all matched positions lie in one point: "
        "align by se3, origin or none";
    return std::nullopt;
  }
  Eigen::Vector3d s = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) s(2) = -1.0;  // Eq. 39, 43
  const Eigen::Matrix3d R = svd.matrixU() * s.asDiagonal() * svd.matrixV().transpose();  // Eq. 40
  const double scale = with_scale ? d.dot(s) / variance_b : 1.0;                         // Eq. 42
  alignment.S_AB = {scale, Pose(Eigen::Quaterniond(R), mean_a - scale * R * mean_b)};    // Eq. 41
  return alignment;
}

PositionAlignment AlignPoses(const Trajectory& a, const Trajectory& b, bool with_scale) {
  std::string fault;
  const auto found = AlignPositions(Positions(a), Positions(b), with_scale, &fault);
  HIGHWALL_REQUIRE(found, fault);
  PositionAlignment alignment = *found;
  if (alignment.open == OpenRotation::kNone) return alignment;
  const Pose& T_AB = alignment.S_AB.T_AB;
  const Eigen::Matrix3d turn = TurnOfAttitudes(a, b, T_AB.R(), alignment);
  // Rotates about the mean of the positions, which stays fixed.
  alignment.S_AB.T_AB = Pose(Eigen::Quaterniond(Eigen::Matrix3d(turn * T_AB.R())),
                             alignment.mean_A + turn * (T_AB.p() - alignment.mean_A));
  return alignment;
}

}  // namespace internal

std::optional<Similarity> AlignUmeyama(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                                       bool with_scale) {
  std::string fault;
  const auto alignment = internal::AlignPositions(a, b, with_scale, &fault);
  if (!alignment || alignment->open != OpenRotation::kNone) return std::nullopt;
  return alignment->S_AB;
}

}  // namespace highwall
