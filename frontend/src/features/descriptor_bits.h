#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/point_extractor.h>

namespace highwall {

// Brings descriptors of any kind to the 256 bits that are compared by their Hamming distance
// everywhere else. What is alike stays alike:
//
// Floats: bit i says on which side of the plane with the normal p_i the descriptor lies, its own
// mean taken off. Two of them differ in 256 / pi bits on average for each radian between them
// (Charikar 2002), and the cosine of that angle is their Pearson correlation. The p_i are drawn at
// random, orthogonal to each other as far as there are dimensions, which makes the count scatter
// less (Ji, Li, Yan, Zhang, Tian: "Super-bit locality-sensitive hashing", 2012).
//
// Bits: 256 of them drawn at random, where there are fewer all of them again and again, so that the
// distance is 256 / (8 columns) times as large on average. 32 columns stay as they are.
//
// What is drawn follows from the number of columns alone.
class DescriptorBits {
 public:
  DescriptorBits(DescriptorType type, int columns);

  // descriptors: N x columns of the type. N x 32 CV_8U, empty for none.
  cv::Mat Of(const cv::Mat& descriptors) const;

 private:
  cv::Mat OfFloats(const cv::Mat& descriptors) const;
  cv::Mat OfBits(const cv::Mat& descriptors) const;

  Eigen::MatrixXf normals_;  // columns x 256, of floats
  std::vector<int> drawn_;   // of bits; empty: all as they are
};

}  // namespace highwall
