#include "loops/loop_detector.h"

#include <algorithm>
#include <functional>
#include <utility>

#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/keyframe_index.h>
#include <highwall/frontend/pose/pose_solver.h>
#include <highwall/internal/number_text.h>

#include "loops/submap_merge.h"
#include "map/covisibility.h"
#include "map/pose_covariance.h"
#include "pose/support.h"

namespace highwall {
namespace {

constexpr double kMinScore = 0.01;    // of the index
constexpr double kScoreShare = 0.25;  // of the score of the best neighbour in the map
constexpr int kCandidates = 3;        // keyframes examined, most similar first
constexpr RelocalizerOptions kVerification{.min_inliers = 20, .ransac_iterations = 300};
// At the end of a run there is time, and a weak pose by RANSAC does no harm: the matches found by
// projection decide.
constexpr int kLastCandidates = 10;
constexpr RelocalizerOptions kLastVerification{.min_inliers = 12, .ransac_iterations = 1000};
constexpr int kPlaceKeyFrames = 10;  // neighbours of the candidate whose landmarks are searched
// Maximum share of contradicting depth in a merge of two submaps.
constexpr double kMaxContradiction = 0.03;
constexpr double kUsuallyFound = 0.5;  // default of KeyFrame::found if it is unknown

bool Intersect(const std::vector<KeyFrameId>& a, const std::vector<KeyFrameId>& b) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) return true;
    ++(*i < *j ? i : j);
  }
  return false;
}

template <class LandmarkId>
std::vector<bool> Taken(std::size_t size, const std::vector<std::pair<int, LandmarkId>>& matches) {
  std::vector<bool> taken(size, false);
  for (const auto& [feature, id] : matches) taken[static_cast<std::size_t>(feature)] = true;
  return taken;
}

template <class LandmarkId>
std::vector<LandmarkId> Landmarks(const std::vector<std::pair<int, LandmarkId>>& matches) {
  std::vector<LandmarkId> landmarks;
  for (const auto& [feature, id] : matches) landmarks.push_back(id);
  return landmarks;
}

// Returns the covariance of a pose by its matches, with the noise that their residuals show.
PoseCovariance CovarianceOf(const PoseSolution& pose) {
  const PoseCovariance information_C =
      RotatedInformation(pose.information, pose.T_WC.R().transpose());
  return InflatedInformation(information_C / std::max(1.0, pose.error)).inverse();
}

// Refines the pose with all matches and removes outliers. Returns the covariance of the pose; empty
// if the support falls below min_support.
std::optional<PoseCovariance> Solve(const MeasurementModel& model, const Map& map,
                                    const FrameFeatures& features, int min_support,
                                    Relocalization* found) {
  PerKind<PoseObservations> seen;
  ForEachKind([&]<class Landmark>() {
    std::erase_if(PartOf<Landmark>(found->matches), [&](const auto& match) {
      const auto& feature = PartOf<Landmark>(features)[static_cast<std::size_t>(match.first)];
      const auto observation =
          MakePoseObservation(model, *map.Find(match.second), feature, found->T_WC);
      if (observation) PartOf<Landmark>(seen).push_back(*observation);
      return !observation;
    });
  });
  PoseSolverOptions options;
  options.min_support = min_support;
  const auto solution = SolvePose(found->T_WC, model.projection(), seen, options);
  if (!solution) return std::nullopt;
  found->T_WC = solution->T_WC;
  ForEachKind([&]<class Landmark>() {
    const std::vector<bool>& inliers = PartOf<Landmark>(solution->inliers);
    std::size_t i = 0;
    std::erase_if(PartOf<Landmark>(found->matches), [&](const auto&) { return !inliers[i++]; });
  });
  return CovarianceOf(*solution);
}

}  // namespace

LoopDetector::LoopDetector(const MeasurementModel& model, const LoopDetectorOptions& options,
                           const KeyFrameGraphOptions& graph)
    : model_(model),
      options_((options.Validate(), options)),
      graph_((graph.Validate(), graph)),
      relocalizer_(model, kVerification),
      last_relocalizer_(model, kLastVerification),
      matcher_(model),
      grid_(model.camera()) {}

std::optional<Loop> LoopDetector::Detect(const Map& map, KeyFrameId keyframe,
                                         std::span<const LoopEdge> loops) {
  const Candidates candidates = FindCandidates(map, keyframe, kCandidates);
  auto merge = DetectMerge(map, keyframe, candidates.merges);
  auto loop = DetectLoop(map, keyframe, candidates.loops, loops);
  return merge ? merge : loop;
}

std::optional<Loop> LoopDetector::DetectLoop(const Map& map, KeyFrameId keyframe,
                                             std::span<const KeyFrameId> candidates,
                                             std::span<const LoopEdge> loops) {
  std::vector<Place> places;
  std::vector<KeyFrameId> consistent;
  for (const KeyFrameId candidate : candidates) {
    Place place = PlaceOf(map, candidate);
    for (const Place& before : places_) {
      if (Intersect(place.keyframes, before.keyframes)) {
        place.votes = std::max(place.votes, before.votes);
      }
    }
    if (++place.votes >= options_.consistency) consistent.push_back(candidate);
    places.push_back(std::move(place));
  }
  places_ = std::move(places);
  for (const KeyFrameId candidate : consistent) {
    auto loop = Verify(map, keyframe, candidate, loops);
    if (!loop) continue;
    places_.clear();
    return loop;
  }
  return std::nullopt;
}

std::optional<Loop> LoopDetector::DetectMerge(const Map& map, KeyFrameId keyframe,
                                              std::span<const KeyFrameId> candidates) {
  for (const KeyFrameId candidate : candidates) {
    auto found = FindPlace(map, keyframe, candidate, relocalizer_);
    if (!found) continue;
    const bool beyond_doubt =
        found->support >= options_.decisive_ratio * options_.min_support && found->share >= 1.0;
    const bool agreed = Agrees(map, found->loop.edge);
    if (!beyond_doubt && !agreed) return std::nullopt;  // not yet
    if (Contradicts(map, found->loop.edge)) return std::nullopt;
    merge_candidate_.reset();
    return std::move(found->loop);
  }
  merge_candidate_.reset();
  return std::nullopt;
}

bool LoopDetector::Contradicts(const Map& map, const LoopEdge& edge) {
  std::string message;
  const auto merge = PlanMerge(map, edge, graph_, &message);
  if (!merge) {
    Refuse(edge, message);
    return true;
  }
  const auto share = MergeContradiction(map, *merge, grid_, model_.depth_noise());
  if (!share || *share <= kMaxContradiction) return false;
  Refuse(edge, "share of the depth that contradicts, " + FixedText(*share) + ", exceeds " +
                   FixedText(kMaxContradiction));
  return true;
}

bool LoopDetector::Agrees(const Map& map, const LoopEdge& edge) {
  MergeCandidate now{*map.RootOf(edge.keyframe), *map.RootOf(edge.match), edge, 1};
  if (merge_candidate_ && merge_candidate_->own == now.own &&
      merge_candidate_->other == now.other) {
    const double chi2 = MergeChi2(map, merge_candidate_->edge, edge, graph_);
    if (chi2 <= graph_.max_loop_chi2) {
      now.keyframes += merge_candidate_->keyframes;
    } else {
      Refuse(edge, "chi2 " + FixedText(chi2) + " against the keyframe before exceeds " +
                       FixedText(graph_.max_loop_chi2));
    }
  }
  merge_candidate_ = now;
  return now.keyframes >= options_.consistency;
}

LoopDetector::Candidates LoopDetector::FindCandidates(const Map& map, KeyFrameId id,
                                                      int most) const {
  const std::vector<PlaceScore> ranking = map.index().Query(*map.keyframe(id)->frame.features);
  // Keyframes connected in the map, directly or over one keyframe, are no loop candidates.
  std::vector<bool> connected(ranking.empty() ? 0 : id.index() + 1, false);
  const auto mark = [&](KeyFrameId k) {
    if (k.index() < connected.size()) connected[k.index()] = true;
  };
  mark(id);
  const auto neighbours = map.Covisible(id, kSharedByPlace);
  for (const auto& [neighbour, shared] : neighbours) {
    mark(neighbour);
    for (const auto& [next, s] : map.Covisible(neighbour, kSharedByPlace)) mark(next);
  }
  // The similarity of a place must be comparable to that of neighbours in the map.
  double best_neighbour = 0.0;
  for (const PlaceScore& place : ranking) {
    const bool near = std::any_of(neighbours.begin(), neighbours.end(),
                                  [&](const auto& n) { return n.first == place.keyframe; });
    if (near) best_neighbour = std::max(best_neighbour, place.score);
  }
  const double bound = std::max(kMinScore, kScoreShare * best_neighbour);
  const auto world = map.RootOf(id);
  Candidates candidates;
  for (const PlaceScore& place : ranking) {
    if (place.score < bound) break;
    if (place.keyframe >= id || connected[place.keyframe.index()]) continue;
    auto& of = map.RootOf(place.keyframe) == world ? candidates.loops : candidates.merges;
    if (static_cast<int>(of.size()) < most) of.push_back(place.keyframe);
  }
  return candidates;
}

void LoopDetector::Refuse(const LoopEdge& edge, std::string reason) {
  refused_.push_back({edge, std::move(reason)});
}

LoopDetector::Place LoopDetector::PlaceOf(const Map& map, KeyFrameId keyframe) const {
  Place place{{keyframe}, 0};
  for (const auto& [id, shared] : map.Covisible(keyframe, kSharedByPlace)) {
    place.keyframes.push_back(id);
  }
  std::sort(place.keyframes.begin(), place.keyframes.end());
  return place;
}

std::optional<Loop> LoopDetector::Verify(const Map& map, KeyFrameId id, KeyFrameId candidate,
                                         std::span<const LoopEdge> loops) {
  auto found = FindPlace(map, id, candidate, relocalizer_);
  if (!found) return std::nullopt;
  if (map.RootOf(id) != map.RootOf(candidate) || IsWithinDrift(map, loops, &found->loop)) {
    return std::move(found->loop);
  }
  return std::nullopt;
}

std::optional<Loop> LoopDetector::DetectLast(const Map& map, std::span<const KeyFrameId> newest,
                                             std::span<const LoopEdge> loops) {
  const std::size_t refused = refused_.size();
  std::optional<Found> best;
  std::vector<Found> merges;
  for (const KeyFrameId keyframe : newest) {
    const Candidates candidates = FindCandidates(map, keyframe, kLastCandidates);
    for (const KeyFrameId candidate : candidates.merges) {
      auto found = FindPlace(map, keyframe, candidate, last_relocalizer_);
      if (found && found->share >= 1.0) merges.push_back(*std::move(found));
    }
    for (const KeyFrameId candidate : candidates.loops) {
      auto found = FindPlace(map, keyframe, candidate, last_relocalizer_);
      if (!found || found->share < options_.min_match_ratio_across_submaps) continue;
      if (!best || found->support > best->support) best = std::move(found);
    }
  }
  refused_.resize(refused);  // only that of the best says why no loop was closed
  std::optional<Loop> last = AgreedMerge(map, std::move(merges));
  if (!last && best && IsWithinDrift(map, loops, &best->loop)) last = std::move(best->loop);
  if (last) places_.clear();
  return last;
}

std::optional<Loop> LoopDetector::AgreedMerge(const Map& map, std::vector<Found> found) {
  std::ranges::stable_sort(found, std::greater(), &Found::support);
  bool any_agreed = false;
  for (Found& one : found) {
    const LoopEdge& edge = one.loop.edge;
    const bool agreed = std::ranges::any_of(found, [&](const Found& other) {
      return other.loop.edge.keyframe != edge.keyframe &&
             map.RootOf(other.loop.edge.match) == map.RootOf(edge.match) &&
             MergeChi2(map, other.loop.edge, edge, graph_) <= graph_.max_loop_chi2;
    });
    any_agreed |= agreed;
    if (!agreed || Contradicts(map, edge)) continue;
    merge_candidate_.reset();
    return std::move(one.loop);
  }
  if (!found.empty() && !any_agreed) {
    Refuse(found.front().loop.edge, "none of the other last keyframes agrees");
  }
  return std::nullopt;
}

bool LoopDetector::IsWithinDrift(const Map& map, std::span<const LoopEdge> loops, Loop* loop) {
  const SubmapId submap = map.keyframe(loop->edge.keyframe)->submap;
  const std::optional<double> chi2 =
      LoopChi2(MakeKeyFrameGraph(map, model_, loops, graph_, submap), loop->edge, graph_);
  if (!chi2) {
    Refuse(loop->edge, "the drift between its keyframes is not determined");
    return false;
  }
  loop->chi2 = *chi2;
  if (loop->chi2 <= graph_.max_loop_chi2) return true;
  Refuse(loop->edge, "chi2 " + FixedText(loop->chi2) + " against the drift exceeds " +
                         FixedText(graph_.max_loop_chi2));
  return false;
}

std::optional<LoopDetector::Found> LoopDetector::FindPlace(const Map& map, KeyFrameId id,
                                                           KeyFrameId candidate,
                                                           const Relocalizer& relocalizer) {
  const FrameFeatures& features = *map.keyframe(id)->frame.features;
  auto found = relocalizer.MatchKeyFrame(features, map, candidate, map.keyframe(candidate)->T_WC);
  if (!found) return std::nullopt;

  const std::vector<KeyFrameId> place =
      WithNeighbours(map, candidate, kSharedByPlace, kPlaceKeyFrames);
  PerKind<LandmarkIds> in_view;
  ForEachKind([&]<class Landmark>() {
    auto& matches = PartOf<Landmark>(found->matches);
    auto& visible = PartOf<Landmark>(in_view);
    const LandmarkIds<Landmark> own = Landmarks(matches);
    const auto more = matcher_.Match(features, found->T_WC, map, map.SeenBy<Landmark>(place, own),
                                     Taken(PartOf<Landmark>(features).size(), matches), &visible);
    visible.insert(visible.end(), own.begin(), own.end());
    matches.insert(matches.end(), more.begin(), more.end());
  });
  LoopEdge edge{candidate, id, {}};
  const auto covariance = Solve(model_, map, features, options_.min_support, &*found);
  edge.Z = map.keyframe(candidate)->T_WC.Inverse() * found->T_WC;
  if (!covariance) {
    Refuse(edge, "support of less than " + std::to_string(options_.min_support));
    return std::nullopt;
  }
  edge.covariance = *covariance;
  const int support = static_cast<int>(SupportOf(found->matches));
  const double own = map.keyframe(id)->found;
  const double share =
      support / static_cast<double>(SupportOf(in_view)) / (own > 0.0 ? own : kUsuallyFound);
  const double bound = map.RootOf(id) == map.RootOf(candidate)
                           ? options_.min_found
                           : options_.min_match_ratio_across_submaps;
  if (share < bound) {
    Refuse(edge, "share of the landmarks in view that it finds, against its own surroundings, " +
                     FixedText(share) + ", is below " + FixedText(bound));
    return std::nullopt;
  }
  return Found{{edge, std::move(found->matches), 0.0}, support, share};
}

}  // namespace highwall
