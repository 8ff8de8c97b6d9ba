#include "tracking/pose_verifier.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "pose/depth_agreement.h"
#include "tracking/landmark_observations.h"

namespace highwall {
namespace {

std::size_t NumFeatures(const TrackedFrame& frame) {
  std::size_t features = 0;
  ForEachKind([&]<class Landmark>() { features += PartOf<Landmark>(frame).size(); });
  return features;
}

int NumCells(const cv::Mat& mask) {
  return mask.empty() ? 0 : cv::countNonZero(mask);
}

}  // namespace

Verification PoseVerifier::Verify(const TrackingQuery& query, PoseHypothesis hypothesis) const {
  const TrackingQuery by_prior = query.With(hypothesis.prior ? &*hypothesis.prior : nullptr);
  Verification result{.diagnostics = hypothesis.diagnostics};
  if (hypothesis.rough) {
    StaticMatch found =
        MatchStaticScene(by_prior, *std::move(hypothesis.rough), hypothesis.fallback);
    result.match = std::move(found.match);
    result.diagnostics.masked_share = found.masked_share;
  }
  if (!result.match && hypothesis.without_landmarks) {
    result.match = LocalMatch{*std::move(hypothesis.without_landmarks)};
  }
  if (result.match && IsRefuted(hypothesis, *result.match, query.map)) result.match.reset();
  if (hypothesis.origin == PoseOrigin::kMotion) {
    result.is_ambiguous = !result.match || hypothesis.is_inconsistent ||
                          (!hypothesis.prior && IsDoubtful(*result.match));
  }
  return result;
}

bool PoseVerifier::IsRefuted(const PoseHypothesis& hypothesis, const LocalMatch& match,
                             const Map& map) const {
  switch (hypothesis.origin) {
    case PoseOrigin::kMotion:
      // A pose that most matches contradict must at least be observable in every direction.
      if (hypothesis.is_inconsistent && !match.frame.open.empty()) return true;
      // A camera that was moved elsewhere may see a similar place.
      return !hypothesis.prior && (IsDoubtful(match) || FindsLittle(match)) &&
             Contradicts(match, map);
    case PoseOrigin::kReference:
      // Where views are far apart, most of what is in view looks different; then a similar place is
      // one that the camera cannot have reached.
      return (FindsLittle(match) && !state_.IsReachable(match.frame)) || Contradicts(match, map);
    case PoseOrigin::kPlace:
      // It may be a similar place instead.
      return FindsLittle(match) || Contradicts(match, map);
    case PoseOrigin::kSurfaces:
      break;
    case PoseOrigin::kImage:
      return Contradicts(
          match.frame,
          state_.AroundReference(map, static_cast<std::size_t>(parameters_.recognized_views)), map);
  }
  return Contradicts(match, map);
}

PoseVerifier::StaticMatch PoseVerifier::MatchStaticScene(const TrackingQuery& query,
                                                         TrackedFrame rough,
                                                         FallbackConstraint fallback) const {
  const auto all = static_cast<double>(NumFeatures(rough));
  const auto match_rest = [&](TrackedFrame rest) {
    StaticMatch result;
    moving_.MaskOut(rest);
    result.masked_share = 1.0 - static_cast<double>(NumFeatures(rest)) / all;
    result.match = MatchLocalMap(query, std::move(rest), fallback);
    return result;
  };
  rough.moving = moving_.Find(rough, query.map);
  StaticMatch result = match_rest(rough);
  if (rough.moving.empty()) return result;
  auto reverified = Reverified(query, std::move(rough), result.match ? result.match->Support() : 0);
  if (!reverified) return result;
  StaticMatch again = match_rest(*std::move(reverified));
  if (again.match) return again;
  return result;
}

std::optional<LocalMatch> PoseVerifier::MatchLocalMap(const TrackingQuery& query,
                                                      TrackedFrame rough,
                                                      FallbackConstraint fallback) const {
  LocalMatch match{std::move(rough)};
  TrackedFrame& tracked = match.frame;
  match.in_view = MatchAround(matcher_, query.map, options_.local_keyframes, &tracked);
  if (!solver_.Solve(query, options_.min_support, fallback, &tracked)) return std::nullopt;
  tracked.reference = query.map.Observers(tracked).front().first;
  tracked.found = static_cast<double>(match.Support()) / static_cast<double>(match.SupportInView());
  return match;
}

std::optional<TrackedFrame> PoseVerifier::Reverified(const TrackingQuery& query, TrackedFrame rough,
                                                     int support) const {
  constexpr double kAgree = 0.5, kLeft = 0.5;
  // The surfaces are those around the last frame.
  if (!options_.surfaces.enabled || rough.relocalized) return std::nullopt;
  const cv::Mat moving = std::exchange(rough.moving, cv::Mat());
  const auto steady = MatchLocalMap(query, rough, FallbackConstraint::kSurfaces);
  const double enough = std::max<double>(kMinSurfaceSupport, kAgree * support);
  if (!steady || moving_.SupportBeside(steady->frame, moving) < enough ||
      Contradicts(*steady, query.map)) {
    return std::nullopt;
  }
  // All tried matches are tested, because that pose does not look for dynamic landmarks where they
  // are.
  rough.T_WC = steady->frame.T_WC;
  rough.moving = moving_.Find(rough, query.map);
  if (NumCells(rough.moving) > kLeft * NumCells(moving)) return std::nullopt;
  return rough;
}

bool PoseVerifier::IsDoubtful(const LocalMatch& match) const {
  return match.Support() < options_.doubtful_share * static_cast<double>(match.SupportInView()) ||
         match.Support() < parameters_.doubtful_drop * state_.last_support;
}

bool PoseVerifier::FindsLittle(const LocalMatch& match) const {
  return match.frame.found < parameters_.recognized_found * state_.mean_match_ratio;
}

bool PoseVerifier::Contradicts(const LocalMatch& match, const Map& map) const {
  return Contradicts(match.frame, ClosestObservers(map, match.frame, parameters_.recognized_views),
                     map);
}

bool PoseVerifier::Contradicts(const TrackedFrame& tracked, std::span<const KeyFrameId> views,
                               const Map& map) const {
  const auto contradiction = DepthContradiction(tracked.frame.features->depth_grid, tracked.T_WC,
                                                views, map, moving_.grid(), model_.depth_noise());
  return contradiction && *contradiction > parameters_.recognized_contradiction;
}

}  // namespace highwall
