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

// Hamming distances [bit] up to which a corner may be a landmark, all in [0, 256]. Descriptors of
// another extractor may need others (docs/user_features.md).
struct MaxHammingOptions {
  int projection = 100;     // near the place where the landmark is expected
  int relocalization = 60;  // anywhere in the image
  int triangulation = 50;   // between corners without depth, on each other's epipolar line
};

// Options of the measurement model: how observations become weighted residuals, and which features
// may match.
struct MeasurementOptions {
  Weighting weighting = Weighting::kCovariance;  // of the rows that carry depth
  double baseline = 0.08;                        // [m] > 0: of the virtual right camera
  double point_sigma = 0.7;  // [px] > 0: of a corner at pyramid level 0; grows with the level
  double line_sigma = 1.0;   // [px] > 0: of a segment's end, across it
  // [px] > 0: search window around the landmarks of the last frame; grows with the level
  double motion_radius = 15.0;
  MaxHammingOptions max_hamming{};
  MadRule mad_rule = MadRule::kMedian;  // outliers among the matched segments

  void Validate() const;
};

// Further criteria of a match, which are no options of SlamSystem.
struct MatchingOptions {
  double map_radius = 4.0;        // [px] > 0: search window around landmarks of the local map
  double min_view_cosine = 0.5;   // [-1, 1]: against the mean viewing direction of the point
  float min_line_pixels = 15.0F;  // [px] >= 1: shorter projections are not searched
  // (0, 1]: best against second best of the same pyramid level, among landmarks of the last frame
  // and of the local map
  double motion_ratio = 0.9;
  double map_ratio = 0.8;
  double max_angle_diff = 30.0;  // [deg] > 0: between expected and observed orientation
  LineMatcherOptions lines{};    // mad_rule: that of MeasurementOptions instead

  // Throws InvalidArgument naming the field.
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
