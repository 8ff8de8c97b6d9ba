#include "scores.h"

#include <algorithm>
#include <set>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>

#include "run/slam_run.h"

namespace highwall::bench {
namespace {

// Stamps of a sequence, grouped by the role of their frames.
struct Roles {
  explicit Roles(const AbusedSequence& sequence) {
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      (sequence.IsElsewhere(i) ? elsewhere : scored).insert(sequence.stamp(i));
    }
  }

  std::set<Stamp> scored, elsewhere;
};

double CountIn(const std::set<Stamp>& stamps, const Trajectory& trajectory) {
  return static_cast<double>(std::ranges::count_if(
      trajectory, [&](const StampedPose& pose) { return stamps.contains(pose.stamp); }));
}

std::vector<const Trajectory*> TrajectoriesOf(const apps::SlamRun& run) {
  std::vector<const Trajectory*> all{&run.largest.trajectory};
  for (const apps::SubmapRun& submap : run.others) all.push_back(&submap.trajectory);
  std::erase_if(all, [](const Trajectory* trajectory) { return trajectory->empty(); });
  return all;
}

void ScoreLosses(const AbusedSequence& sequence, const Roles& roles,
                 const std::vector<const Trajectory*>& maps, Scores* figures) {
  std::set<Stamp> posed;
  for (const Trajectory* map : maps) {
    for (const StampedPose& pose : *map) posed.insert(pose.stamp);
  }
  double lost = 0.0;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    if (sequence.IsElsewhere(i) || posed.contains(sequence.stamp(i))) continue;
    if (lost == 0.0) (*figures)["first_without_pose"] = static_cast<double>(i);
    ++lost;
  }
  (*figures)["frames"] = static_cast<double>(roles.scored.size());
  (*figures)["without_pose"] = lost;
  (*figures)["elsewhere"] = static_cast<double>(roles.elsewhere.size());
}

// Sets the figure unless there are too few poses for it.
template <class Compute>
void ScoreRmse(const char* name, const Compute& compute, Scores* figures) {
  try {
    (*figures)[name] = compute().statistics.rmse;
  } catch (const InvalidArgument&) {
  }
}

void ScoreErrors(const Trajectory& truth, const Trajectory& estimate, Scores* figures) {
  // The ground truth has the stamps of the frames.
  ScoreRmse(
      "ape_rmse_m", [&] { return AbsolutePoseError(truth, estimate, {.t_max_diff = 0.0}); },
      figures);
  const RelativePoseErrorOptions metre{
      .t_max_diff = 0.0, .delta = 1.0, .delta_unit = DeltaUnit::kMetres, .all_pairs = true};
  ScoreRmse(
      "drift_m_per_m", [&] { return RelativePoseError(truth, estimate, metre); }, figures);
}

}  // namespace

AbuseScores RunAbused(const AbusedSequence& sequence, const RgbdSensor& sensor, bool synchronous,
                      const ProgressCallback& progress) {
  apps::SlamRunOptions options;
  options.dense = false;
  if (synchronous) options.slam = Deterministic(options.slam);
  const apps::SlamRun run =
      apps::RunSlam(sequence, sensor, options,
                    {.on_frame = [&](const FrameResult&, const RgbdImage&, std::size_t done,
                                     std::size_t total) { progress(done, total); }});
  apps::RequireWhole(run);

  AbuseScores scores{.figures = {}, .reasons = run.loss_reasons};
  const Roles roles(sequence);
  const std::vector<const Trajectory*> maps = TrajectoriesOf(run);
  ScoreLosses(sequence, roles, maps, &scores.figures);
  scores.figures["maps"] = static_cast<double>(maps.size());
  scores.figures["merges"] = static_cast<double>(run.loops.merges);
  scores.figures["loops"] = static_cast<double>(run.loops.closed);
  if (maps.empty()) return scores;
  const Trajectory& home = **std::ranges::max_element(
      maps, {}, [&](const Trajectory* map) { return CountIn(roles.scored, *map); });
  scores.figures["elsewhere_taken_home"] = CountIn(roles.elsewhere, home);
  ScoreErrors(*sequence.groundtruth(), home, &scores.figures);
  return scores;
}

}  // namespace highwall::bench
