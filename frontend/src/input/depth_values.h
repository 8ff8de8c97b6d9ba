#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace highwall {

// A sentinel: a stored value that stands for "no reading", in many pixels, and far above all others
// or unlike those next to it.
struct SentinelValue {
  int value = 0;
  double share = 0.0;  // of all pixels
};

// Tests by the stored values of depth images whether they can be depth at all
// (docs/misconfiguration.md).
class DepthValues {
 public:
  // raw: CV_16UC1 as stored, 0 where nothing was measured. bgr: CV_8UC3 of the same size.
  void Add(const cv::Mat& raw, const cv::Mat& bgr);

  // Returns whether each image has one value at nearly all readings.
  bool IsUniform() const;
  // Returns whether all depth images are the same, although their colour images differ.
  bool IsFrozen() const;
  // Returns whether neighbouring readings are wildly different, and much less so if the two bytes
  // of each are exchanged.
  bool HasSwappedBytes() const;
  // Returns the value that stands for "no reading", if it is not 0.
  std::optional<SentinelValue> Sentinel() const;

 private:
  std::optional<SentinelValue> HighestSentinel() const;
  std::optional<SentinelValue> CommonestSentinel() const;

  std::vector<double> commonest_{};  // share of the commonest value among the readings, by image
  std::vector<std::size_t> commonest_value_{};
  std::vector<bool> stands_out_{};  // the commonest value from the readings next to it, by image
  std::vector<double> steps_{}, swapped_steps_{};  // mean relative step to the neighbour, by image
  std::vector<std::uint64_t> histogram_{};
  std::vector<std::size_t> highest_{};      // value, by image
  cv::Mat first_, first_gray_;              // samples of the first image
  std::size_t repeated_ = 0, changed_ = 0;  // images with the depth of the first; other colour
};

}  // namespace highwall
