#include <highwall/frontend/map/seen_landmarks.h>

#include <cstddef>
#include <set>
#include <utility>

namespace highwall {
namespace {

// Number of keyframes; earlier ones add little information on the position of a landmark.
constexpr std::size_t kMostViews = 5;

// Collects the observations of landmarks in a map.
class Finder {
 public:
  explicit Finder(const Map& map) : map_(map) {}

  // Returns the latest observations. of_kind: the features of a keyframe.
  template <class Feature>
  std::vector<MapView<Feature>> LatestViews(const std::vector<Observation>& observations,
                                            std::vector<Feature> FrameFeatures::*of_kind) {
    std::vector<MapView<Feature>> views;
    for (std::size_t i = observations.size(); i-- > 0 && views.size() < kMostViews;) {
      const KeyFrame* keyframe = map_.keyframe(observations[i].keyframe);
      if (keyframe == nullptr) continue;
      if (known_.insert(keyframe->id).second) kept_.push_back(keyframe->frame.features);
      const std::vector<Feature>& features = (*keyframe->frame.features).*of_kind;
      views.push_back({keyframe->T_WC, &features[static_cast<std::size_t>(observations[i].index)]});
    }
    return views;
  }
  std::vector<std::shared_ptr<const FrameFeatures>> TakeFeatures() { return std::move(kept_); }

 private:
  const Map& map_;
  std::set<KeyFrameId> known_;
  std::vector<std::shared_ptr<const FrameFeatures>> kept_;
};

}  // namespace

SeenLandmarks FindSeen(const Map& map, const std::shared_ptr<const FrameFeatures>& features,
                       std::span<const PointId> points, std::span<const LineId> lines,
                       double error) {
  SeenLandmarks seen;
  seen.error = error;
  Finder finder(map);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const MapPoint* point = map.Find(points[i]);
    if (point == nullptr) continue;
    seen.points.push_back({point->id, point->p_W, &features->points[i],
                           finder.LatestViews(point->observations, &FrameFeatures::points)});
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const MapLine* line = map.Find(lines[i]);
    if (line == nullptr) continue;
    seen.lines.push_back({line->id, line->segment_W, &features->lines[i],
                          finder.LatestViews(line->observations, &FrameFeatures::lines)});
  }
  seen.features = finder.TakeFeatures();
  seen.features.push_back(features);
  return seen;
}

}  // namespace highwall
