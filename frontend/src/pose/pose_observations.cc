#include "pose/pose_observations.h"

namespace highwall {

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
