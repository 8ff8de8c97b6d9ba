#include <highwall/frontend/features/frame.h>

#include "features/feature_kinds.h"

namespace highwall {
namespace {

// Returns the rows whose flag is set; none if there are no descriptors.
cv::Mat SelectRows(const cv::Mat& descriptors, const std::vector<bool>& kept) {
  cv::Mat selected;
  if (descriptors.empty()) return selected;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i]) selected.push_back(descriptors.row(static_cast<int>(i)));
  }
  return selected;
}

}  // namespace

FeatureGrid GridOf(const std::vector<PointFeature>& points, const cv::Size& size) {
  std::vector<cv::KeyPoint> places;
  places.reserve(points.size());
  for (const PointFeature& point : points) {
    places.emplace_back(static_cast<float>(point.uv.x()), static_cast<float>(point.uv.y()), 1.0F,
                        point.angle, 0.0F, point.octave);
  }
  return {places, size};
}

std::shared_ptr<const FrameFeatures> Select(const FrameFeatures& features, const FeatureFlags& kept,
                                            const cv::Size& size) {
  auto selected = std::make_shared<FrameFeatures>();
  selected->sharpness = features.sharpness;
  selected->brightness = features.brightness;
  selected->depth_grid = features.depth_grid;
  selected->gray_grid = features.gray_grid;
  selected->gray = features.gray;
  ForEachKindOfFeature(
      [](const auto& all, const std::vector<bool>& flags, auto& list) {
        for (std::size_t i = 0; i < flags.size(); ++i) {
          if (flags[i]) list.push_back(all[i]);
        }
      },
      features, kept, *selected);
  selected->point_descriptors = SelectRows(features.point_descriptors, kept.points);
  selected->line_descriptors = SelectRows(features.line_descriptors, kept.lines);
  selected->point_grid = GridOf(selected->points, size);
  return selected;
}

}  // namespace highwall
