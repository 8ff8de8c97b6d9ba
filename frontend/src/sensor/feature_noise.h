#pragma once

#include <cstddef>
#include <memory>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_report.h>

namespace highwall {

// Kinds of features with a noise of their own, as NoiseEstimate distinguishes them.

// Returns the band of a depth z [m] in NoiseEstimate::Bands.
std::size_t DepthBand(double z);
// Returns whether depth readings around the corner differ.
bool IsAtEdge(const PointFeature& feature, const MeasurementModel& model);
// Returns the band of a segment's length in NoiseEstimate::Bands.
std::size_t LengthBand(const LineFeature& feature, const MeasurementModel& model);

// Returns the features with this noise. Corners get that of detected ones, refined or not: it is
// CornerRefiner that gives refined ones theirs.
std::shared_ptr<const FrameFeatures> WithNoise(const FrameFeatures& features,
                                               const NoiseEstimate& noise,
                                               const MeasurementModel& model);

}  // namespace highwall
