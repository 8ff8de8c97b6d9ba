#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/abi.h>
#include <highwall/frontend/features/frame.h>

namespace [[gnu::visibility("default")]] highwall {

// A match of row `query` of one feature set with row `train` of another.
struct FeatureMatch {
  int query = -1;
  int train = -1;
  int distance = 0;  // [bit] Hamming distance; 0 if no descriptors were compared

  bool operator==(const FeatureMatch&) const = default;
};

// Returns the number of differing bits of two descriptors of 32 bytes, in [0, 256].
int HammingDistance(const std::uint8_t* a, const std::uint8_t* b);

// Options of MatchDescriptors.
struct OrbMatcherOptions {
  int max_distance = 64;  // [bit] between matched descriptors, [0, 256]
  double ratio = 0.8;     // best < ratio x second best, (0, 1]; 1 turns the test off
  bool mutual = true;     // the query must also be the best match of its match

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Finds nearest neighbours by brute force. query, train: N x 32 and M x 32, CV_8U; either may be
// empty. Ties go to the lower row. Sorted by query, at most one match each; one-to-one if `mutual`.
// Throws InvalidArgument for another shape or type.
std::vector<FeatureMatch> MatchDescriptors(const cv::Mat& query, const cv::Mat& train,
                                           const OrbMatcherOptions& options = {});

}  // namespace highwall
