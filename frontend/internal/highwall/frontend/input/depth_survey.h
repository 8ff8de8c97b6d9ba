#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace [[gnu::visibility("default")]] highwall {

// Grain of depth images near one depth: the deviation of pixels from the plane through their
// neighbours.
struct DepthGrain {
  double depth = 0.0;  // [stored units]
  double sigma = 0.0;  // [stored units] of the smoother half of the surfaces
  std::size_t patches = 0;
};

// Statistics of depth images that characterize their sensor, in stored units: nothing here depends
// on a depth factor.
struct DepthStatistics {
  int width = 0, height = 0;             // [px]
  std::size_t readings = 0;              // number of valid readings
  double nearest = 0.0, farthest = 0.0;  // one reading in a thousand is nearer, or farther
  std::array<double, 5> quantiles{};     // 5, 25, 50, 75 and 95 %
  double holes = 0.0;                    // share of the pixels without a reading
  double edge_holes = 0.0;               // the same in the outer twentieth, on all four sides
  double corner_holes = 0.0;             // the same where two of these overlap
  std::size_t gaps = 0;                  // along rows between a near and a far surface
  double left_holes = 0.0;               // share of these that lie to the left of the near one
  std::optional<double> unit{};          // the values are multiples of it
  std::optional<double> inverse_step{};  // of 1 / value, if readings are quantized in such steps
  double inverse_step_coherence = 0.0;   // [0, 1] how sharp these steps are
  std::vector<DepthGrain> grain{};       // by depth, near to far
};

// Accumulates DepthStatistics, image by image.
class DepthSurvey {
 public:
  // raw: CV_16UC1 as stored, 0 where nothing was measured; all of the same size. Throws
  // InvalidArgument otherwise.
  void Add(const cv::Mat& raw);
  // Throws InvalidArgument before the first image.
  DepthStatistics Describe() const;

 private:
  void AddHoles(const cv::Mat& raw);
  void AddGrain(const cv::Mat& raw);

  std::vector<std::uint64_t> histogram_{};  // of all stored values, 0 included
  int width_ = 0, height_ = 0;
  std::uint64_t edge_ = 0, edge_holes_ = 0, corner_ = 0, corner_holes_ = 0;
  std::uint64_t left_gaps_ = 0, right_gaps_ = 0;
  std::map<int, std::vector<float>> residuals_{};  // by third octaves of depth
};

}  // namespace highwall
