#pragma once

#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/features/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Inlier thresholds on |r|^2 of the whitened rows of an observation, by their number. 95 % of those
// with correct noise lie within (quantiles of chi-square).
struct InlierBounds {
  double chi2_1 = 3.841;  // > 0
  double chi2_2 = 5.991;  // > 0
  double chi2_3 = 7.815;  // > 0
  double chi2_4 = 9.488;  // > 0

  // rows: 1 to 4.
  double Of(int rows) const;
  // Thresholds of 99.73 % for 2, 3 and 4 rows, as three sigmas are for one: for rows that are
  // noisier than modelled.
  static InlierBounds ThreeSigma() { return {9.0, 11.829, 14.156, 16.251}; }
  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Minimum number of landmarks that two keyframes must share
inline constexpr int kSharedToSearch = 10;  // to search the landmarks of one in the other
inline constexpr int kSharedByPlace = 15;   // to belong to one place: adjusted and culled together
inline constexpr int kSharedByEdge = 50;    // to be connected by an edge of the pose graph

// Criteria for matching the descriptors of a landmark and a corner.
struct ProjectionMatchOptions {
  int max_hamming = 100;         // [bit] 0 to 256
  double ratio = 0.9;            // (0, 1]: best against second best of the same pyramid level
  double max_angle_diff = 30.0;  // [deg] between expected and observed orientation

  void Validate() const;
};

// Options of the search for landmarks in an image.
struct MapMatcherOptions {
  double motion_radius = 15.0;  // [px] > 0: search window around the landmarks of the last frame
  double map_radius = 4.0;  // [px] > 0: around those of the local map; both scale with the level
  double min_view_cosine = 0.5;  // [-1, 1]: against the mean viewing direction of the point
  ProjectionMatchOptions motion_match{.max_hamming = 100, .ratio = 0.9};
  ProjectionMatchOptions map_match{.max_hamming = 100, .ratio = 0.8};
  float min_line_pixels = 15.0F;  // [px] >= 1: shorter projections are not searched

  void Validate() const;
};

// Options of the measurement model: how observations become weighted residuals.
struct MeasurementOptions {
  Weighting weighting = Weighting::kCovariance;  // of the rows that carry depth
  double baseline = 0.08;                        // [m] > 0: of the virtual right camera
  double point_sigma = 0.7;    // [px] > 0: of a corner at pyramid level 0; grows with the level
  double line_sigma = 1.0;     // [px] > 0: of a segment's end, across it
  MapMatcherOptions search{};  // for landmarks, by projection
  LineMatcherOptions line_matches{};  // matching of segments between two images

  void Validate() const;
};

// Options of KeyFrameIndex, the search for similar keyframes.
struct KeyFrameIndexOptions {
  int tables = 4;  // [1, 12]: more find more similar descriptors, at proportional cost
  // [bit] [0, 32]: of the signature, in which similar descriptors may differ
  int max_signature_bits = 6;
  double line_weight = 2.0;  // >= 0: of a line's vote relative to a point's: a line has two ends

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
