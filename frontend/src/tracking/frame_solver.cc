#include "tracking/frame_solver.h"

#include <algorithm>

#include <highwall/frontend/pose/pose_solver.h>

#include "pose/degeneracy.h"
#include "tracking/landmark_observations.h"

namespace highwall {

bool FrameSolver::Solve(const TrackingQuery& query, int min_support, FallbackConstraint fallback,
                        TrackedFrame* tracked) const {
  const LandmarkObservations seen = LandmarksSeen(model_, query.map, *tracked);
  tracked->tried_points = tracked->points;
  tracked->tried_lines = tracked->lines;
  PoseSolverOptions options = options_.pose;
  options.min_support = query.prediction != nullptr
                            ? std::min(min_support, options_.min_predicted_support)
                            : min_support;
  std::vector<PointToPlaneRow> planes;
  if (fallback == FallbackConstraint::kSurfaces) {
    planes = MatchSurfaces(*tracked, query.map);
    options.min_support = options_.surfaces.min_support;
  }
  const auto solution = SolvePose(tracked->T_WC, model_.projection(), seen.points, seen.lines,
                                  options, query.prediction, planes);
  if (!solution) return false;
  if (fallback == FallbackConstraint::kSurfaces &&
      (solution->num_planes < options_.surfaces.min_rows ||
       !FindUnobservableDirections(solution->information, solution->T_WC, solution->depth,
                                   {.max_sigma = options_.surfaces.max_sigma})
            .empty())) {
    return false;
  }
  TakePose(seen, *solution, options_.degeneracy, tracked);
  return true;
}

std::vector<PointToPlaneRow> FrameSolver::MatchSurfaces(const TrackedFrame& tracked,
                                                        const Map& map) const {
  const KeyFrame* reference = state_.last ? map.keyframe(state_.last->reference) : nullptr;
  const cv::Mat& depth = tracked.frame.features->depth_grid;
  if (reference == nullptr || depth.empty() || reference->depth_grid.empty()) return {};
  std::vector<SurfacePatch> patches =
      FindPatches(reference->depth_grid, grid_, model_.depth_noise(), options_.surfaces.matcher);
  for (SurfacePatch& patch : patches) {
    patch.a = reference->T_WC * patch.a;
    patch.n = reference->T_WC.q() * patch.n;
  }
  return MatchPatches(patches, depth, tracked.moving, tracked.T_WC, grid_, model_.depth_noise(),
                      options_.surfaces.matcher);
}

}  // namespace highwall
