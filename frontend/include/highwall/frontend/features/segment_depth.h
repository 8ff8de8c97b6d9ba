#pragma once

#include <cstdint>
#include <optional>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/features/line_extractor.h>
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace highwall {

struct SegmentDepthOptions {
  int samples = 24;            // places along the segment, [4, 64]; four depth pixels at each
  double half_width = 2.0;     // [px] farthest pixel from the segment to each side, > 0
  double min_depth = 0.1;      // [m] a nearer value is no measurement, > 0
  double max_depth = 10.0;     // [m] neither is a farther one, > min_depth
  double min_valid = 0.5;      // share of the samples of a side that must be measurements, (0, 1]
  double min_inliers = 0.6;    // share of the measurements that must fit the line, (0, 1]
  double inlier_sigmas = 3.0;  // residual of such a measurement in sigmas, > 0
  double max_rms = 1.5;        // of the inliers' residuals, in sigmas, > 0
  int ransac_iterations = 16;  // for each side, > 0
  std::uint32_t seed = 1;      // of the drawn pairs: equal input gives equal output
  DepthNoise noise = {};       // of the sensor

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A segment in space, in the camera frame.
struct SegmentDepth {
  Eigen::Vector3d p_C, q_C;   // [m] on the fitted line, behind the segment's ends s and e
  double sigma_p = 0.0;       // [m] standard deviation of p_C.z(), as the fit has it
  double sigma_q = 0.0;       // [m] of q_C.z()
  double inlier_share = 0.0;  // of the measurements used
  double rms = 0.0;           // [m] depth residuals of the inliers
  bool depth_edge = false;    // the two sides differ: only the nearer one was used
};

// Robust 3-D line behind an image segment (METHOD.md, section 3). Inverse depth is affine over the
// image of a plane, so along the segment 1/z(t) = (1 - t)/z_s + t/z_e: two numbers, found on each
// side of the segment by RANSAC (Fischler, Bolles 1981; scored as MSAC), then by least squares with
// weights 1/sigma_d^2, with the slope across the segment as a third unknown, over both sides where
// they make one plane, else over the nearer side, whose boundary the edge is.
//
// segment: undistorted pixels (of camera.WithoutDistortion()). depth: CV_32FC1 [m], raw pixels of
// `camera`, its size; 0 or NaN mean no measurement. Nothing where too few pixels are measured or
// the fit is poor. Throws InvalidArgument on another type or size and on bad options.
std::optional<SegmentDepth> FitSegmentDepth(const LineSegment& segment, const cv::Mat& depth,
                                            const PinholeCamera& camera,
                                            const SegmentDepthOptions& options = {});

}  // namespace highwall
