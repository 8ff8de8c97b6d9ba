#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/pose_graph.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>

#include "map/pose_covariance.h"

namespace highwall {

// The active keyframes as a pose graph.
struct KeyFrameGraph {
  PoseGraph graph;                      // the node of keyframes[i] has the id i
  std::vector<KeyFrameId> keyframes;    // ascending
  std::vector<std::size_t> loop_edges;  // indices in graph.edges of the loops in their order
  // Indices in graph.nodes of the frames, T_FW, in which the user factors are measured.
  std::map<ReferenceFrameId, std::size_t> frames{};
  int excluded = 0;     // user factors that cannot be evaluated at these poses
  std::string fault{};  // the reason of the first of them
  // The series that each of graph.factors belongs to, a number: the measurements of one kind by one
  // sensor, one after the other.
  std::vector<std::size_t> series{};

  // Throws InvalidArgument if there is no such keyframe.
  std::int64_t NodeOf(KeyFrameId keyframe) const;
  // Adds the bias drift over the steps between the ends of a loop to the map's own edges. Throws as
  // NodeOf.
  void AllowBias(const LoopEdge& loop, const KeyFrameGraphOptions& options);
  // An edge between successive keyframes is odometry: it is never rejected. Throws as NodeOf.
  void Add(const LoopEdge& loop, const KeyFrameGraphOptions& options);
  // Returns T_FW of the frames in the solved graph.
  std::map<ReferenceFrameId, Pose> FramePoses() const;
};

// Returns the covariance of a loop: that of the landmarks that matched, and of the map between its
// views, which the options state. Along the axes of the camera of loop.keyframe.
PoseCovariance CovarianceOf(const LoopEdge& loop, const KeyFrameGraphOptions& options);

// Returns the covariance of the pose of a keyframe relative to another one in the map, by what ties
// them: what both observe (RelativeInformation), KeyFrame::image_motion and, in directions where
// it is better, what each knew of its pose in the map around it (KeyFrame::covariance, within a
// submap). Along the axes of the camera of `keyframe`. Errors that all images share are not part of
// it. Throws as RelativeInformation.
PoseCovariance RelativeCovariance(const Map& map, const MeasurementModel& model,
                                  KeyFrameId reference, KeyFrameId keyframe);

// Builds the graph of the keyframes of a submap and all that is merged with it, at least two.
// Odometry edges connect each keyframe of a submap with the next, covisibility edges those it
// shares most landmarks with, and a submap with the older ones where they share most; all with the
// current relative poses of the map, sharing the information of one, and trusted. An edge is as
// uncertain as RelativeCovariance, and by the drift that the options allow. Loop edges are added as
// measured, transferred to the keyframe that a removed one is anchored to; a loop is left out if it
// is of another submap, or connects neighbours by then. The user factors (FactorsIn) take part,
// except for those that cannot be evaluated.
KeyFrameGraph MakeKeyFrameGraph(const Map& map, const MeasurementModel& model,
                                std::span<const LoopEdge> loops,
                                const KeyFrameGraphOptions& options = {},
                                SubmapId submap = kFirstSubmap);

// Returns the squared Mahalanobis distance (6 degrees of freedom) between the pose of loop.keyframe
// in the graph and that measured by the loop, given the possible drift along the path between them.
// graph: of the current map, without that loop. Empty if the graph does not determine that drift.
// Throws InvalidArgument if a keyframe is not in it.
std::optional<double> LoopChi2(KeyFrameGraph graph, const LoopEdge& loop,
                               const KeyFrameGraphOptions& options = {});

}  // namespace highwall
