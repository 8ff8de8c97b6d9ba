#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/stamp.h>
#include <highwall/frontend/features/feature_grid.h>
#include <highwall/frontend/features/line_segment.h>
#include <highwall/frontend/features/segment_3d.h>

namespace highwall {

// One point observation: an ORB corner with its depth where the sensor gave one.
struct PointFeature {
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();  // [px] undistorted
  double depth = 0.0;                            // [m] along z; 0 = none
  double depth_sigma = 0.0;                      // [m] standard deviation of depth, > 0 with it
  int octave = 0;                                // pyramid level
  float angle = 0.0f;                            // [deg] intensity-centroid orientation
  bool faint = false;  // weaker than OrbExtractorOptions::min_fast_threshold: may be mere noise
};

// One line observation: an undistorted segment with its end points in C where depth allowed a fit.
struct LineFeature {
  LineSegment segment;                    // [px] undistorted
  std::optional<SegmentDepth> segment_C;  // [m]
};

// The features of one image, immutable once built; shared by the tracker and by keyframes.
struct FrameFeatures {
  double sharpness = 0.0;   // [grey levels] mean step between neighbouring pixels
  double brightness = 0.0;  // [grey levels] mean
  std::vector<PointFeature> points;
  cv::Mat point_descriptors;  // N x 32 CV_8U, a row a point
  FeatureGrid point_grid;
  std::vector<LineFeature> lines;
  cv::Mat line_descriptors;  // M x 32 CV_8U, or empty
  cv::Mat depth_grid;        // DepthGrid::Sample; empty where it is not known
  cv::Mat gray_grid;  // DepthGrid::Average of the image; empty where the features were loaded
};

// The features that are to be kept, one flag each, in the same order. size: of the image.
std::shared_ptr<const FrameFeatures> Select(const FrameFeatures& features,
                                            const std::vector<bool>& points,
                                            const std::vector<bool>& lines, const cv::Size& size);

// What is known of one image.
struct Frame {
  std::int64_t index = 0;  // counted from 0 over the frames fed
  Stamp stamp = 0;
  std::shared_ptr<const FrameFeatures> features;
};

}  // namespace highwall
