#pragma once

#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"

namespace highwall {

// Two views of one place cannot look through what the other sees; views of two places that look
// alike do, either way. Of the cells of a depth grid that fall on a reading of the other, the share
// whose point lies before it, by more than noise and a few hundredths of the depth explain: the
// smaller of what the keyframes have and the frame looks through, and the other way round, for what
// has come or gone is seen one way alone. Empty where hardly any cells are to be compared, or where
// keyframes have no depth grid (a loaded map). depth, T_WC: of the frame, as the keyframes are
// supposed to have it.
std::optional<double> DepthContradiction(const cv::Mat& depth, const Pose& T_WC,
                                         std::span<const KeyFrameId> keyframes, const Map& map,
                                         const DepthGrid& grid, const DepthNoise& noise);

}  // namespace highwall
