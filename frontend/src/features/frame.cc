#include <highwall/frontend/features/frame.h>

namespace highwall {

std::shared_ptr<const FrameFeatures> Select(const FrameFeatures& features,
                                            const std::vector<bool>& points,
                                            const std::vector<bool>& lines, const cv::Size& size) {
  auto selected = std::make_shared<FrameFeatures>();
  selected->sharpness = features.sharpness;
  selected->brightness = features.brightness;
  selected->depth_grid = features.depth_grid;
  selected->gray_grid = features.gray_grid;
  selected->gray = features.gray;
  std::vector<cv::KeyPoint> places;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i]) continue;
    const PointFeature& point = features.points[i];
    selected->points.push_back(point);
    selected->point_descriptors.push_back(features.point_descriptors.row(static_cast<int>(i)));
    places.emplace_back(static_cast<float>(point.uv.x()), static_cast<float>(point.uv.y()), 1.0F,
                        point.angle, 0.0F, point.octave);
  }
  selected->point_grid = FeatureGrid(places, size);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!lines[i]) continue;
    selected->lines.push_back(features.lines[i]);
    if (features.line_descriptors.empty()) continue;
    selected->line_descriptors.push_back(features.line_descriptors.row(static_cast<int>(i)));
  }
  return selected;
}

}  // namespace highwall
