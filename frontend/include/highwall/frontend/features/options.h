#pragma once

#include <cstdint>

namespace [[gnu::visibility("default")]] highwall {

// Of the images that corners are found in, the whole one first.
struct PyramidOptions {
  int levels = 8;             // [1, 16]
  double scale_factor = 1.2;  // between neighbouring levels, (1, 2]

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How corners are found.
struct OrbExtractorOptions {
  int features = 1000;  // most keypoints of an image, > 0
  PyramidOptions pyramid{};
  int fast_threshold = 20;  // [grey levels] of FAST, [1, 255]
  // For cells where fast_threshold finds nothing, [1, fast_threshold]. Where the whole image has
  // fewer than `features` corners even so, empty cells are searched down to the noise of the image.
  int min_fast_threshold = 7;
  bool subpixel = true;  // refine corners below the pixel of their level

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// What finds the points of an image.
enum class PointDetector {
  kOrb,   // corners
  kSift,  // blobs: fewer, told apart better, and far slower to find
};

// "orb" or "sift".
const char* ToString(PointDetector detector);

// How blobs are found.
struct SiftExtractorOptions {
  int features = 1000;               // most keypoints of an image, > 0
  double contrast_threshold = 0.04;  // as cv::SIFT has it, > 0: less finds fainter ones

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// What finds the segments of an image.
enum class LineDetector {
  kLsd,      // von Gioi, Jakubowicz, Morel, Randall 2010; the paper's choice
  kEdLines,  // Akinlar, Topal 2011: as many lines in a fifth of the time
};

// "lsd" or "edlines".
const char* ToString(LineDetector detector);

// How segments are found.
struct LineExtractorOptions {
  LineDetector detector = LineDetector::kEdLines;
  double min_length = 0.04;  // shortest segment, as a share of the longer image side, (0, 1]
  int max_lines = 150;       // the longest are kept, > 0
  bool merge = true;         // join collinear fragments of one edge
  bool refine = true;        // fit each segment to the sub-pixel peaks of the gradient across it
  bool descriptors = true;   // compute LBD

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// How a segment gets its depth.
struct SegmentDepthOptions {
  int samples = 24;            // places along the segment, [4, 64]; four depth pixels at each
  double min_valid = 0.5;      // share of the samples of a side that must be measurements, (0, 1]
  double min_inliers = 0.6;    // share of the measurements that must fit the line, (0, 1]
  int ransac_iterations = 16;  // for each side, > 0
  std::uint32_t seed = 1;      // of the drawn pairs: equal input gives equal output

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// What features a frame has.
struct FrameBuilderOptions {
  PointDetector point_detector = PointDetector::kOrb;
  OrbExtractorOptions orb{};
  SiftExtractorOptions sift{};
  LineExtractorOptions lines{};
  SegmentDepthOptions segment_depth{};
  bool use_points = true;
  bool use_lines = true;
  // Share of the depth spread among a corner's neighbouring pixels that joins its depth noise,
  // >= 0: colour and depth are registered to no better than a pixel or two, so that beside a depth
  // edge the reading may be that of the other side.
  double depth_spread_share = 1.0;
  bool parallel = true;  // points and lines on two threads; the result is the same

  void Validate() const;
};

// What a pair of segments must fulfil to be a candidate (docs/equations.md, section 1).
struct LineGates {
  double max_angle = 0.1745;            // alpha [rad] between the segments, (0, pi/2]
  double min_length_ratio = 0.5;        // beta, shorter over longer, [0, 1)
  double max_midpoint_distance = 30.0;  // gamma [px] around the predicted midpoint, > 0
};

// What the matched segments of two images are held against.
enum class MadRule {
  kMedian,  // rotation of the segment; median and scaled median absolute deviation
  kPaper,   // as printed: direction of the displacement of the start; mean and standard deviation
};

// "median" or "paper".
const char* ToString(MadRule rule);

// Which segments of two images may be one line.
struct LineMatcherOptions {
  LineGates small_motion = {};  // frame to frame
  LineGates large_motion{.max_angle = 0.6, .min_length_ratio = 0.3, .max_midpoint_distance = 200.0};
  int max_distance = 80;  // [bit] between matched LBD, [0, 256]
  double ratio = 0.85;    // large motion: best < ratio x second best, (0, 1]; 1 turns it off
  MadRule mad_rule = MadRule::kMedian;
  double mad_k = 3.0;             // deviations beyond which a match is an outlier, > 0
  double min_deviation = 0.0087;  // [rad] kMedian: no deviation is taken as smaller than this, >= 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
