#pragma once

#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"

namespace highwall {

// Tests by depth whether two views show the same place: neither can look through a surface that the
// other observes; views of two similar places do so in both directions. Counts the readings of
// depth grids that project to a reading of another, and those whose point lies in front of it, by
// more than noise and a few hundredths of the depth explain.
class DepthComparison {
 public:
  // grid: of all images; must outlive this.
  DepthComparison(const DepthGrid& grid, const DepthNoise& noise) : grid_(grid), noise_(noise) {}

  // Adds a comparison. DepthGrid::Sample of two images, T_AB: between the cameras. Ignored if one
  // of them is empty.
  void Add(const cv::Mat& depth_A, const cv::Mat& depth_B, const Pose& T_AB);

  // Adds the counts of another comparison, of the same grid.
  void Add(const DepthComparison& other);

  // Returns the share of contradictions: the smaller one of both directions, because a change of
  // the scene contradicts in one direction alone. Empty if less than a twentieth of a grid could be
  // compared.
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
  // Looks up the readings of `from` in `onto`.
  Count LookUp(const cv::Mat& from, const cv::Mat& onto, const Pose& T_onto_from) const;

  const DepthGrid& grid_;
  DepthNoise noise_;
  Count a_in_b_, b_in_a_;
};

// Returns the contradiction between a frame and some keyframes; depth, T_WC: of the frame, in the
// world of the keyframes. Keyframes without a depth grid, of an old map file, are ignored.
std::optional<double> DepthContradiction(const cv::Mat& depth, const Pose& T_WC,
                                         std::span<const KeyFrameId> keyframes, const Map& map,
                                         const DepthGrid& grid, const DepthNoise& noise);

}  // namespace highwall
