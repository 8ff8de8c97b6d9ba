#pragma once

#include <opencv2/core.hpp>

#include <simulate/random.h>

namespace highwall::bench {

// Returns independent Gaussian numbers of mean 0 for each pixel and channel. type: CV_32FC1 or
// CV_32FC3.
inline cv::Mat NormalField(cv::Size size, int type, double sigma,
                           const simulate::CounterRandom& random) {
  cv::Mat field(size, type);
  cv::RNG(random.Bits(0)).fill(field, cv::RNG::NORMAL, 0.0, sigma);
  return field;
}

// Returns numbers in [0, 1), CV_32FC1.
inline cv::Mat UniformField(cv::Size size, const simulate::CounterRandom& random) {
  cv::Mat field(size, CV_32FC1);
  cv::RNG(random.Bits(0)).fill(field, cv::RNG::UNIFORM, 0.0, 1.0);
  return field;
}

}  // namespace highwall::bench
