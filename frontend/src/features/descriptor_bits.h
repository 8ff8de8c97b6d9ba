#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/point_extractor.h>

namespace highwall {

// Converts descriptors of any kind to the 256 bits whose Hamming distance is used everywhere else.
// Similar descriptors remain similar:
//
// Floats: bit i is the side of the plane with the normal p_i on which the descriptor lies, its own
// mean subtracted. Two of them differ in 256 / pi bits on average per radian between them (Charikar
// 2002), and the cosine of that angle is their Pearson correlation. The p_i are drawn at random,
// orthogonal to each other up to the number of dimensions, which reduces the variance of the count
// (Ji, Li, Yan, Zhang, Tian: "Super-bit locality-sensitive hashing", 2012).
//
// Bits: 256 of them drawn at random; if there are fewer, all of them repeatedly, so that the
// distance is 256 / (8 columns) times as large on average. 32 columns stay unchanged.
//
// The random choice depends on the number of columns only.
class DescriptorBits {
 public:
  DescriptorBits(DescriptorType type, int columns);

  // descriptors: N x columns of the type. Returns N x 32 CV_8U, empty for none.
  cv::Mat Of(const cv::Mat& descriptors) const;

 private:
  cv::Mat OfFloats(const cv::Mat& descriptors) const;
  cv::Mat OfBits(const cv::Mat& descriptors) const;

  Eigen::MatrixXf normals_;  // columns x 256, for floats
  std::vector<int> drawn_;   // for bits; empty: unchanged
};

}  // namespace highwall
