#pragma once

#include <memory>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_ids.h>

namespace [[gnu::visibility("default")]] highwall {

// Observation of a landmark by a keyframe of the map.
template <class Feature>
struct MapView {
  Pose T_WC;
  const Feature* feature = nullptr;
};

// A landmark observed by an image, and its observations by the latest keyframes of the map.
template <class Landmark>
struct SeenLandmark {
  using Traits = LandmarkTraits<Landmark>;

  Id<Landmark> id = kNoId;
  typename Traits::Geometry geometry_W;
  const typename Traits::Feature* feature = nullptr;
  std::vector<MapView<typename Traits::Feature>> views;
};
// Those of one kind.
template <class Landmark>
using SeenOfKind = std::vector<SeenLandmark<Landmark>>;

// The landmarks of the map observed by an image.
struct SeenLandmarks : PerKind<SeenOfKind> {
  std::vector<std::shared_ptr<const FrameFeatures>> features;  // owners of the features pointed to
  double error = 1.0;  // |r|^2 per degree of freedom over all observations at the pose of the image
};

// Returns the landmarks that an image observes. matched: those of the features, kNoId if unmatched,
// such as a KeyFrame.
SeenLandmarks FindSeen(const Map& map, const std::shared_ptr<const FrameFeatures>& features,
                       const PerKind<LandmarkIds>& matched, double error);

}  // namespace highwall
