#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace [[gnu::visibility("default")]] highwall {

// The grain of depth images about one depth: how far pixels lie off the plane through the pixels
// around them.
struct DepthGrain {
  double depth = 0.0;  // [stored units]
  double sigma = 0.0;  // [stored units] of the calmer half of the surfaces
  std::size_t patches = 0;
};

// What depth images show of their sensor, in the units they are stored in: nothing here depends on
// a depth factor.
struct DepthStatistics {
  int width = 0, height = 0;             // [px]
  std::size_t readings = 0;              // that were measured
  double nearest = 0.0, farthest = 0.0;  // one reading in a thousand is nearer, or farther
  std::array<double, 5> quantiles{};     // 5, 25, 50, 75 and 95 %
  double holes = 0.0;                    // share of the pixels that hold no reading
  double edge_holes = 0.0;               // the same of the outer twentieth, on all four sides
  double corner_holes = 0.0;             // and where two of these meet
  std::size_t gaps = 0;                  // along rows between a near and a far surface
  double left_holes = 0.0;               // share of these that lie to the left of the near one
  std::optional<double> unit{};          // what the values are multiples of
  std::optional<double> inverse_step{};  // of 1 / value, where readings stand in such steps
  double inverse_step_coherence = 0.0;   // [0, 1] how sharply they do
  std::vector<DepthGrain> grain{};       // by depth, near to far
};

// Gathers them, image by image.
class DepthSurvey {
 public:
  // raw: CV_16UC1 as stored, 0 where nothing was measured; all of one size. Throws InvalidArgument
  // otherwise.
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
