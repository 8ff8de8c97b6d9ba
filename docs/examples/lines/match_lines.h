#pragma once

#include <vector>

#include <highwall/frontend/features/lbd_line_extractor.h>
#include <highwall/frontend/features/line_matcher.h>

// A line that two images show.
struct LineMatch {
  highwall::LineSegment first, second;  // [px] with the brighter side to the left
  int distance;                         // [bit] between the descriptors, 256 at most
};

// Matches the line segments of two images (CV_8UC1) of a camera that moved a little.
inline std::vector<LineMatch> MatchLines(const cv::Mat& first, const cv::Mat& second) {
  highwall::LbdLineExtractor extractor({.max_lines = 200});
  const highwall::LineFeatures a = extractor.Extract(first);
  const highwall::LineFeatures b = extractor.Extract(second);
  std::vector<LineMatch> matches;
  for (const highwall::FeatureMatch& match : highwall::MatchSmallMotion(a, b)) {
    const auto i = static_cast<std::size_t>(match.query), j = static_cast<std::size_t>(match.train);
    matches.push_back({a.segments[i], b.segments[j], match.distance});
  }
  return matches;
}
