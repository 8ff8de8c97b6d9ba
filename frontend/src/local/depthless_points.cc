#include "local/depthless_points.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "local/triangulation.h"
#include "map/epipolar_matcher.h"

namespace highwall {
namespace {

// The views of one corner, and the observations that they are.
struct Track {
  std::vector<PointView> views;
  std::vector<Observation> observations;
};

PointView ViewOf(const KeyFrame& keyframe, int index) {
  return {keyframe.T_WC, keyframe.frame.features->points[static_cast<std::size_t>(index)]};
}

// |r|^2 of one view over what is allowed; more than 1 does not fit.
double Misfit(const MeasurementModel& model, const InlierBounds& inliers, const PointView& view,
              const Eigen::Vector3d& p_W) {
  return model.Chi2(view.feature, view.T_WC, p_W) /
         inliers.Of(MeasurementModel::Dimension(view.feature));
}

// The largest set of views that agree, worst ones left out one by one.
std::optional<TriangulatedPoint> TriangulateAgreeing(const MeasurementModel& model,
                                                     const InlierBounds& inliers, Track& track) {
  while (track.views.size() >= 2) {
    const auto point = TriangulatePoint(model, track.views);
    if (!point) return std::nullopt;
    std::vector<double> misfits;
    for (const PointView& view : track.views) {
      misfits.push_back(Misfit(model, inliers, view, point->p_W));
    }
    const auto worst = std::max_element(misfits.begin(), misfits.end());
    if (*worst <= 1.0) return point;
    // The first is the corner that is looked for.
    const auto other = std::max_element(misfits.begin() + 1, misfits.end()) - misfits.begin();
    track.views.erase(track.views.begin() + other);
    track.observations.erase(track.observations.begin() + other);
  }
  return std::nullopt;
}

// The distance is known from the newest view on.
bool IsSound(const TriangulatedPoint& point, const Pose& T_WC, double max_depth_sigma) {
  const Eigen::Vector3d axis_W = T_WC.R().col(2);
  const double depth = axis_W.dot(point.p_W - T_WC.p());
  return axis_W.dot(point.covariance * axis_W) <= std::pow(max_depth_sigma * depth, 2);
}

}  // namespace

bool HasSoundDepth(const PointFeature& feature, double max_depth_sigma) {
  return feature.depth > 0.0 && feature.depth_sigma <= max_depth_sigma * feature.depth;
}

std::vector<DepthlessPoint> FindDepthlessPoints(const MeasurementModel& model, const Map& map,
                                                KeyFrameId id,
                                                std::span<const KeyFrameId> neighbours,
                                                const TriangulationOptions& options,
                                                const InlierBounds& inliers) {
  const KeyFrame& keyframe = *map.keyframe(id);
  const FrameFeatures& features = *keyframe.frame.features;
  std::vector<bool> wanted(features.points.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = keyframe.points[i] == kNoId;
  std::vector<Track> tracks(wanted.size());
  const EpipolarMatchOptions match{
      .max_hamming = options.max_hamming, .ratio = options.ratio, .chi2 = inliers.Of(1)};
  for (const KeyFrameId n : neighbours) {
    const KeyFrame& neighbour = *map.keyframe(n);
    std::vector<bool> free(neighbour.points.size());
    std::transform(neighbour.points.begin(), neighbour.points.end(), free.begin(),
                   [](PointId p) { return p == kNoId; });
    for (const auto& [own, other] :
         MatchEpipolar(model, {features, keyframe.T_WC, wanted},
                       {*neighbour.frame.features, neighbour.T_WC, free}, match)) {
      Track& track = tracks[static_cast<std::size_t>(own)];
      track.views.push_back(ViewOf(neighbour, other));
      track.observations.push_back({n, other});
    }
  }
  std::vector<DepthlessPoint> found;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track& track = tracks[i];
    if (track.views.empty()) continue;
    const int own = static_cast<int>(i);
    track.views.insert(track.views.begin(), ViewOf(keyframe, own));
    track.observations.insert(track.observations.begin(), {id, own});
    const auto point = TriangulateAgreeing(model, inliers, track);
    if (!point || static_cast<int>(track.views.size()) < options.min_views) continue;
    if (!IsSound(*point, keyframe.T_WC, options.max_depth_sigma)) continue;
    found.push_back({point->p_W, std::move(track.observations)});
  }
  return found;
}

}  // namespace highwall
