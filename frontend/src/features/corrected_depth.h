#pragma once

#include <memory>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/features/frame.h>

namespace highwall {

// Returns the features as if extracted from depth corrected by a distortion pattern: depth of
// points, ends of lines. camera: with its distortion.
std::shared_ptr<const FrameFeatures> CorrectedDepth(const FrameFeatures& features,
                                                    const PinholeCamera& camera,
                                                    const DepthPattern& pattern);

}  // namespace highwall
