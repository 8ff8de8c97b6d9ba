#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

namespace highwall {

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
