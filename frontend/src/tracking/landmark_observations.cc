#include "tracking/landmark_observations.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "pose/support.h"

namespace highwall {
namespace {

template <class LandmarkId>
void AppendMatched(const std::vector<LandmarkId>& landmarks, std::vector<LandmarkId>* all) {
  std::copy_if(landmarks.begin(), landmarks.end(), std::back_inserter(*all),
               [](LandmarkId id) { return id != kNoId; });
}

template <class LandmarkId>
int NumMatched(const std::vector<LandmarkId>& landmarks) {
  return static_cast<int>(
      std::count_if(landmarks.begin(), landmarks.end(), [](LandmarkId id) { return id != kNoId; }));
}

}  // namespace

int MatchedSupport(const PerKind<LandmarkIds>& landmarks) {
  return Support(NumMatched(landmarks.points), NumMatched(landmarks.lines));
}

TrackedFrame Unmatched(const Frame& frame, const Pose& T_WC) {
  TrackedFrame tracked;
  tracked.frame = frame;
  tracked.T_WC = T_WC;
  ForEachKind([&]<class Landmark>() {
    PartOf<Landmark>(tracked).assign(PartOf<Landmark>(*frame.features).size(), kNoId);
  });
  return tracked;
}

LandmarkObservations LandmarksSeen(const MeasurementModel& model, const Map& map,
                                   TrackedFrame& tracked) {
  const FrameFeatures& features = *tracked.frame.features;
  LandmarkObservations seen;
  ForEachKind([&]<class Landmark>() {
    LandmarkIds<Landmark>& landmarks = PartOf<Landmark>(tracked);
    const auto matched = static_cast<std::size_t>(NumMatched(landmarks));
    PartOf<Landmark>(seen).reserve(matched);
    PartOf<Landmark>(seen.features).reserve(matched);
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const Landmark* const landmark = map.Find(landmarks[i]);
      std::optional<typename PoseTraits<Landmark>::Observation> observation;
      if (landmark != nullptr) {
        observation =
            MakePoseObservation(model, *landmark, PartOf<Landmark>(features)[i], tracked.T_WC);
      }
      if (!observation) {
        landmarks[i] = kNoId;
        continue;
      }
      PartOf<Landmark>(seen).push_back(*observation);
      PartOf<Landmark>(seen.features).push_back(i);
    }
  });
  return seen;
}

void TakePose(const LandmarkObservations& seen, const PoseSolution& solution,
              const DegeneracyOptions& degeneracy, TrackedFrame* tracked) {
  ForEachKind([&]<class Landmark>() {
    const std::vector<bool>& inliers = PartOf<Landmark>(solution.inliers);
    const std::vector<std::size_t>& indices = PartOf<Landmark>(seen.features);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (!inliers[i]) PartOf<Landmark>(*tracked)[indices[i]] = kNoId;
    }
  });
  tracked->T_WC = solution.T_WC;
  tracked->num_points = solution.num_points;
  tracked->num_lines = solution.num_lines;
  tracked->num_planes = solution.num_planes;
  tracked->information = solution.information;
  tracked->gradient = solution.gradient;
  tracked->error = solution.error;
  tracked->open =
      FindUnobservableDirections(solution.information, solution.T_WC, solution.depth, degeneracy);
}

bool SolveFromLandmarks(const MeasurementModel& model, const Map& map,
                        const TrackerOptions& options, TrackedFrame* tracked) {
  const LandmarkObservations seen = LandmarksSeen(model, map, *tracked);
  PoseSolverOptions solver;
  solver.min_support = options.min_support;
  const auto solution = SolvePose(tracked->T_WC, model.projection(), seen, solver);
  if (solution) TakePose(seen, *solution, options.degeneracy, tracked);
  return solution.has_value();
}

std::vector<KeyFrameId> ClosestObservers(const Map& map, const TrackedFrame& tracked, int most) {
  std::vector<KeyFrameId> closest;
  for (const auto& [id, shared] : map.Observers(tracked)) {
    if (static_cast<int>(closest.size()) == most) break;
    closest.push_back(id);
  }
  return closest;
}

PerKind<LandmarkIds> MatchAround(const MapMatcher& matcher, const Map& map, int most,
                                 TrackedFrame* tracked, LandmarksAround* around) {
  const std::vector<KeyFrameId> local = ClosestObservers(map, *tracked, most);
  if (around != nullptr) around->MoveTo(local);
  const FrameFeatures& features = *tracked->frame.features;
  PerKind<LandmarkIds> in_view;
  ForEachKind([&]<class Landmark>() {
    LandmarkIds<Landmark>& landmarks = PartOf<Landmark>(*tracked);
    LandmarkIds<Landmark>& visible = PartOf<Landmark>(in_view);
    const LandmarkIds<Landmark> first = landmarks;
    const LandmarkIds<Landmark> others = around != nullptr ? around->Except<Landmark>(landmarks)
                                                           : map.SeenBy<Landmark>(local, landmarks);
    Apply(matcher.Match(features, tracked->T_WC, map, others, Taken(landmarks), &visible),
          landmarks);
    AppendMatched(first, &visible);
  });
  return in_view;
}

void LandmarkCounts::AddTo(Map* map) const {
  ForEachKind([&]<class Landmark>() {
    for (const Id<Landmark> id : PartOf<Landmark>(in_view)) {
      if (Landmark* const landmark = map->Find(id)) ++landmark->visible;
    }
    for (const Id<Landmark> id : PartOf<Landmark>(found)) {
      if (Landmark* const landmark = map->Find(id)) ++landmark->found;
    }
  });
}

}  // namespace highwall
