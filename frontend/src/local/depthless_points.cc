#include "local/depthless_landmarks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/frontend/local/triangulation.h>

#include "map/epipolar_matcher.h"

namespace highwall {
namespace {

// Best against second best of the corners on each other's epipolar line.
constexpr double kDistinctive = 0.8;

PointView ViewOf(const KeyFrame& keyframe, int index) {
  return {keyframe.T_WC, keyframe.frame.features->points[static_cast<std::size_t>(index)]};
}

// Returns |r|^2 of one view over its bound; a view with more than 1 is inconsistent.
double Misfit(const MeasurementModel& model, const InlierBounds& inliers, const PointView& view,
              const Eigen::Vector3d& p_W) {
  return model.Chi2(view.feature, view.T_WC, p_W) /
         inliers.Of(MeasurementModel::Dimension(view.feature));
}

// Returns whether the distance from the newest view is accurate enough.
bool IsSound(const TriangulatedPoint& point, const Pose& T_WC, double max_depth_sigma) {
  const Eigen::Vector3d axis_W = T_WC.R().col(2);
  const double depth = axis_W.dot(point.p_W - T_WC.p());
  return axis_W.dot(point.covariance * axis_W) <= std::pow(max_depth_sigma * depth, 2);
}

}  // namespace

bool HasSoundDepth(const PointFeature& feature, double max_depth_sigma) {
  return feature.depth > 0.0 && feature.depth_sigma <= max_depth_sigma * feature.depth;
}

std::vector<Depthless<MapPoint>> FindDepthlessPoints(const MeasurementModel& model, const Map& map,
                                                     KeyFrameId id,
                                                     std::span<const KeyFrameId> neighbours,
                                                     const TriangulationOptions& options,
                                                     const InlierBounds& inliers) {
  const KeyFrame& keyframe = *map.keyframe(id);
  const FrameFeatures& features = *keyframe.frame.features;
  std::vector<bool> wanted(features.points.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = keyframe.points[i] == kNoId;
  std::vector<Track<PointView>> tracks(wanted.size());
  const EpipolarMatchOptions match{.max_hamming = model.options().max_hamming.triangulation,
                                   .ratio = kDistinctive,
                                   .chi2 = inliers.Of(1)};
  for (const KeyFrameId n : neighbours) {
    const KeyFrame& neighbour = *map.keyframe(n);
    std::vector<bool> free(neighbour.points.size());
    std::transform(neighbour.points.begin(), neighbour.points.end(), free.begin(),
                   [](PointId p) { return p == kNoId; });
    for (const auto& [own, other] :
         MatchEpipolar(model, {features, keyframe.T_WC, wanted},
                       {*neighbour.frame.features, neighbour.T_WC, free}, match)) {
      tracks[static_cast<std::size_t>(own)].Add(ViewOf(neighbour, other), {n, other});
    }
  }
  std::vector<Depthless<MapPoint>> found;
  const auto triangulate = [&](std::span<const PointView> views) {
    return TriangulatePoint(model, views);
  };
  const auto misfits = [&](const TriangulatedPoint& point, std::span<const PointView> views) {
    std::vector<double> all;
    for (const PointView& view : views) all.push_back(Misfit(model, inliers, view, point.p_W));
    return all;
  };
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track<PointView>& track = tracks[i];
    if (track.views.empty()) continue;
    const int own = static_cast<int>(i);
    track.AddFirst(ViewOf(keyframe, own), {id, own});
    const auto point = EstimateAgreeing(track, options.min_views, triangulate, misfits);
    if (!point || !IsSound(*point, keyframe.T_WC, options.max_depth_sigma)) continue;
    found.push_back({point->p_W, std::move(track.observations)});
  }
  return found;
}

}  // namespace highwall
