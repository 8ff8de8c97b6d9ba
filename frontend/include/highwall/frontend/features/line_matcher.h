#pragma once

#include <vector>

#include <highwall/frontend/features/line_extractor.h>
#include <highwall/frontend/features/orb_matcher.h>
#include <Eigen/Core>

namespace highwall {

// What a pair of segments must fulfil to be a candidate (METHOD.md, section 1; paper 3.1).
struct LineGates {
  double max_angle = 0.1745;            // alpha [rad] between the segments, (0, pi/2]
  double min_length_ratio = 0.5;        // beta, shorter over longer, [0, 1)
  double max_midpoint_distance = 30.0;  // gamma [px] around the predicted midpoint, > 0
};

enum class MadRule {
  kMedian,  // rotation of the segment; median and scaled median absolute deviation
  kPaper,   // as printed: direction of the displacement of the start; mean and standard deviation
};

// "median" or "paper".
const char* ToString(MadRule rule);

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

// a - b of two directions of undirected lines [rad], in [-pi/2, pi/2).
double LineAngleDifference(double a, double b);

// The three gates one by one. `predicted_midpoint`: where the midpoint of `a` is expected in the
// image of `b` [px].
bool PassesAngleGate(const LineSegment& a, const LineSegment& b, const LineGates& gates);
bool PassesLengthGate(const LineSegment& a, const LineSegment& b, const LineGates& gates);
bool PassesMidpointGate(const Eigen::Vector2f& predicted_midpoint, const LineSegment& b,
                        const LineGates& gates);

// Frame to frame: among the pairs within the gates, one-to-one and cheapest first, by the Hamming
// distance where both sides have descriptors, else by the sum of the three gates' normalised
// differences; then RejectByMad(). predicted_midpoints [px]: of query.segments in the image of
// `train`; empty means no motion. Sorted by query.
// Throws InvalidArgument if sizes do not agree or options are bad.
std::vector<FeatureMatch> MatchSmallMotion(
    const LineFeatures& query, const LineFeatures& train, const LineMatcherOptions& options = {},
    const std::vector<Eigen::Vector2f>& predicted_midpoints = {});

// Keyframe to keyframe, loops: mutual nearest LBD within the (wide) gates that pass the ratio
// test; then RejectByMad(). Both sides must have descriptors. Otherwise as MatchSmallMotion().
std::vector<FeatureMatch> MatchLargeMotion(
    const LineFeatures& query, const LineFeatures& train, const LineMatcherOptions& options = {},
    const std::vector<Eigen::Vector2f>& predicted_midpoints = {});

// The matches without outliers. kMedian: phi_i = angle of train - angle of query, modulo pi;
// rejected if |phi_i - median| > k 1.4826 median|phi_i - median|. kPaper: phi_i = direction of the
// displacement of the start; rejected if |phi_i - mean| > k standard deviation. Both leave fewer
// than three matches alone.
std::vector<FeatureMatch> RejectByMad(const std::vector<FeatureMatch>& matches,
                                      const std::vector<LineSegment>& query,
                                      const std::vector<LineSegment>& train,
                                      const LineMatcherOptions& options = {});

}  // namespace highwall
