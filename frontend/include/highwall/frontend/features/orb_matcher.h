#pragma once

#include <cstdint>
#include <vector>

#include <highwall/core/abi.h>
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

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

// Finds keypoints around a place in the image without looking at the others.
class FeatureGrid {
 public:
  FeatureGrid() = default;
  // cell_size: [px] best near the radius of the queries, > 0. Keypoints outside of the image are
  // found as well. Throws InvalidArgument on a bad size or a position that is not finite.
  FeatureGrid(const std::vector<cv::KeyPoint>& keypoints, const cv::Size& image_size,
              double cell_size = 20.0);

  // Indices of the keypoints within `radius` [px] of `centre` whose octave lies in
  // [min_octave, max_octave], in an order that depends on the keypoints alone.
  std::vector<int> Query(const Eigen::Vector2d& centre, double radius, int min_octave,
                         int max_octave) const;
  // The same into *indices, whose memory is reused.
  void Query(const Eigen::Vector2d& centre, double radius, int min_octave, int max_octave,
             std::vector<int>* indices) const;

  std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    float x, y;
    int octave, index;
  };

  int Column(double x) const;
  int Row(double y) const;

  double cell_size_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<int> cell_begin_;  // entries of cell c: [cell_begin_[c], cell_begin_[c + 1])
  std::vector<Entry> entries_;
};

}  // namespace highwall
