#include "local/depthless_landmarks.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <highwall/frontend/local/triangulation.h>

#include "map/epipolar_line_matcher.h"

namespace highwall {
namespace {

LineView ViewOf(const MeasurementModel& model, const KeyFrame& keyframe, int index) {
  const LineFeature& line = keyframe.frame.features->lines[static_cast<std::size_t>(index)];
  return {keyframe.T_WC, line.segment, model.LineSigma(line)};
}

// Returns which segments have neither a landmark nor depth for one.
std::vector<bool> WithoutLandmark(const KeyFrame& keyframe) {
  std::vector<bool> without(keyframe.lines.size());
  for (std::size_t i = 0; i < without.size(); ++i) {
    without[i] = keyframe.lines[i] == kNoId && !keyframe.frame.features->lines[i].segment_C;
  }
  return without;
}

// Returns whether the distance of both ends is accurate enough.
bool IsSound(const LineInView& line, double max_depth_sigma) {
  const Eigen::Array2d sigma = line.covariance.diagonal().tail<2>().array().sqrt();
  return (sigma <= max_depth_sigma * line.inverse_depth.array()).all();
}

}  // namespace

std::vector<Depthless<MapLine>> FindDepthlessLines(const MeasurementModel& model, const Map& map,
                                                   KeyFrameId id,
                                                   std::span<const KeyFrameId> neighbours,
                                                   const TriangulationOptions& options,
                                                   const InlierBounds& inliers) {
  const KeyFrame& keyframe = *map.keyframe(id);
  const std::vector<bool> wanted = WithoutLandmark(keyframe);
  std::vector<Track<LineView>> tracks(wanted.size());
  for (const KeyFrameId n : neighbours) {
    const KeyFrame& neighbour = *map.keyframe(n);
    const std::vector<bool> free = WithoutLandmark(neighbour);
    for (const auto& [own, other] :
         MatchEpipolarLines(model, {*keyframe.frame.features, keyframe.T_WC, wanted},
                            {*neighbour.frame.features, neighbour.T_WC, free}, inliers.Of(1))) {
      tracks[static_cast<std::size_t>(own)].Add(ViewOf(model, neighbour, other), {n, other});
    }
  }
  const auto triangulate = [&](std::span<const LineView> views) {
    return TriangulateLine(model, views);
  };
  const auto misfits = [&](const TriangulatedLine& line, std::span<const LineView>) {
    std::vector<double> all = line.squared_errors;
    for (double& misfit : all) misfit /= inliers.Of(2);
    return all;
  };
  constexpr int kLeastViews = 3;
  std::vector<Depthless<MapLine>> found;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track<LineView>& track = tracks[i];
    if (track.views.empty()) continue;
    const int own = static_cast<int>(i);
    track.AddFirst(ViewOf(model, keyframe, own), {id, own});
    const auto line =
        EstimateAgreeing(track, std::max(options.min_views, kLeastViews), triangulate, misfits);
    if (!line || !IsSound(line->seen, options.max_depth_sigma)) continue;
    found.push_back({line->segment_W, std::move(track.observations)});
  }
  return found;
}

}  // namespace highwall
