#pragma once

#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/outlier_observations.h>

#include "map/landmark_fusion.h"

namespace highwall {

// Motion of the body at a keyframe, estimated by an adjustment with an IMU.
struct BodyMotion {
  Eigen::Vector3d v_WB;  // [m/s]
  ImuBias bias;          // [rad/s, m/s^2]
};

// Where the landmarks of one kind are, in W.
template <class Landmark>
using LandmarkPositions =
    std::unordered_map<Id<Landmark>, typename LandmarkTraits<Landmark>::Geometry>;

// Geometry of a map: poses of keyframes and positions of landmarks.
struct MapGeometry {
  std::unordered_map<KeyFrameId, Pose> keyframes;  // T_WC
  PerKind<LandmarkPositions> landmarks{};
  std::map<ReferenceFrameId, Pose> frames{};  // T_FW of their world
};
// Returns the geometry of a submap and all that is merged with it.
MapGeometry GeometryOf(const Map& map, SubmapId submap = kFirstSubmap);

// Moves of keyframes, each in its own camera: T_WC <- T_WC * move.
using KeyFrameMoves = std::unordered_map<KeyFrameId, Pose>;

// Result computed on a copy of a map, to be applied to the map itself, which has changed since.
struct MapEdit {
  MapGeometry after;
  MapFusion fusion;
  OutlierObservations outliers;
  std::optional<SubmapMerge> merge{};  // a merge the map has yet to apply
  // From an adjustment: otherwise velocities rotate with their keyframes, and biases stay.
  std::unordered_map<KeyFrameId, BodyMotion> motions{};
  std::optional<Eigen::Vector3d> gravity_W{};  // of the world of the keyframes
};

// Returns the edit from an adjustment of a whole submap.
MapEdit AdjustedTo(const Map& map, OutlierObservations outliers, SubmapId submap = kFirstSubmap);

// Moves what still exists in the map to its place in the copy; newer keyframes move with the newest
// older keyframe of their world, other landmarks with the first keyframe that observes them. Then
// fuses landmarks and removes outliers. Moves by local adjustments since the copy was made are not
// added: they may have corrected the same error as the copy.
void Apply(const MapEdit& edit, Map* map);

// Moves keyframe keyframes[i], all of them active and ascending, to T_WC[i]. Landmarks follow the
// first of these keyframes that observes them.
void MoveKeyFrames(const std::vector<KeyFrameId>& keyframes, const std::vector<Pose>& T_WC,
                   Map* map);

}  // namespace highwall
