#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall {

// A delay of depth by which its edges fit those of colour.
struct DelayFit {
  double delay = 0.0;        // [s] by which depth is later than stated
  double sigma = 0.0;        // [s] standard deviation over the images
  double correlation = 0.0;  // of edges, mean over the images
  double usual = 0.0;        // the highest correlation at a delay that is usual
  double better = 0.0;       // share of the images in which it fits better than with that
};

// Compares the edges of depth images with those of colour images that were taken before and after:
// where the camera moves, only those of the same moment fit. Between two images, edges are moved by
// the flow of the colour image as a whole (docs/misconfiguration.md).
class DepthDelayFinder {
 public:
  // [s] of both signs: delays of depth that nobody would correct.
  static constexpr double kUsual = 0.025;

  // raw: CV_16UC1, 0 where nothing was measured. bgr: an odd number of at least three colour images
  // in a row, CV_8UC3 of the same size, the one of the depth image in their middle. interval: [s]
  // between them, > 0. stated: [s] by which depth is later than its colour image as it is known.
  // Images with hardly any edge are left out.
  void Add(const cv::Mat& raw, const std::vector<cv::Mat>& bgr, double interval, double stated);
  // Empty with less than four images that have edges.
  std::optional<DelayFit> Fit() const;
  // Returns the least shift [px] of depth that is left of this one beside a usual delay: the mean
  // over the images, each of which has a motion of its own. The shift itself without images.
  cv::Point2d ShiftBesideDelay(const cv::Point2d& shift) const;

 private:
  struct View {
    std::vector<cv::Mat> maps{};  // correlations over shifts, of depth with each colour image
    cv::Point2d flow{};           // [cells/s] of the colour image
    double interval = 0.0, stated = 0.0;  // [s]
  };
  static double CorrelationAt(const View& view, double delay);
  // Correlations of the images, by delays: those of Delays().
  std::vector<std::vector<double>> Correlations() const;
  std::vector<double> Delays() const;  // [s]

  int cell_ = 1;  // [px]
  std::vector<View> views_{};
};

}  // namespace highwall
