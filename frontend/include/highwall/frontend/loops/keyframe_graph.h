#pragma once

#include <span>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/pose_graph.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// Where a keyframe was seen to be from another one that the map did not connect it with.
struct LoopEdge {
  KeyFrameId match = kNoId;     // the older one
  KeyFrameId keyframe = kNoId;  // the newer one
  Pose Z;                       // measured T_match_keyframe
};

// How far the transforms between keyframes may be off: standard deviations.
struct KeyFrameGraphOptions {
  double drift_translation = 0.05;  // > 0: share of the distance between two keyframes
  double drift_rotation = 0.05;     // > 0: share of the angle between them
  double step_translation = 0.005;  // [m] > 0: of every step between them besides
  double step_rotation = 0.003;     // [rad] > 0
  // >= 0; share of all that which is the same in every step, so that over n steps the variance is
  // 1 + n drift_bias^2 times that of steps that are off by chance.
  double drift_bias = 0.05;
  double loop_translation = 0.02;  // [m] > 0: of a loop
  double loop_rotation = 0.01;     // [rad] > 0
  // > 0; a loop beyond this is false: the squared distance of LoopChi2, and what a loop is left
  // with in the solved graph. 99.9 % of true ones are within where the drift is as above.
  double max_loop_chi2 = 22.458;
  int min_shared = 50;  // >= 1: landmarks that make an edge between keyframes
  int neighbours = 3;   // >= 0: most such edges of a keyframe to older ones
  // Where the map knows gravity, rotations keep its direction, W's z axis: four degrees of freedom
  // are left.
  bool hold_gravity = true;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The live keyframes as a pose graph.
struct KeyFrameGraph {
  PoseGraph graph;                      // the node of keyframes[i] has the id i
  std::vector<KeyFrameId> keyframes;    // ascending
  std::vector<std::size_t> loop_edges;  // places in graph.edges, of the loops in their order

  // Throws InvalidArgument where there is no such keyframe.
  std::int64_t NodeOf(KeyFrameId keyframe) const;
  // Lets the map's own edges drift as over the steps between the ends of a loop. Throws as NodeOf.
  void AllowBias(const LoopEdge& loop, const KeyFrameGraphOptions& options);
  // Throws as NodeOf.
  void Add(const LoopEdge& loop, const KeyFrameGraphOptions& options);
};

// Odometry joins each keyframe with the next, covisibility with those it shares most landmarks
// with, both as the map has them now, sharing the information of one, and trusted; loops join as
// measured. A loop is left out where one of its keyframes is no more. map: at least two keyframes.
KeyFrameGraph MakeKeyFrameGraph(const Map& map, std::span<const LoopEdge> loops,
                                const KeyFrameGraphOptions& options = {});

// Squared Mahalanobis distance (6 degrees of freedom) between where the graph has loop.keyframe and
// where the loop says it is, given the drift that the way between them may have gathered. graph: of
// the map as it is, without that loop. Throws InvalidArgument where a keyframe is not in it.
double LoopChi2(KeyFrameGraph graph, const LoopEdge& loop,
                const KeyFrameGraphOptions& options = {});

}  // namespace highwall
