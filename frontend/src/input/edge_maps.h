#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall {

// Maps of edges of a depth image and of colour images, relative to those around: textured ground
// and bare sky differ by much more than an edge from what is next to it, and would fit over
// anything that is as unevenly spread.
struct EdgeMaps {
  int cell = 1;                   // [px] of a cell of the maps
  bool has_edges = true;          // false: depth has hardly any
  cv::Mat depth{};                // CV_32FC1
  std::vector<cv::Mat> colour{};  // CV_32FC1, of each colour image
};

// raw: CV_16UC1, 0 where nothing was measured. bgr: CV_8UC3 of the same size each.
EdgeMaps EdgeMapsOf(const cv::Mat& raw, const std::vector<cv::Mat>& bgr);

// Returns the inner part of a map that stays within the map if it is shifted as far as is searched,
// a tenth of the width; empty for a map that is too small.
cv::Rect InnerPart(const cv::Mat& map);
// Returns the correlations of the inner part of a map with another map, CV_32FC1, over these
// shifts; the cell in the middle is that of no shift.
cv::Mat ShiftCorrelations(const cv::Mat& map, const cv::Mat& part);

cv::Mat MeanOf(const std::vector<const cv::Mat*>& maps);
// Returns the position of the maximum of a map, between its cells.
cv::Point2d PeakOf(const cv::Mat& map, cv::Point* cell);
// The cell of no shift.
cv::Point CentreOf(const cv::Mat& map);

double Mean(const std::vector<double>& values);
// Standard deviation of the mean of independent values.
double SigmaOfMean(const std::vector<double>& values);
double ShareOfGreater(const std::vector<double>& values, const std::vector<double>& others);
// Mean difference in its standard deviations.
double SigmasApart(std::vector<double> values, const std::vector<double>& others);

}  // namespace highwall
