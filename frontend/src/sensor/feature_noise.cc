#include "sensor/feature_noise.h"

#include <highwall/frontend/map/landmark.h>

namespace highwall {
namespace {

constexpr double kEdge = 1.2;  // of the depth noise, where readings around a corner differ

NoiseFactors FactorsOf(const PointFeature& feature, const NoiseEstimate& noise,
                       const MeasurementModel& model) {
  const auto octave = static_cast<std::size_t>(feature.octave);
  const auto& depth = IsAtEdge(feature, model) ? noise.edge_depth : noise.point_depth;
  const auto& px = feature.low_contrast ? noise.low_contrast_px : noise.point_px;
  return {static_cast<float>(px[octave]), static_cast<float>(depth[DepthBand(feature.depth)])};
}

NoiseFactors FactorsOf(const LineFeature& feature, const NoiseEstimate& noise,
                       const MeasurementModel& model) {
  NoiseFactors factors{.px = static_cast<float>(noise.line_px[LengthBand(feature, model)])};
  if (feature.segment_C) {
    const double z = 0.5 * (feature.segment_C->p_C.z() + feature.segment_C->q_C.z());
    factors.depth = static_cast<float>(noise.line_depth[DepthBand(z)]);
  }
  return factors;
}

// The noise of kinds without an overload is not estimated: it stays what it is.
template <class Feature>
NoiseFactors FactorsOf(const Feature& feature, const NoiseEstimate&, const MeasurementModel&) {
  return feature.noise;
}

}  // namespace

std::size_t DepthBand(double z) {
  return z <= 1.0 ? 0 : z <= 2.0 ? 1 : z <= 4.0 ? 2 : 3;
}

bool IsAtEdge(const PointFeature& feature, const MeasurementModel& model) {
  return feature.depth_sigma > kEdge * model.depth_noise().Sigma(feature.depth);
}

std::size_t LengthBand(const LineFeature& feature, const MeasurementModel& model) {
  const double share = static_cast<double>(feature.segment.Length()) / model.camera().width;
  return share <= 1.0 / 16 ? 0 : share <= 1.0 / 8 ? 1 : share <= 1.0 / 4 ? 2 : 3;
}

std::shared_ptr<const FrameFeatures> WithNoise(const FrameFeatures& features,
                                               const NoiseEstimate& noise,
                                               const MeasurementModel& model) {
  auto known = std::make_shared<FrameFeatures>(features);
  ForEachKind([&]<class Landmark>() {
    for (auto& feature : PartOf<Landmark>(*known)) feature.noise = FactorsOf(feature, noise, model);
  });
  for (PointFeature& point : known->points) {
    point.refined_noise_px =
        static_cast<float>(noise.refined_px[static_cast<std::size_t>(point.octave)]);
  }
  return known;
}

}  // namespace highwall
