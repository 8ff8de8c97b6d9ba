#include "input/edge_maps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/core.hpp>
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

// Reduces edges to cells, relative to those around.
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

}  // namespace

EdgeMaps EdgeMapsOf(const cv::Mat& raw, const std::vector<cv::Mat>& bgr) {
  // Every other pixel shows all that is left in a cell.
  const int apart = raw.cols >= 2 * kColumns ? 2 : 1;
  const int cells = std::max(1, raw.cols / apart / kColumns);
  const cv::Size size(raw.cols / apart, raw.rows / apart);
  EdgeMaps maps{.cell = cells * apart};
  cv::Mat small;
  cv::resize(raw, small, size, 0.0, 0.0, cv::INTER_NEAREST);
  cv::Mat steps = cv::Mat::zeros(size, CV_32F);
  MarkSteps(small, false, &steps);
  MarkSteps(small, true, &steps);
  maps.has_edges = !(cv::mean(steps)[0] < kLeastEdges);
  if (!maps.has_edges) return maps;
  maps.depth = Reduced(steps, cells);
  for (const cv::Mat& image : bgr) {
    cv::Mat small_image;
    cv::resize(image, small_image, size, 0.0, 0.0, cv::INTER_AREA);
    maps.colour.push_back(EdgesOfColour(small_image, cells));
  }
  return maps;
}

cv::Rect InnerPart(const cv::Mat& map) {
  const int reach = static_cast<int>(std::lround(kReach * map.cols));
  const cv::Rect inner(reach, reach, map.cols - 2 * reach, map.rows - 2 * reach);
  const bool is_small = reach < 1 || inner.width < 2 * reach || inner.height < 2 * reach;
  return is_small ? cv::Rect() : inner;
}

cv::Mat ShiftCorrelations(const cv::Mat& map, const cv::Mat& part) {
  cv::Mat correlations;
  cv::matchTemplate(map, part(InnerPart(part)), correlations, cv::TM_CCOEFF_NORMED);
  return correlations;
}

cv::Mat MeanOf(const std::vector<const cv::Mat*>& maps) {
  cv::Mat sum = cv::Mat::zeros(maps.front()->size(), CV_32F);
  for (const cv::Mat* map : maps) sum += *map;
  return sum / static_cast<double>(maps.size());
}

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

cv::Point CentreOf(const cv::Mat& map) {
  return {map.cols / 2, map.rows / 2};
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

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

double SigmasApart(std::vector<double> values, const std::vector<double>& others) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= others[i];
  const double sigma = SigmaOfMean(values);
  return sigma > 0.0 ? Mean(values) / sigma : 0.0;
}

}  // namespace highwall
