#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/abi.h>
#include <highwall/frontend/features/frame.h>

namespace highwall {

// Row `query` of one feature set matched with row `train` of another.
struct FeatureMatch {
  int query = -1;
  int train = -1;
  int distance = 0;  // [bit] Hamming distance; 0 where no descriptors were compared

  bool operator==(const FeatureMatch&) const = default;
};

// Bits that differ between two descriptors of 32 bytes, in [0, 256].
int HammingDistance(const std::uint8_t* a, const std::uint8_t* b);

struct OrbMatcherOptions {
  int max_distance = 64;  // [bit] between matched descriptors, [0, 256]
  double ratio = 0.8;     // best < ratio x second best, (0, 1]; 1 turns the test off
  bool mutual = true;     // the query must be the best of its match as well

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Brute-force nearest neighbours. query, train: N x 32 and M x 32, CV_8U; either may be empty.
// Ties go to the lower row. By query, at most one match each; one-to-one where `mutual`.
// Throws InvalidArgument on another shape or type.
std::vector<FeatureMatch> MatchDescriptors(const cv::Mat& query, const cv::Mat& train,
                                           const OrbMatcherOptions& options = {});

}  // namespace highwall
