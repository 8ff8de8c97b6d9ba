#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// Criteria for matching the descriptors of a landmark and a corner.
struct ProjectionMatchOptions {
  int max_hamming = 100;         // [bit] 0 to 256
  double ratio = 0.9;            // (0, 1]: best against second best of the same pyramid level
  double max_angle_diff = 30.0;  // [deg] between expected and observed orientation
};

// Predicted observation of a landmark in an image.
struct ProjectedPoint {
  PointId id = kNoId;
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();  // [px] undistorted
  double depth = 0.0;                            // [m] along z
  double radius = 0.0;                           // [px] of the search window
  int min_octave = 0, max_octave = 0;            // pyramid levels searched, inclusive
  std::optional<float> angle;                    // [deg] expected orientation, if known
  BinaryDescriptor256 descriptor{};
};

struct ProjectionMatch {
  int feature = 0;     // index in the frame
  int projection = 0;  // index in the list
  int hamming = 0;
};

// Returns the best feature of `features` for each projection, one to one: of two projections with
// the same best feature the one with the closer descriptor is matched. taken[i]: feature i is not
// available.
std::vector<ProjectionMatch> MatchProjections(const FrameFeatures& features,
                                              std::span<const ProjectedPoint> projections,
                                              const std::vector<bool>& taken,
                                              const ProjectionMatchOptions& options = {});

// Returns the visible part of a segment, in undistorted pixels; empty if it is behind min_depth [m]
// or outside of the image.
std::optional<LineSegment> ProjectSegment(const Segment3& segment_C, const PinholeCamera& camera,
                                          double min_depth = 0.1);

}  // namespace highwall
