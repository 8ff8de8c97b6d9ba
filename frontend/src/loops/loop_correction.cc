#include "loops/loop_correction.h"

#include <algorithm>
#include <string>

#include <highwall/internal/number_text.h>

#include "loops/submap_merge.h"
#include "map/covisibility.h"
#include "map/landmark_fusion.h"

namespace highwall {
namespace {

constexpr int kFusedKeyframes = 12;  // neighbours on either side of the loop

// Fuses landmarks common to both sides of the loop; the older side's landmarks stay.
MapFusion FuseSides(const Loop& loop, const MapMatcher& matcher, Map* map) {
  // Determined before the fusion: afterwards each side is the other's neighbour.
  const auto older = WithNeighbours(*map, loop.edge.match, kSharedByPlace, kFusedKeyframes);
  const auto newer = WithNeighbours(*map, loop.edge.keyframe, kSharedByPlace, kFusedKeyframes);
  // The matches of the loop detection.
  MapFusion all = FusionOf(*map->keyframe(loop.edge.keyframe), loop.matches);
  Apply(all, map);
  for (const KeyFrameId id : newer) {
    if (std::find(older.begin(), older.end(), id) != older.end()) continue;
    all.Append(FuseLandmarks(id, older, matcher, {}, map));
  }
  return all;
}

// Moves keyframes and landmarks to their places in the pose graph with the loop. Returns false if
// the loop is rejected; message: the reason, or the solver's. by_factors: LoopCorrectionResult.
bool SolveKeyFrames(std::span<const LoopEdge> old_loops, const Loop& loop,
                    const MeasurementModel& model, const KeyFrameGraphOptions& graph_options,
                    const LoopCorrectionOptions& options, Map* map, int threads,
                    KeyFrameMoves* by_factors, std::string* message) {
  KeyFrameGraph graph = MakeKeyFrameGraph(*map, model, old_loops, graph_options,
                                          map->keyframe(loop.edge.keyframe)->submap);
  const std::optional<double> chi2 = LoopChi2(graph, loop.edge, graph_options);
  if (!chi2) {
    *message = "the drift between its keyframes is not determined";
    return false;
  }
  if (!(*chi2 <= graph_options.max_loop_chi2)) {
    *message = "chi2 " + FixedText(*chi2) + " against the drift exceeds " +
               FixedText(graph_options.max_loop_chi2);
    return false;
  }
  graph.AllowBias(loop.edge, graph_options);
  graph.Add(loop.edge, graph_options);
  PoseGraphOptions solve;
  solve.robust = options.robust;
  solve.max_loop_chi2 = graph_options.max_loop_chi2;
  solve.estimate_variance_factor = false;  // edges come from the poses themselves
  solve.solver.threads = threads;
  const PoseGraphSummary summary = SolvePoseGraph(&graph.graph, solve);
  *message = summary.message;
  if (summary.status == SolveStatus::kFailed) return false;
  const auto rejected = std::find_if(
      summary.rejected.begin(), summary.rejected.end(),
      [&](const RejectedLoop& other) { return other.edge == graph.loop_edges.back(); });
  if (rejected != summary.rejected.end()) {
    *message = rejected->reason;
    return false;
  }
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < graph.keyframes.size(); ++i) {
    poses.push_back(graph.graph.nodes[i].pose);
    if (graph.graph.factors.empty()) continue;
    const Pose& before = map->keyframe(graph.keyframes[i])->T_WC;
    by_factors->emplace(graph.keyframes[i], before.Inverse() * poses.back());
  }
  MoveKeyFrames(graph.keyframes, poses, map);
  const SubmapId world = *map->RootOf(loop.edge.keyframe);
  for (const auto& [id, T_FW] : graph.FramePoses()) map->factors().Place(id, world, T_FW);
  return true;
}

}  // namespace

LoopCorrectionResult CorrectLoop(std::span<const LoopEdge> old_loops, const Loop& loop,
                                 const MeasurementModel& model,
                                 const KeyFrameGraphOptions& graph_options,
                                 const LoopCorrectionOptions& options, Map* map, int threads) {
  options.Validate();
  graph_options.Validate();
  LoopCorrectionResult result;
  if (map->RootOf(loop.edge.match) != map->RootOf(loop.edge.keyframe)) {
    result.merge = PlanMerge(*map, loop.edge, graph_options, &result.message);
    if (!result.merge) return result;
    Apply(*result.merge, map);
  } else if (!SolveKeyFrames(old_loops, loop, model, graph_options, options, map, threads,
                             &result.by_factors, &result.message)) {
    return result;
  }
  result.fusion = FuseSides(loop, MapMatcher(model), map);
  result.accepted = true;
  return result;
}

}  // namespace highwall
