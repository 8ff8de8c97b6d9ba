#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall {

// How a depth image may lie over its colour image.
enum class DepthFlip { kNone, kLeftRight, kUpsideDown, kHalfTurn };

// A flip and a shift by which the edges of the depth images fit those of the colour images.
struct EdgeFit {
  DepthFlip flip = DepthFlip::kNone;
  double shift_u = 0.0, shift_v = 0.0;  // [px] that depth lies to the right of and below colour
  double sigma_u = 0.0, sigma_v = 0.0;  // [px] standard deviations over the images
  double correlation = 0.0;             // of edges, mean over the images
  double better = 0.0;  // share of the images in which it fits better than what it is compared with
  // By how many of its standard deviations the mean is higher than that of the images as they are.
  double sigmas = 0.0;
};

// A share of the view of colour that depth may show, in the middle of it.
struct ViewFit {
  double share = 1.0;        // above 1: depth shows more than colour does
  double spread = 0.0;       // largest relative change of the share if one image is left out
  double correlation = 0.0;  // of edges, mean over the images
  double better = 0.0;       // share of the images in which it fits better than the best shift
};

// Compares the edges of depth images with those of their colour images: where a near surface ends
// before a far one, colour mostly changes as well. The correlation of edges is computed over
// shifts, flips and fields of view (docs/misconfiguration.md).
class DepthEdges {
 public:
  // raw: CV_16UC1, 0 where nothing was measured. bgr: CV_8UC3 of the same size. Images with hardly
  // any edge are left out.
  void Add(const cv::Mat& raw, const cv::Mat& bgr);
  // Returns the correlation of the images as they are, and the best fits by a shift, by a flip with
  // a shift, and by another field of view than that of colour: `better` of the first against the
  // images as they are, of the others against the best shift. Empty with less than four images that
  // have edges.
  struct Result {
    double correlation = 0.0;
    EdgeFit shifted, flipped;
    ViewFit view;
  };
  std::optional<Result> Fit() const;

 private:
  static constexpr int kFlips = 4;

  EdgeFit FitOf(DepthFlip flip, cv::Point* cell) const;
  // Correlations of the images at a cell of the maps of a flip.
  std::vector<double> Correlations(DepthFlip flip, const cv::Point& cell) const;
  // shifted: correlations of the images with the best shift.
  ViewFit FitOfView(const std::vector<double>& shifted) const;
  // Correlations of the images, but for one of them, by a share of the view, at its best shift.
  std::vector<double> ViewCorrelations(std::size_t share, std::optional<std::size_t> without) const;

  int cell_ = 1;  // [px] of a cell of the correlation maps
  std::vector<std::array<cv::Mat, kFlips>> maps_{};
  std::vector<std::vector<cv::Mat>> views_{};  // of each image, by shares
};

}  // namespace highwall
