#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/options.h>
#include <highwall/frontend/input/sensor.h>

#include "features/line_extractor.h"

namespace highwall {

// Robust 3-D line behind an image segment (docs/equations.md, section 3). Inverse depth is affine
// over the image of a plane, so along the segment 1/z(t) = (1 - t)/z_s + t/z_e: two numbers, found
// on each side of the segment by RANSAC (Fischler, Bolles 1981; scored as MSAC), then by least
// squares with weights 1/sigma_d^2, with the slope across the segment as a third unknown, over both
// sides where they make one plane, else over the nearer side, whose boundary the edge is.
//
// segment: undistorted pixels (of camera.WithoutDistortion()). depth: CV_32FC1 [m], raw pixels of
// the sensor's camera, its size; 0, NaN or beyond the sensor's range mean no measurement. Nothing
// where too few pixels are measured or the fit is poor. Throws InvalidArgument on another type or
// size and on bad options.
std::optional<SegmentDepth> FitSegmentDepth(const LineSegment& segment, const cv::Mat& depth,
                                            const RgbdSensor& sensor,
                                            const SegmentDepthOptions& options = {});

}  // namespace highwall
