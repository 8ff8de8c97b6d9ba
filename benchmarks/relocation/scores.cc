#include "scores.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <set>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>

#include "scenes.h"

namespace highwall::bench {
namespace {

// Aligns a part of a run with the ground truth: returns T_true_est, with the mean rotation.
Pose Align(const Trajectory& truth, const Trajectory& estimate) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  Eigen::Vector3d p_true = Eigen::Vector3d::Zero(), p_est = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector4d q = (truth[i].pose.q() * estimate[i].pose.q().conjugate()).coeffs();
    sum += q.dot(sum) < 0.0 ? Eigen::Vector4d(-q) : q;
    p_true += truth[i].pose.p() / static_cast<double>(truth.size());
    p_est += estimate[i].pose.p() / static_cast<double>(truth.size());
  }
  const Eigen::Quaterniond q(Eigen::Vector4d(sum.normalized()));
  return Pose(q, p_true - q * p_est);
}

// Poses of a trajectory of a parted sequence, by the frame in the source sequence.
std::map<std::size_t, Pose> BySource(const PartedSequence& parted, const Trajectory& trajectory) {
  std::map<Stamp, std::size_t> sources;
  for (const PartedFrame& frame : parted.frames()) sources[frame.stamp] = frame.source;
  std::map<std::size_t, Pose> poses;
  for (const StampedPose& pose : trajectory) poses[sources.at(pose.stamp)] = pose.pose;
  return poses;
}

std::optional<PlaceError> ErrorBetweenParts(const PartedSequence& parted,
                                            const Trajectory& trajectory) {
  Trajectory truth[2], estimate[2];
  const auto poses = BySource(parted, trajectory);
  for (const PartedFrame& frame : parted.frames()) {
    const auto found = poses.find(frame.source);
    if (found == poses.end() || !frame.part || *frame.part > 1) continue;
    truth[*frame.part].push_back({frame.stamp, parted.sequence().T_WC(frame.source)});
    estimate[*frame.part].push_back({frame.stamp, found->second});
  }
  if (estimate[0].empty() || estimate[1].empty()) return std::nullopt;
  const Pose E = Align(truth[0], estimate[0]).Inverse() * Align(truth[1], estimate[1]);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : estimate[1]) middle += pose.pose.p();
  middle /= static_cast<double>(estimate[1].size());
  return PlaceError{1e3 * (E * middle - middle).norm(), E.Angle() * 180.0 / std::numbers::pi};
}

// A map's world is defined by its first frame; a pose error larger than any drift within a room
// means that a different place was recognized.
int Misplaced(const PartedSequence& parted, const Run& run) {
  constexpr double kFar = 0.5, kTurned = 0.2;  // [m], [rad]
  std::map<SubmapId, Pose> T_WS;
  int misplaced = 0;
  auto meeting = run.meetings.begin();
  for (std::size_t i = 0; i < run.outcomes.size(); ++i) {
    const Outcome& outcome = run.outcomes[i];
    bool merged = false;
    for (; meeting != run.meetings.end() && meeting->stamp <= parted.frames()[i].stamp; ++meeting) {
      if (!meeting->merge) continue;
      merged = true;
      const SubmapMerge& merge = *meeting->merge;
      if (merge.moved == merge.root) T_WS[merge.root] = T_WS.at(merge.other);
    }
    if (!outcome.pose || merged) continue;  // with a merge: in either of the two
    const Pose T_WC = parted.sequence().T_WC(parted.frames()[i].source);
    const Pose T = T_WC * outcome.T_WC.Inverse();
    const Pose error = T_WS.try_emplace(outcome.submap, T).first->second * T.Inverse();
    // Evaluated at the camera: far from the origin a small rotation causes a large displacement.
    if ((error * T_WC.p() - T_WC.p()).norm() > kFar || error.Angle() > kTurned) ++misplaced;
  }
  return misplaced;
}

// Returns the longest time from the start of a part to its first pose, or to its end if there is
// none.
double LongestGone(const PartedSequence& parted, const std::vector<Outcome>& outcomes) {
  double longest = 0.0;
  std::optional<int> part;
  Stamp begin = 0;
  bool gone = false;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const PartedFrame& frame = parted.frames()[i];
    if (!frame.part) continue;
    if (frame.part != part) {
      part = frame.part;
      begin = frame.stamp;
      gone = true;
    }
    if (!gone) continue;
    longest = std::max(longest, ToSeconds(frame.stamp - begin));
    gone = !outcomes[i].pose;
  }
  return longest;
}

// Uses the first pose of each part but the first, if it is in an earlier map.
std::optional<double> MatchedAfterCut(const PartedSequence& parted,
                                      const std::vector<Outcome>& outcomes) {
  std::optional<double> least;
  std::optional<int> part = 0;
  std::set<SubmapId> known;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const PartedFrame& frame = parted.frames()[i];
    if (!frame.part || !outcomes[i].pose) continue;
    if (frame.part != part && known.contains(outcomes[i].submap)) {
      least = std::min(least.value_or(1.0), outcomes[i].matched);
    }
    part = frame.part;
    known.insert(outcomes[i].submap);
  }
  return least;
}

}  // namespace

Run RunSequence(const PartedSequence& parted,
                const std::function<void(std::size_t, std::size_t)>& progress) {
  Run run;
  Session session(parted.sequence().sensor(), parted.Truth());
  const PinholeCamera camera = parted.sequence().sensor().camera;
  for (const PartedFrame& frame : parted.frames()) {
    const RgbdImage image = parted.Load(frame);
    run.outcomes.push_back(session.Track(image));
    if (frame.part) {
      run.encounters.Watch(frame.stamp, *frame.part,
                           testing::SeenSurface::PointsOf(image.depth, camera,
                                                          parted.sequence().T_WC(frame.source)));
    }
    progress(run.outcomes.size(), parted.frames().size());
  }
  session.Finish();
  run.meetings = session.meetings();
  run.refusals = session.refusals();
  run.trajectories = session.Trajectories();
  return run;
}

RelocationScores ScoreRun(const PartedSequence& parted, const Run& run) {
  RelocationScores scores;
  scores.gone_s = LongestGone(parted, run.outcomes);
  scores.misplaced = Misplaced(parted, run);
  scores.matched_after_cut = MatchedAfterCut(parted, run.outcomes);
  for (std::size_t i = 0; i < run.outcomes.size(); ++i) {
    if (run.outcomes[i].pose) continue;
    ++scores.lost;
    const bool covered = !parted.frames()[i].part;
    if (covered) ++scores.lost_covered;
    ++(covered ? scores.covered_reasons : scores.reasons)[run.outcomes[i].reason];
  }
  const auto& known = run.encounters.known_at_first();
  if (known.size() > 1) scores.known_at_first = known[1];
  const Stamp first = parted.frames().front().stamp;
  if (const auto met = run.encounters.met()) scores.due_s = ToSeconds(*met - first);
  for (const Meeting& meeting : run.meetings) {
    ++(meeting.merge ? scores.merges : scores.loops);
    if (meeting.IsFalse()) ++(meeting.merge ? scores.false_merges : scores.false_loops);
    if (meeting.merge) scores.merge = PlaceError{1e3 * meeting.metres, meeting.degrees};
    if (meeting.merge && scores.due_s) {
      scores.merged_s = ToSeconds(meeting.stamp - first) - *scores.due_s;  // the last merge counts
    }
  }
  scores.maps = static_cast<int>(run.trajectories.size());
  if (run.trajectories.empty()) return scores;
  try {
    scores.ape_mm =
        1e3 * AbsolutePoseError(parted.Truth(), run.trajectories.front()).statistics.rmse;
  } catch (const InvalidArgument&) {  // too few poses
  }
  scores.parts = ErrorBetweenParts(parted, run.trajectories.front());
  return scores;
}

std::optional<double> ApeOverSameFrames(const PartedSequence& parted, const Run& run,
                                        const PartedSequence& other_parted, const Run& other) {
  if (run.trajectories.empty() || other.trajectories.empty()) return std::nullopt;
  const auto poses = BySource(parted, run.trajectories.front());
  const auto others = BySource(other_parted, other.trajectories.front());
  Trajectory truth, estimate;
  for (const auto& [source, pose] : poses) {
    if (!others.contains(source)) continue;
    const Stamp stamp = parted.sequence().stamp(source);
    truth.push_back({stamp, parted.sequence().T_WC(source)});
    estimate.push_back({stamp, pose});
  }
  try {
    return 1e3 * AbsolutePoseError(truth, estimate).statistics.rmse;
  } catch (const InvalidArgument&) {
    return std::nullopt;
  }
}

}  // namespace highwall::bench
