#include <highwall/frontend/features/frame.h>

namespace highwall {

FeatureGrid GridOf(const std::vector<PointFeature>& points, const cv::Size& size) {
  std::vector<cv::KeyPoint> places;
  places.reserve(points.size());
  for (const PointFeature& point : points) {
    places.emplace_back(static_cast<float>(point.uv.x()), static_cast<float>(point.uv.y()), 1.0F,
                        point.angle, 0.0F, point.octave);
  }
  return {places, size};
}

std::shared_ptr<const FrameFeatures> Select(const FrameFeatures& features,
                                            const std::vector<bool>& points,
                                            const std::vector<bool>& lines, const cv::Size& size) {
  auto selected = std::make_shared<FrameFeatures>();
  selected->sharpness = features.sharpness;
  selected->brightness = features.brightness;
  selected->depth_grid = features.depth_grid;
  selected->gray_grid = features.gray_grid;
  selected->gray = features.gray;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i]) continue;
    selected->points.push_back(features.points[i]);
    selected->point_descriptors.push_back(features.point_descriptors.row(static_cast<int>(i)));
  }
  selected->point_grid = GridOf(selected->points, size);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!lines[i]) continue;
    selected->lines.push_back(features.lines[i]);
    if (features.line_descriptors.empty()) continue;
    selected->line_descriptors.push_back(features.line_descriptors.row(static_cast<int>(i)));
  }
  return selected;
}

}  // namespace highwall
