#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/line_extractor.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall {

// Share of the samples of a side that must be measurements.
inline constexpr double kMinMeasured = 0.5;

// Fits a robust 3-D line to an image segment (docs/equations.md, section 3). Inverse depth is
// affine over the image of a plane, so along the segment 1/z(t) = (1 - t)/z_s + t/z_e: two numbers,
// estimated on each side of the segment by RANSAC (Fischler, Bolles 1981; scored as MSAC), then by
// least squares with weights 1/sigma_d^2, with the slope across the segment as a third unknown,
// over both sides if they form one plane, else over the nearer side, whose boundary the edge is.
// Sides that differ by less than three sigmas of a reading are one surface, noisier than stated.
//
// segment: undistorted pixels (of camera.WithoutDistortion()). depth: CV_32FC1 [m], raw pixels of
// the sensor's camera, its size; 0, NaN or beyond the sensor's range mean no measurement. Empty if
// too few pixels are measured (min_measured, in (0, 1]) or the fit is poor. noise_factor: as that
// of RgbdImage. Throws InvalidArgument for another type or size.
std::optional<SegmentDepth> FitSegmentDepth(const LineSegment& segment, const cv::Mat& depth,
                                            const RgbdSensor& sensor,
                                            double min_measured = kMinMeasured,
                                            const cv::Mat& noise_factor = {});

}  // namespace highwall
