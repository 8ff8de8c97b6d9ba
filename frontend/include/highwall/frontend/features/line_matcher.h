#pragma once

#include <vector>

#include <Eigen/Core>

#include <highwall/frontend/features/line_extractor.h>
#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/orb_matcher.h>

namespace [[gnu::visibility("default")]] highwall {

// Difference a - b of two directions of undirected lines [rad], in [-pi/2, pi/2).
double LineAngleDifference(double a, double b);

// The three gates. `predicted_midpoint`: expected midpoint of `a` in the image of `b` [px].
bool PassesAngleGate(const LineSegment& a, const LineSegment& b, const LineGates& gates);
bool PassesLengthGate(const LineSegment& a, const LineSegment& b, const LineGates& gates);
bool PassesMidpointGate(const Eigen::Vector2f& predicted_midpoint, const LineSegment& b,
                        const LineGates& gates);

// Matches frame to frame: among the pairs within the gates, one-to-one and cheapest first, by the
// Hamming distance if both sides have descriptors, else by the sum of the three gates' normalised
// differences; then RejectByMad(). predicted_midpoints [px]: of query.segments in the image of
// `train`; empty means no motion. Sorted by query. Throws InvalidArgument if sizes do not agree or
// options are bad.
std::vector<FeatureMatch> MatchSmallMotion(
    const LineFeatures& query, const LineFeatures& train, const LineMatcherOptions& options = {},
    const std::vector<Eigen::Vector2f>& predicted_midpoints = {});

// Matches keyframe to keyframe, for loops: mutual nearest LBD within the (wide) gates that pass the
// ratio test; then RejectByMad(). Both sides must have descriptors. Otherwise as
// MatchSmallMotion().
std::vector<FeatureMatch> MatchLargeMotion(
    const LineFeatures& query, const LineFeatures& train, const LineMatcherOptions& options = {},
    const std::vector<Eigen::Vector2f>& predicted_midpoints = {});

// Returns the matches without outliers. kMedian: phi_i = angle of train - angle of query, modulo
// pi; rejected if |phi_i - median| > k 1.4826 median|phi_i - median|. kPaper: phi_i = direction of
// the displacement of the start; rejected if |phi_i - mean| > k standard deviation. Fewer than
// three matches are returned unchanged.
std::vector<FeatureMatch> RejectByMad(const std::vector<FeatureMatch>& matches,
                                      const std::vector<LineSegment>& query,
                                      const std::vector<LineSegment>& train,
                                      const LineMatcherOptions& options = {});

}  // namespace highwall
