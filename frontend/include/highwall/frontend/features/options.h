#pragma once

namespace [[gnu::visibility("default")]] highwall {

// Image pyramid in which corners are detected, the full resolution first.
struct PyramidOptions {
  int levels = 8;             // [1, 16]
  double scale_factor = 1.2;  // between neighbouring levels, (1, 2]

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of the ORB corner detector.
struct OrbExtractorOptions {
  int features = 1000;  // maximum number of keypoints per image, > 0
  PyramidOptions pyramid{};
  int fast_threshold = 20;  // [grey levels] of FAST, [1, 255]
  // Threshold of cells in which fast_threshold detects nothing, [1, fast_threshold]. If the whole
  // image still has fewer than `features` corners, empty cells are searched down to the image
  // noise.
  int min_fast_threshold = 7;
  bool subpixel = true;  // refine corners to sub-pixel accuracy of their level

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Detector of the points of an image.
enum class PointDetector {
  kOrb,   // corners
  kSift,  // blobs: fewer, more distinctive, and much slower to detect
};

// Returns "orb" or "sift".
const char* ToString(PointDetector detector);

// Options of the SIFT blob detector.
struct SiftExtractorOptions {
  int features = 1000;               // maximum number of keypoints per image, > 0
  double contrast_threshold = 0.04;  // as in cv::SIFT, > 0: a lower value detects weaker ones

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Detector of the line segments of an image.
enum class LineDetector {
  kLsd,      // von Gioi, Jakubowicz, Morel, Randall 2010; the paper's choice
  kEdLines,  // Akinlar, Topal 2011: more lines in a tenth of the time
};

// Returns "lsd" or "edlines".
const char* ToString(LineDetector detector);

// Options of LbdLineExtractor.
struct LineExtractorOptions {
  LineDetector detector = LineDetector::kEdLines;
  double min_length = 0.04;  // shortest segment, as a share of the longer image side, (0, 1]
  int max_lines = 150;       // the longest are kept, > 0
  bool merge = true;         // join collinear fragments of one edge
  bool refine = true;        // fit each segment to the sub-pixel peaks of the gradient across it
  bool descriptors = true;   // compute LBD descriptors

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Options of FrameBuilder: the features of a frame.
struct FrameBuilderOptions {
  PointDetector point_detector = PointDetector::kOrb;
  OrbExtractorOptions orb{};
  SiftExtractorOptions sift{};
  LineExtractorOptions lines{};
  bool use_points = true;
  bool use_lines = true;

  void Validate() const;
};

// Gates that a pair of segments must pass to be a candidate (docs/equations.md, section 1).
struct LineGates {
  double max_angle = 0.1745;            // alpha [rad] between the segments, (0, pi/2]
  double min_length_ratio = 0.5;        // beta, shorter over longer, [0, 1)
  double max_midpoint_distance = 30.0;  // gamma [px] around the predicted midpoint, > 0
};

// Statistic by which outliers among the matched segments of two images are rejected.
enum class MadRule {
  kMedian,  // rotation of the segment; median and scaled median absolute deviation
  kPaper,   // as printed: direction of the displacement of the start; mean and standard deviation
};

// Returns "median" or "paper".
const char* ToString(MadRule rule);

// Options of LineMatcher: which segments of two images may be the same line.
struct LineMatcherOptions {
  LineGates small_motion = {};  // frame to frame
  LineGates large_motion{.max_angle = 0.6, .min_length_ratio = 0.3, .max_midpoint_distance = 200.0};
  int max_distance = 80;  // [bit] between matched LBD, [0, 256]
  double ratio = 0.85;    // large motion: best < ratio x second best, (0, 1]; 1 turns it off
  MadRule mad_rule = MadRule::kMedian;
  double mad_k = 3.0;             // deviations beyond which a match is an outlier, > 0
  double min_deviation = 0.0087;  // [rad] kMedian: lower bound of the deviation, >= 0

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
