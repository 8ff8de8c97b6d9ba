#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/pose_graph.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>

namespace highwall {

// The live keyframes as a pose graph.
struct KeyFrameGraph {
  PoseGraph graph;                      // the node of keyframes[i] has the id i
  std::vector<KeyFrameId> keyframes;    // ascending
  std::vector<std::size_t> loop_edges;  // places in graph.edges, of the loops in their order
  // Places in graph.nodes of the frames, T_FW, in which the user's factors are measured.
  std::map<ReferenceFrameId, std::size_t> frames{};
  int set_aside = 0;    // factors of the user's that cannot be evaluated at these poses
  std::string fault{};  // of the first of them

  // Throws InvalidArgument where there is no such keyframe.
  std::int64_t NodeOf(KeyFrameId keyframe) const;
  // Lets the map's own edges drift as over the steps between the ends of a loop. Throws as NodeOf.
  void AllowBias(const LoopEdge& loop, const KeyFrameGraphOptions& options);
  // Throws as NodeOf.
  void Add(const LoopEdge& loop, const KeyFrameGraphOptions& options);
  // T_FW of the frames as the solved graph has them.
  std::map<ReferenceFrameId, Pose> FramePoses() const;
};

// Of the keyframes of a submap and all that is joined with it, at least two. Odometry joins each
// keyframe of a submap with the next, covisibility with those it shares most landmarks with, and a
// submap with the older ones where they share most; all as the map has them now, sharing the
// information of one, and trusted. Loops join as measured, at the keyframe that a removed one hangs
// on; one is left out where it is of another submap, or joins neighbours by then. The factors of
// the user's (FactorsIn) take part, but for those that cannot be evaluated.
KeyFrameGraph MakeKeyFrameGraph(const Map& map, std::span<const LoopEdge> loops,
                                const KeyFrameGraphOptions& options = {},
                                SubmapId submap = kFirstSubmap);

// Squared Mahalanobis distance (6 degrees of freedom) between where the graph has loop.keyframe and
// where the loop says it is, given the drift that the way between them may have gathered. graph: of
// the map as it is, without that loop. Throws InvalidArgument where a keyframe is not in it.
double LoopChi2(KeyFrameGraph graph, const LoopEdge& loop,
                const KeyFrameGraphOptions& options = {});

}  // namespace highwall
