#include <highwall/frontend/pose/pose_observations.h>

#include <algorithm>

#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {
namespace {

// Returns the scale of residuals for the inlier test: bounds are those of the a priori noise, or
// wider if the estimated noise is larger: noise learnt on images with many features must not reject
// those of images with few.
Eigen::Vector2d Judged(const NoiseFactors& noise) {
  return {std::min(1.0, static_cast<double>(noise.px)),
          std::min(1.0, static_cast<double>(noise.depth))};
}

}  // namespace

int PosePoint::InlierRows(const Eigen::Vector3d& r, const InlierBounds& bounds,
                          bool pixels_first) const {
  const Eigen::Vector2d judged = Judged(noise);
  Eigen::Vector3d scaled = r;
  scaled.head<2>() *= judged[0];
  scaled[2] *= judged[1];
  if (!(scaled.squaredNorm() > bounds.Of(dimension))) return dimension;
  const bool pixel_fits = scaled.head<2>().squaredNorm() <= bounds.Of(2);
  return pixels_first && pixel_fits ? 2 : 0;
}

int PoseLine::InlierRows(const Eigen::Vector4d& r, const InlierBounds& bounds, bool) const {
  const Eigen::Vector2d judged = Judged(noise);
  const bool fits = r.cwiseProduct(judged.replicate<2, 1>()).squaredNorm() <= bounds.Of(dimension);
  return fits ? dimension : 0;
}

PosePoint MakePoseObservation(const MeasurementModel& model, const MapPoint& point,
                              const PointFeature& feature) {
  return {point.p_W, model.Rows(feature), MeasurementModel::Dimension(feature), feature.noise};
}

std::optional<PosePoint> MakePoseObservation(const MeasurementModel& model, const MapPoint& point,
                                             const PointFeature& feature, const Pose&) {
  return MakePoseObservation(model, point, feature);
}

std::optional<PoseLine> MakePoseObservation(const MeasurementModel& model, const MapLine& line,
                                            const LineFeature& feature, const Pose& T_WC) {
  const PluckerLine line_W = PluckerLine::FromPoints(line.segment_W.p(), line.segment_W.q());
  const auto seen_C = TrimToObservation(T_WC.Inverse() * line_W, feature.segment.s.cast<double>(),
                                        feature.segment.e.cast<double>(), model.projection());
  if (!seen_C) return std::nullopt;
  return PoseLine{T_WC * *seen_C, model.Rows(feature), MeasurementModel::Dimension(feature),
                  feature.noise};
}

}  // namespace highwall
