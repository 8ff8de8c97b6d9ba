#include "input/depth_edges.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <opencv2/imgproc.hpp>

namespace highwall {
namespace {

constexpr int kColumns = 160;          // of the maps of edges, about
constexpr int kAround = 13;            // cells along a side of the surroundings of a cell
constexpr double kReach = 0.1;         // largest shift that is searched, of the width
constexpr double kEdgeRatio = 1.06;    // of the depths on both sides of an edge
constexpr double kLongestGap = 0.06;   // of the width: holes between the two sides
constexpr float kStrongest = 40.0F;    // [grey levels] a stronger edge of colour counts as this
constexpr double kLeastEdges = 0.003;  // share of the pixels
constexpr std::size_t kLeastImages = 4;
// Shares of the view that are tried, each this much larger than the one before, all of them another
// view: near to the right one, edges fit by chance. The largest shift beside them, of the width.
constexpr double kNarrowest = 0.5, kWidest = 1.5, kWider = 1.06, kAnotherView = 1.1;
constexpr double kReachOfView = 0.05;

// Marks the nearer side of each step of depth along a row or a column.
void MarkSteps(const cv::Mat& raw, bool down, cv::Mat* edges) {
  const int lines = down ? raw.cols : raw.rows, count = down ? raw.rows : raw.cols;
  const int longest = std::max(2, static_cast<int>(kLongestGap * raw.cols));
  const auto at = [&](int line, int i) { return down ? cv::Point(line, i) : cv::Point(i, line); };
  for (int line = 0; line < lines; ++line) {
    int last = -1;
    double before = 0.0;
    for (int i = 0; i < count; ++i) {
      const double value = raw.at<std::uint16_t>(at(line, i));
      if (value == 0.0) continue;
      if (last >= 0 && i - last <= longest) {
        if (value > kEdgeRatio * before) edges->at<float>(at(line, last)) = 1.0F;
        if (before > kEdgeRatio * value) edges->at<float>(at(line, i)) = 1.0F;
      }
      last = i;
      before = value;
    }
  }
}

// Reduces edges to cells, relative to those around: textured ground and bare sky differ by much
// more than an edge from what is next to it, and would fit over anything that is as unevenly
// spread.
cv::Mat Reduced(const cv::Mat& edges, int cell) {
  cv::Mat small, smooth, around;
  cv::resize(edges, small, {edges.cols / cell, edges.rows / cell}, 0.0, 0.0, cv::INTER_AREA);
  cv::GaussianBlur(small, smooth, {3, 3}, 0.8);
  cv::blur(smooth, around, {kAround, kAround});
  const double mean = cv::mean(smooth)[0];
  return (smooth - around) / (around + 0.5 * mean);
}

cv::Mat EdgesOfColour(const cv::Mat& bgr, int cell) {
  cv::Mat gray, smooth, du, dv, edges;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::blur(gray, smooth, {3, 3});
  cv::Sobel(smooth, du, CV_32F, 1, 0, 1, 0.5);
  cv::Sobel(smooth, dv, CV_32F, 0, 1, 1, 0.5);
  cv::magnitude(du, dv, edges);
  cv::min(edges, kStrongest, edges);
  cv::sqrt(edges, edges);
  return Reduced(edges, cell);
}

cv::Mat Flipped(const cv::Mat& image, DepthFlip flip) {
  cv::Mat flipped;
  switch (flip) {
    case DepthFlip::kNone:
      return image;
    case DepthFlip::kLeftRight:
      cv::flip(image, flipped, 1);
      break;
    case DepthFlip::kUpsideDown:
      cv::flip(image, flipped, 0);
      break;
    case DepthFlip::kHalfTurn:
      cv::flip(image, flipped, -1);
      break;
  }
  return flipped;
}

std::vector<double> ViewShares() {
  std::vector<double> shares;
  for (double share = kNarrowest; share < kWidest; share *= kWider) {
    if (std::max(share, 1.0 / share) > kAnotherView) shares.push_back(share);
  }
  return shares;
}

// Correlations of a map of depth that shows this share of the view of the map of colour, over
// shifts of up to `reach` cells.
cv::Mat CorrelationsOfView(const cv::Mat& colour, const cv::Mat& depth, double share, int reach) {
  cv::Mat scaled;
  cv::resize(depth, scaled, {}, share, share, share < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  const auto middle = [](const cv::Mat& of, const cv::Size& size) {
    return of(cv::Rect({(of.cols - size.width) / 2, (of.rows - size.height) / 2}, size));
  };
  const cv::Size part(std::min(scaled.cols, colour.cols - 2 * reach),
                      std::min(scaled.rows, colour.rows - 2 * reach));
  const cv::Size searched(part.width + 2 * reach, part.height + 2 * reach);
  cv::Mat map;
  cv::matchTemplate(middle(colour, searched), middle(scaled, part), map, cv::TM_CCOEFF_NORMED);
  return map;
}

cv::Mat MeanOf(const std::vector<const cv::Mat*>& maps) {
  cv::Mat sum = cv::Mat::zeros(maps.front()->size(), CV_32F);
  for (const cv::Mat* map : maps) sum += *map;
  return sum / static_cast<double>(maps.size());
}

// Position of the maximum of a map, between its cells.
cv::Point2d PeakOf(const cv::Mat& map, cv::Point* cell) {
  cv::minMaxLoc(map, nullptr, nullptr, nullptr, cell);
  const auto refine = [](double before, double here, double after) {
    const double bend = before + after - 2.0 * here;
    return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
  };
  cv::Point2d peak(*cell);
  const auto at = [&](int dx, int dy) {
    return static_cast<double>(map.at<float>(cell->y + dy, cell->x + dx));
  };
  if (cell->x > 0 && cell->x + 1 < map.cols) peak.x += refine(at(-1, 0), at(0, 0), at(1, 0));
  if (cell->y > 0 && cell->y + 1 < map.rows) peak.y += refine(at(0, -1), at(0, 0), at(0, 1));
  return peak;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Mean without the greatest: a single image with few edges may fit anywhere.
double MeanOfOthers(const std::vector<double>& values) {
  const double count = static_cast<double>(values.size());
  return (count * Mean(values) - std::ranges::max(values)) / (count - 1.0);
}

// Standard deviation of the mean.
double SigmaOfMean(const std::vector<double>& values) {
  const double mean = Mean(values), count = static_cast<double>(values.size());
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / (count * (count - 1.0)));
}

double ShareOfGreater(const std::vector<double>& values, const std::vector<double>& others) {
  std::size_t greater = 0;
  for (std::size_t i = 0; i < values.size(); ++i) greater += values[i] > others[i] ? 1 : 0;
  return static_cast<double>(greater) / static_cast<double>(values.size());
}

// Mean difference in its standard deviations.
double SigmasApart(std::vector<double> values, const std::vector<double>& others) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= others[i];
  const double sigma = SigmaOfMean(values);
  return sigma > 0.0 ? Mean(values) / sigma : 0.0;
}

// The cell of no shift.
cv::Point CentreOf(const cv::Mat& map) {
  return {map.cols / 2, map.rows / 2};
}

}  // namespace

void DepthEdges::Add(const cv::Mat& raw, const cv::Mat& bgr) {
  // Every other pixel shows all that is left in a cell.
  const int apart = raw.cols >= 2 * kColumns ? 2 : 1;
  const int cells = std::max(1, raw.cols / apart / kColumns);
  cell_ = cells * apart;
  const cv::Size size(raw.cols / apart, raw.rows / apart);
  cv::Mat small_raw, small_bgr;
  cv::resize(raw, small_raw, size, 0.0, 0.0, cv::INTER_NEAREST);
  cv::resize(bgr, small_bgr, size, 0.0, 0.0, cv::INTER_AREA);
  cv::Mat steps = cv::Mat::zeros(size, CV_32F);
  MarkSteps(small_raw, false, &steps);
  MarkSteps(small_raw, true, &steps);
  if (cv::mean(steps)[0] < kLeastEdges) return;
  const cv::Mat colour = EdgesOfColour(small_bgr, cells), depth = Reduced(steps, cells);
  const int reach = static_cast<int>(std::lround(kReach * depth.cols));
  const cv::Rect inner(reach, reach, depth.cols - 2 * reach, depth.rows - 2 * reach);
  if (inner.width < 2 * reach || inner.height < 2 * reach) return;
  std::array<cv::Mat, kFlips>& maps = maps_.emplace_back();
  for (int flip = 0; flip < kFlips; ++flip) {
    const cv::Mat part = Flipped(depth, static_cast<DepthFlip>(flip))(inner);
    cv::matchTemplate(colour, part, maps[static_cast<std::size_t>(flip)], cv::TM_CCOEFF_NORMED);
  }
  const int view_reach = static_cast<int>(std::lround(kReachOfView * depth.cols));
  std::vector<cv::Mat>& views = views_.emplace_back();
  for (const double share : ViewShares()) {
    views.push_back(CorrelationsOfView(colour, depth, share, view_reach));
  }
}

std::vector<double> DepthEdges::Correlations(DepthFlip flip, const cv::Point& cell) const {
  std::vector<double> correlations;
  for (const auto& maps : maps_) {
    const cv::Mat& map = maps[static_cast<std::size_t>(flip)];
    correlations.push_back(static_cast<double>(map.at<float>(cell)));
  }
  return correlations;
}

EdgeFit DepthEdges::FitOf(DepthFlip flip, cv::Point* cell) const {
  EdgeFit fit{.flip = flip};
  std::vector<const cv::Mat*> all;
  for (const auto& maps : maps_) all.push_back(&maps[static_cast<std::size_t>(flip)]);
  const cv::Point2d peak = PeakOf(MeanOf(all), cell);
  const cv::Point2d centre = CentreOf(*all.front());
  fit.shift_u = (centre.x - peak.x) * cell_;
  fit.shift_v = (centre.y - peak.y) * cell_;
  fit.correlation = Mean(Correlations(flip, *cell));
  // Leaving out one image after the other shows how far the peak depends on single images.
  std::vector<double> u, v;
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<const cv::Mat*> others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    cv::Point ignored;
    const cv::Point2d other = PeakOf(MeanOf(others), &ignored);
    u.push_back(other.x * cell_);
    v.push_back(other.y * cell_);
  }
  const double jackknife = static_cast<double>(all.size()) - 1.0;
  fit.sigma_u = jackknife * SigmaOfMean(u);
  fit.sigma_v = jackknife * SigmaOfMean(v);
  return fit;
}

std::vector<double> DepthEdges::ViewCorrelations(std::size_t share,
                                                 std::optional<std::size_t> without) const {
  std::vector<const cv::Mat*> maps;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (i != without) maps.push_back(&views_[i][share]);
  }
  cv::Point cell;
  PeakOf(MeanOf(maps), &cell);
  std::vector<double> correlations;
  for (const cv::Mat* map : maps) correlations.push_back(static_cast<double>(map->at<float>(cell)));
  return correlations;
}

ViewFit DepthEdges::FitOfView(const std::vector<double>& shifted) const {
  const std::vector<double> shares = ViewShares();
  const auto best = [&](std::optional<std::size_t> without) {
    std::vector<double> means;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      means.push_back(MeanOfOthers(ViewCorrelations(i, without)));
    }
    return static_cast<std::size_t>(std::ranges::max_element(means) - means.begin());
  };
  const std::size_t whole = best(std::nullopt);
  const std::vector<double> correlations = ViewCorrelations(whole, std::nullopt);
  ViewFit fit{.share = shares[whole],
              .correlation = Mean(correlations),
              .better = ShareOfGreater(correlations, shifted)};
  for (std::size_t i = 0; i < views_.size(); ++i) {
    fit.spread = std::max(fit.spread, std::abs(shares[best(i)] / fit.share - 1.0));
  }
  return fit;
}

std::optional<DepthEdges::Result> DepthEdges::Fit() const {
  if (maps_.size() < kLeastImages) return std::nullopt;
  const std::vector<double> as_they_are =
      Correlations(DepthFlip::kNone, CentreOf(maps_.front().front()));
  Result result{.correlation = Mean(as_they_are), .shifted = {}, .flipped = {}, .view = {}};
  cv::Point cell;
  result.shifted = FitOf(DepthFlip::kNone, &cell);
  const std::vector<double> shifted = Correlations(DepthFlip::kNone, cell);
  result.shifted.better = ShareOfGreater(shifted, as_they_are);
  result.shifted.sigmas = SigmasApart(shifted, as_they_are);
  result.view = FitOfView(shifted);
  for (const DepthFlip flip :
       {DepthFlip::kLeftRight, DepthFlip::kUpsideDown, DepthFlip::kHalfTurn}) {
    EdgeFit fit = FitOf(flip, &cell);
    const std::vector<double> flipped = Correlations(flip, cell);
    fit.better = ShareOfGreater(flipped, shifted);
    fit.sigmas = SigmasApart(flipped, as_they_are);
    if (flip == DepthFlip::kLeftRight || fit.correlation > result.flipped.correlation) {
      result.flipped = fit;
    }
  }
  return result;
}

}  // namespace highwall
