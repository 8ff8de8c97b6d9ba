#include "input/depth_delay.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

#include "input/edge_maps.h"

namespace highwall {
namespace {

constexpr std::size_t kLeastViews = 4;
constexpr double kStep = 0.0025;  // [s] between the delays that are tried
constexpr double kLongest = 2.0;  // [s]

// Value of a map between its cells; that of its border outside of it.
double ValueAt(const cv::Mat& map, const cv::Point2d& at) {
  const double x = std::clamp(at.x, 0.0, map.cols - 1.001);
  const double y = std::clamp(at.y, 0.0, map.rows - 1.001);
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  const double a = x - u, b = y - v;
  const auto value = [&](int du, int dv) {
    return static_cast<double>(map.at<float>(v + dv, u + du));
  };
  return (1.0 - b) * ((1.0 - a) * value(0, 0) + a * value(1, 0)) +
         b * ((1.0 - a) * value(0, 1) + a * value(1, 1));
}

// Sums of the correlations of all images.
std::vector<double> SumsOf(const std::vector<std::vector<double>>& correlations) {
  std::vector<double> sums;
  for (const std::vector<double>& of_delay : correlations) {
    sums.push_back(Mean(of_delay) * static_cast<double>(of_delay.size()));
  }
  return sums;
}

std::size_t IndexOfMost(const std::vector<double>& values) {
  return static_cast<std::size_t>(std::ranges::max_element(values) - values.begin());
}

}  // namespace

void DepthDelayFinder::Add(const cv::Mat& raw, const std::vector<cv::Mat>& bgr, double interval,
                           double stated) {
  const EdgeMaps edges = EdgeMapsOf(raw, bgr);
  if (!edges.has_edges || InnerPart(edges.depth).empty()) return;
  cell_ = edges.cell;
  View& view = views_.emplace_back();
  view.interval = interval;
  view.stated = stated;
  for (const cv::Mat& colour : edges.colour) {
    view.maps.push_back(ShiftCorrelations(colour, edges.depth));
  }
  const std::size_t middle = bgr.size() / 2;
  const cv::Mat between = ShiftCorrelations(edges.colour[middle + 1], edges.colour[middle]);
  cv::Point cell;
  view.flow = (PeakOf(between, &cell) - cv::Point2d(CentreOf(between))) / interval;
}

// The colour image nearest to the moment of depth, and the flow in between.
double DepthDelayFinder::CorrelationAt(const View& view, double delay) {
  const double images = (delay + view.stated) / view.interval;
  const double middle = static_cast<double>(view.maps.size() / 2);
  const double nearest = std::clamp(std::round(images), -middle, middle);
  const cv::Mat& map = view.maps[static_cast<std::size_t>(nearest + middle)];
  const double beyond = (images - nearest) * view.interval;  // [s]
  return ValueAt(map, cv::Point2d(CentreOf(map)) - beyond * view.flow);
}

std::vector<double> DepthDelayFinder::Delays() const {
  double most = kLongest;
  for (const View& view : views_) {
    const double around = static_cast<double>(view.maps.size() / 2);
    most = std::min(most, (around + 0.4) * view.interval - std::abs(view.stated));
  }
  std::vector<double> delays;
  for (double delay = -kStep * std::floor(most / kStep); delay <= most; delay += kStep) {
    delays.push_back(delay);
  }
  return delays;
}

std::vector<std::vector<double>> DepthDelayFinder::Correlations() const {
  std::vector<std::vector<double>> correlations;
  for (const double delay : Delays()) {
    std::vector<double>& of_delay = correlations.emplace_back();
    for (const View& view : views_) of_delay.push_back(CorrelationAt(view, delay));
  }
  return correlations;
}

std::optional<DelayFit> DepthDelayFinder::Fit() const {
  if (views_.size() < kLeastViews) return std::nullopt;
  const std::vector<double> delays = Delays();
  if (delays.empty()) return std::nullopt;
  const std::vector<std::vector<double>> correlations = Correlations();
  const std::vector<double> sums = SumsOf(correlations);
  const std::size_t best = IndexOfMost(sums);
  const double count = static_cast<double>(views_.size());
  DelayFit fit{.delay = delays[best], .correlation = sums[best] / count};
  std::size_t usual = best;
  fit.usual = -1.0;
  for (std::size_t i = 0; i < delays.size(); ++i) {
    const double mean = sums[i] / count;
    if (std::abs(delays[i]) <= kUsual && mean > fit.usual) {
      fit.usual = mean;
      usual = i;
    }
  }
  fit.better = ShareOfGreater(correlations[best], correlations[usual]);
  // Leaving out one image after the other shows how far the delay depends on single images.
  double squares = 0.0;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    std::vector<double> others = sums;
    for (std::size_t k = 0; k < others.size(); ++k) others[k] -= correlations[k][i];
    squares += std::pow(delays[IndexOfMost(others)] - fit.delay, 2);
  }
  fit.sigma = std::sqrt((count - 1.0) / count * squares);
  return fit;
}

cv::Point2d DepthDelayFinder::ShiftBesideDelay(const cv::Point2d& shift) const {
  if (views_.empty()) return shift;
  cv::Point2d flow;  // [px/s] mean
  for (const View& view : views_) flow += view.flow * (cell_ / static_cast<double>(views_.size()));
  cv::Point2d least = shift;
  for (double delay = -kUsual; delay <= kUsual; delay += kStep) {
    const cv::Point2d left = shift - delay * flow;
    if (left.dot(left) < least.dot(least)) least = left;
  }
  return least;
}

}  // namespace highwall
