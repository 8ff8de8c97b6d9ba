#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
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

// A point observed by an image, and its observations by the latest keyframes of the map.
struct SeenPoint {
  PointId id = kNoId;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  const PointFeature* feature = nullptr;
  std::vector<MapView<PointFeature>> views;
};
// A line observed by an image, and its observations by the latest keyframes of the map.
struct SeenLine {
  LineId id = kNoId;
  Segment3 segment_W;
  const LineFeature* feature = nullptr;
  std::vector<MapView<LineFeature>> views;
};

// The landmarks of the map observed by an image.
struct SeenLandmarks {
  std::vector<std::shared_ptr<const FrameFeatures>> features;  // owners of the features pointed to
  std::vector<SeenPoint> points;
  std::vector<SeenLine> lines;
  double error = 1.0;  // |r|^2 per degree of freedom over all observations at the pose of the image
};

// Returns the landmarks that an image observes. points, lines: those of the features, kNoId if
// unmatched; as in TrackedFrame.
SeenLandmarks FindSeen(const Map& map, const std::shared_ptr<const FrameFeatures>& features,
                       std::span<const PointId> points, std::span<const LineId> lines,
                       double error);

}  // namespace highwall
