#include "tracking/frame_solver.h"

#include <algorithm>

#include <highwall/frontend/pose/pose_solver.h>
#include <highwall/internal/stage_timer.h>

#include "pose/degeneracy.h"
#include "tracking/landmark_observations.h"

namespace highwall {
namespace {

// Of a pose by surfaces: rows on patches, and the standard deviation [m] of its worst direction.
constexpr int kMinSurfaceRows = 30;
constexpr double kMaxSurfaceSigma = 0.2;

}  // namespace

bool FrameSolver::Solve(const TrackingQuery& query, int min_support, FallbackConstraint fallback,
                        TrackedFrame* tracked) const {
  const StageTimer timer(profile_, "pose");
  const LandmarkObservations seen = LandmarksSeen(model_, query.map, *tracked);
  tracked->tried = *tracked;
  PoseSolverOptions options;
  options.min_support =
      query.prediction != nullptr ? std::min(min_support, kMinPredictedSupport) : min_support;
  std::vector<PointToPlaneRow> planes;
  if (fallback == FallbackConstraint::kSurfaces) {
    planes = MatchSurfaces(*tracked, query.map);
    options.min_support = kMinSurfaceSupport;
  }
  const auto solution =
      SolvePose(tracked->T_WC, model_.projection(), seen, options, query.prediction, planes);
  if (!solution) return false;
  if (fallback == FallbackConstraint::kSurfaces &&
      (solution->num_planes < kMinSurfaceRows ||
       !FindUnobservableDirections(solution->information, solution->T_WC, solution->depth,
                                   {.max_sigma = kMaxSurfaceSigma})
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
      FindPatches(reference->depth_grid, grid_, model_.depth_noise());
  for (SurfacePatch& patch : patches) {
    patch.a = reference->T_WC * patch.a;
    patch.n = reference->T_WC.q() * patch.n;
  }
  return MatchPatches(patches, depth, tracked.moving, tracked.T_WC, grid_, model_.depth_noise());
}

}  // namespace highwall
