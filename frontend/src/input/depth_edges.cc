#include "input/depth_edges.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <opencv2/imgproc.hpp>

#include "input/edge_maps.h"

namespace highwall {
namespace {

constexpr std::size_t kLeastImages = 4;
// Shares of the view that are tried, each this much larger than the one before, all of them another
// view: near to the right one, edges fit by chance. The largest shift beside them, of the width.
constexpr double kNarrowest = 0.5, kWidest = 1.5, kWider = 1.06, kAnotherView = 1.1;
constexpr double kReachOfView = 0.05;

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

// Mean without the greatest: a single image with few edges may fit anywhere.
double MeanOfOthers(const std::vector<double>& values) {
  const double count = static_cast<double>(values.size());
  return (count * Mean(values) - std::ranges::max(values)) / (count - 1.0);
}

}  // namespace

void DepthEdges::Add(const cv::Mat& raw, const cv::Mat& bgr) {
  const EdgeMaps edges = EdgeMapsOf(raw, {bgr});
  cell_ = edges.cell;
  if (!edges.has_edges || InnerPart(edges.depth).empty()) return;
  const cv::Mat &depth = edges.depth, &colour = edges.colour.front();
  std::array<cv::Mat, kFlips>& maps = maps_.emplace_back();
  for (int flip = 0; flip < kFlips; ++flip) {
    maps[static_cast<std::size_t>(flip)] =
        ShiftCorrelations(colour, Flipped(depth, static_cast<DepthFlip>(flip)));
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
