#pragma once

#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"

namespace highwall {

// Two views of one place cannot look through what the other sees; views of two places that look
// alike do, either way. Counts the readings of depth grids that fall on a reading of another, and
// those whose point lies before it, by more than noise and a few hundredths of the depth explain.
class DepthComparison {
 public:
  // grid: of all images; must outlive this.
  DepthComparison(const DepthGrid& grid, const DepthNoise& noise) : grid_(grid), noise_(noise) {}

  // DepthGrid::Sample of two images, T_AB: between the cameras. Nothing where one of them is empty.
  void Add(const cv::Mat& depth_A, const cv::Mat& depth_B, const Pose& T_AB);

  // What another one has counted, of the same grid.
  void Add(const DepthComparison& other);

  // The share that contradicts: the smaller of the two ways, for what has come or gone is seen one
  // way alone. Empty where less than a twentieth of a grid was to be compared.
  std::optional<double> Contradiction() const;

 private:
  struct Count {
    int compared = 0, contradict = 0;
    void operator+=(const Count& more) {
      compared += more.compared;
      contradict += more.contradict;
    }
    double Share() const { return static_cast<double>(contradict) / compared; }
  };
  // Readings of `from` looked up in `onto`.
  Count LookUp(const cv::Mat& from, const cv::Mat& onto, const Pose& T_onto_from) const;

  const DepthGrid& grid_;
  DepthNoise noise_;
  Count a_in_b_, b_in_a_;
};

// Of a frame with some keyframes; depth, T_WC: of the frame, as the keyframes are supposed to have
// it. Keyframes without a depth grid, of an old map file, say
// nothing.
std::optional<double> DepthContradiction(const cv::Mat& depth, const Pose& T_WC,
                                         std::span<const KeyFrameId> keyframes, const Map& map,
                                         const DepthGrid& grid, const DepthNoise& noise);

}  // namespace highwall
