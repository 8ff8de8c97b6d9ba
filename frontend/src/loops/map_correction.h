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

#include "local/bundle_adjustment.h"
#include "map/landmark_fusion.h"

namespace highwall {

// What an adjustment with an IMU found of the body at a keyframe.
struct BodyMotion {
  Eigen::Vector3d v_WB;  // [m/s]
  ImuBias bias;          // [rad/s, m/s^2]
};

// Where the keyframes and landmarks of a map lie.
struct MapGeometry {
  std::unordered_map<KeyFrameId, Pose> keyframes;       // T_WC
  std::unordered_map<PointId, Eigen::Vector3d> points;  // p_W [m]
  std::unordered_map<LineId, Segment3> lines;           // [m]
  std::map<ReferenceFrameId, Pose> frames{};            // T_FW of their world
};
// Of a submap and all that is joined with it.
MapGeometry GeometryOf(const Map& map, SubmapId submap = kFirstSubmap);

// How keyframes were moved, each in its own camera: T_WC <- T_WC * move.
using KeyFrameMoves = std::unordered_map<KeyFrameId, Pose>;

// What was found out on a copy of a map, for the map itself, which has gone on since.
struct MapCorrection {
  MapGeometry after;
  MapFusion fusion;
  OutlierObservations outliers;
  std::optional<SubmapMerge> merge{};  // that the map is still to be told of
  // Of an adjustment: elsewhere velocities turn with their keyframes, and biases stay.
  std::unordered_map<KeyFrameId, BodyMotion> motions{};
  std::optional<Eigen::Vector3d> gravity_W{};  // of the world of the keyframes
};

// What an adjustment of all of a submap has come to.
MapCorrection AdjustedTo(const Map& map, OutlierObservations outliers,
                         SubmapId submap = kFirstSubmap);

// Puts what the map still has where the copy has it; newer keyframes move with the newest of their
// submap that is older than them, other landmarks with the first keyframe that observes them. Then
// fuses, and forgets outliers. What a local adjustment moved since the copy was made does not add
// to that: it and the copy may have moved by the same error.
void Apply(const MapCorrection& correction, Map* map);

// Moves keyframe keyframes[i], all of them live and ascending, to T_WC[i]. Landmarks follow the
// first of these keyframes that observes them.
void MoveKeyFrames(const std::vector<KeyFrameId>& keyframes, const std::vector<Pose>& T_WC,
                   Map* map);

}  // namespace highwall
