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

namespace highwall {

// How a keyframe of the map sees a landmark.
template <class Feature>
struct MapView {
  Pose T_WC;
  const Feature* feature = nullptr;
};

// A landmark of the map that an image sees, and how the map's latest keyframes that know it do.
struct SeenPoint {
  PointId id = kNoId;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  const PointFeature* feature = nullptr;
  std::vector<MapView<PointFeature>> views;
};
struct SeenLine {
  LineId id = kNoId;
  Segment3 segment_W;
  const LineFeature* feature = nullptr;
  std::vector<MapView<LineFeature>> views;
};

// What an image sees of the map.
struct SeenLandmarks {
  std::vector<std::shared_ptr<const FrameFeatures>> features;  // that are pointed to
  std::vector<SeenPoint> points;
  std::vector<SeenLine> lines;
  double error = 1.0;  // |r|^2 per degree of freedom, of all of it at the pose of the image
};

// points, lines: what the features are, kNoId where nothing; as TrackedFrame has them.
SeenLandmarks FindSeen(const Map& map, const std::shared_ptr<const FrameFeatures>& features,
                       std::span<const PointId> points, std::span<const LineId> lines,
                       double error);

}  // namespace highwall
