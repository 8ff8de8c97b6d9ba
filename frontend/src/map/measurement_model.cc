#include <highwall/frontend/map/measurement_model.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "input/lens_reach.h"

namespace highwall {
namespace {

Eigen::Vector2d End(const Eigen::Vector2f& end) {
  return end.cast<double>();
}

// Returns false for a segment that the virtual right camera sees end-on, as a dot.
bool HasDirectionFromTheRight(const RgbdSegment& segment) {
  constexpr double kMinLength = 1.0;  // [px] required by SegmentRows
  const Eigen::Vector3d d = segment.e - segment.s;
  return std::hypot(d.x() - d.z(), d.y()) >= kMinLength;
}

}  // namespace

MeasurementModel::MeasurementModel(const RgbdSensor& sensor, const MeasurementOptions& options,
                                   const Pose& T_BC, const PyramidOptions& pyramid,
                                   const MatchingOptions& matching)
    : options_(options),
      matching_(matching),
      pyramid_(pyramid),
      lens_(sensor.camera),
      camera_(sensor.camera.WithoutDistortion()),
      reach_(SquaredReach(sensor.camera)),
      right_{.fx = sensor.camera.fx, .baseline = options.baseline},
      noise_(sensor.depth_noise),
      T_BC_(T_BC),
      projection_(camera_, Pose(), right_),
      body_projection_(camera_, T_BC, right_) {
  sensor.Validate();
  options_.Validate();
  matching_.Validate();
  matching_.lines.mad_rule = options_.mad_rule;
  pyramid_.Validate();
  for (std::size_t i = 0; i < scales_.size(); ++i) {
    scales_[i] = std::pow(pyramid_.scale_factor, static_cast<int>(i));
  }
}

bool MeasurementModel::Sees(const Eigen::Vector2d& uv) const {
  if (!lens_.HasDistortion()) return camera_.Contains(uv);
  const Eigen::Vector3d ray = camera_.Unproject(uv, 1.0);
  return ray.head<2>().squaredNorm() <= reach_ && lens_.Contains(lens_.Project(ray));
}

double MeasurementModel::Stretch(const Eigen::Vector2d& uv) const {
  if (!lens_.HasDistortion()) return 1.0;
  constexpr double kMost = 16.0;  // of a ray at 80 degrees through an equidistant lens: 14
  Eigen::Matrix2d J;
  lens_.Distort(camera_.Unproject(uv, 1.0).head<2>(), &J);
  const double shrinks = std::sqrt(std::abs(J.determinant()));
  return 1.0 / std::max(shrinks, 1.0 / kMost);
}

double MeasurementModel::LineSigma(const LineFeature& feature) const {
  const Eigen::Vector2f middle = 0.5F * (feature.segment.s + feature.segment.e);
  return options_.line_sigma * static_cast<double>(feature.noise.px) * Stretch(End(middle));
}

void MeasurementModel::SetExtrinsics(const Pose& T_BC) {
  T_BC_ = T_BC;
  body_projection_ = ProjectionAt(T_BC);
}

RgbdProjection MeasurementModel::ProjectionAt(const Pose& T_BC) const {
  return RgbdProjection(camera_, T_BC, right_);
}

double MeasurementModel::PointSigma(int octave) const {
  return options_.point_sigma * Scale(octave);
}

Eigen::Matrix3d MeasurementModel::SqrtInformation(const PointFeature& feature) const {
  const double sigma_z = feature.depth_sigma * static_cast<double>(feature.noise.depth);
  return PointSqrtInformation(options_.weighting, PointSigma(feature),
                              DisparitySigma(feature.depth, sigma_z));
}

Eigen::Vector3d MeasurementModel::Measurement(const PointFeature& feature) const {
  return {feature.uv.x(), feature.uv.y(), right_.Disparity(feature.depth)};
}

RgbdSegment MeasurementModel::Measurement(const LineFeature& feature) const {
  const auto end = [&](const Eigen::Vector2f& uv, const Eigen::Vector3d& p_C) {
    return Eigen::Vector3d(static_cast<double>(uv.x()), static_cast<double>(uv.y()),
                           right_.Disparity(p_C.z()));
  };
  return {end(feature.segment.s, feature.segment_C->p_C),
          end(feature.segment.e, feature.segment_C->q_C)};
}

SegmentNoise MeasurementModel::Noise(const LineFeature& feature) const {
  // The fit along the segment is not weighted more than one reading at each end: the depth noise of
  // neighbouring pixels is correlated.
  const auto disparity = [&](double z) {
    return DisparitySigma(z, noise_.Sigma(z) * static_cast<double>(feature.noise.depth));
  };
  return {.px = LineSigma(feature),
          .disparity_s = disparity(feature.segment_C->p_C.z()),
          .disparity_e = disparity(feature.segment_C->q_C.z())};
}

ProjectionRows<3> MeasurementModel::Rows(const PointFeature& feature) const {
  if (feature.depth > 0.0) return PointRows(Measurement(feature), SqrtInformation(feature));
  const ProjectionRows<2> left =
      PointRows(feature.uv, Eigen::Matrix2d(Eigen::Matrix2d::Identity() / PointSigma(feature)));
  ProjectionRows<3> rows;
  rows.A << left.A, Eigen::RowVector3d::Zero();
  rows.b << left.b, 0.0;
  return rows;
}

double MeasurementModel::Chi2(const PointFeature& feature, const Pose& T_WC,
                              const Eigen::Vector3d& p_W) const {
  Eigen::Vector3d r;
  const bool inside = projection_.Evaluate<3>(RgbdProjection::At(T_WC.data()), Rows(feature), p_W,
                                              &r, nullptr, nullptr);
  return inside ? r.squaredNorm() : std::numeric_limits<double>::infinity();
}

std::array<ProjectionRows<2>, 2> MeasurementModel::Rows(const LineFeature& feature) const {
  if (feature.segment_C) {
    const RgbdSegment measured = Measurement(feature);
    if (options_.weighting == Weighting::kCovariance || HasDirectionFromTheRight(measured)) {
      return SegmentRows(measured, Noise(feature), options_.weighting);
    }
  }
  const auto left = SegmentRows(End(feature.segment.s), End(feature.segment.e), LineSigma(feature));
  std::array<ProjectionRows<2>, 2> rows;
  for (std::size_t i = 0; i < 2; ++i) {
    rows[i].A << left[i].A, Eigen::RowVector3d::Zero();
    rows[i].b << left[i].b, 0.0;
  }
  return rows;
}

std::shared_ptr<ceres::CostFunction> MeasurementModel::MakeFactor(
    const PointFeature& feature) const {
  return MakeFactor(feature, body_projection_);
}

std::shared_ptr<ceres::CostFunction> MeasurementModel::MakeFactor(
    const LineFeature& feature) const {
  return MakeFactor(feature, body_projection_);
}

std::shared_ptr<ceres::CostFunction> MeasurementModel::MakeFactor(const PointFeature& feature,
                                                                  const Pose& T_BC) const {
  return MakeFactor(feature, ProjectionAt(T_BC));
}

std::shared_ptr<ceres::CostFunction> MeasurementModel::MakeFactor(const LineFeature& feature,
                                                                  const Pose& T_BC) const {
  return MakeFactor(feature, ProjectionAt(T_BC));
}

std::shared_ptr<ceres::CostFunction> MeasurementModel::MakeFactor(
    const PointFeature& feature, const RgbdProjection& projection) const {
  if (feature.depth > 0.0) {
    return std::make_shared<PointReprojectionRgbd>(Measurement(feature), SqrtInformation(feature),
                                                   projection);
  }
  return std::make_shared<PointReprojection>(
      feature.uv, Eigen::Matrix2d(Eigen::Matrix2d::Identity() / PointSigma(feature)), projection);
}

std::shared_ptr<ceres::CostFunction> MeasurementModel::MakeFactor(
    const LineFeature& feature, const RgbdProjection& projection) const {
  if (feature.segment_C) {
    return std::make_shared<OrthonormalLineReprojectionRgbd>(Measurement(feature), Noise(feature),
                                                             options_.weighting, projection);
  }
  return std::make_shared<OrthonormalLineReprojection>(
      End(feature.segment.s), End(feature.segment.e), LineSigma(feature), projection);
}

}  // namespace highwall
