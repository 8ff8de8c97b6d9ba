#include "loops/factor_adjuster.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <stop_token>
#include <unordered_map>
#include <utility>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose_graph.h>
#include <highwall/internal/cost_fault.h>
#include <highwall/internal/stage_timer.h>
#include <highwall/internal/stopwatch.h>

#include "loops/frame_alignment.h"
#include "loops/keyframe_graph.h"

namespace highwall {
namespace {

// The factors in the world of a submap: those that have been adjusted before, and new ones.
struct FactorsOfWorld {
  // adjusted: by MapFactor::number; those beyond its end are new.
  FactorsOfWorld(const Map& map, SubmapId submap, const std::vector<bool>& adjusted) {
    const SubmapId root = map.Root(submap);
    for (const MapFactor& factor : map.factors().all()) {
      if (map.RootOf(factor.poses.front().keyframe) != root) continue;
      const auto number = static_cast<std::size_t>(factor.number);
      ++(number < adjusted.size() && adjusted[number] ? old : fresh);
      numbers.push_back(number);
    }
  }

  std::size_t old = 0, fresh = 0;
  std::vector<std::size_t> numbers;  // of all
};

// Gives keyframes without a move that of the newest one before them in their submap, whose moved
// pose they were tracked from.
void Inherit(const Map& map, KeyFrameMoves* moves) {
  std::unordered_map<SubmapId, KeyFrameId> newest;
  for (const KeyFrameId id : map.keyframe_ids()) {
    const KeyFrame& keyframe = *map.keyframe(id);
    const auto [before, first] = newest.try_emplace(keyframe.submap, id);
    const auto [move, is_new] = moves->try_emplace(id);
    if (is_new && !first) {
      const Pose T = keyframe.T_WC.Inverse() * map.keyframe(before->second)->T_WC;
      move->second = T * moves->at(before->second) * T.Inverse();
    }
    before->second = id;
  }
}

// Factors tried on the odometry information of KeyFrameGraphOptions: those options bound the error
// that a loop may show, and images are mostly much more accurate.
constexpr double kTrust[] = {100.0, 10.0, 1.0};

// Returns the quantile of chi2 with n degrees of freedom, at z standard deviations of a normal
// variable (Wilson and Hilferty 1931).
double Chi2Quantile(double n, double z) {
  const double variance = 2.0 / (9.0 * n);
  return n * std::pow(1.0 - variance + z * std::sqrt(variance), 3);
}

using Residuals = std::vector<Eigen::VectorXd>;

// Returns false if a user factor cannot be evaluated, throws, or is not finite.
bool EvaluatesTo(const ceres::CostFunction& cost, std::span<const double* const> blocks,
                 Eigen::VectorXd* r) {
  try {
    return internal::FaultOf(cost, blocks).empty() &&
           cost.Evaluate(blocks.data(), r->data(), nullptr) && r->allFinite();
  } catch (...) {  // a user factor may throw anything
    return false;
  }
}

// Returns the residuals of each series, in the order in which its factors were added to the map.
std::vector<Residuals> ResidualsOf(const KeyFrameGraph& of) {
  const PoseGraph& graph = of.graph;
  std::unordered_map<std::int64_t, const double*> poses;
  for (const PoseGraphNode& node : graph.nodes) poses.emplace(node.id, node.pose.data());
  std::map<std::size_t, Residuals> series;
  for (std::size_t i = 0; i < graph.factors.size(); ++i) {
    const PoseGraphFactor& factor = graph.factors[i];
    std::vector<const double*> blocks;
    for (const std::int64_t node : factor.nodes) blocks.push_back(poses.at(node));
    Eigen::VectorXd r(factor.cost->num_residuals());
    if (!EvaluatesTo(*factor.cost, blocks, &r)) r.setConstant(HUGE_VAL);
    series[of.series[i]].push_back(std::move(r));
  }
  std::vector<Residuals> all;
  for (auto& [number, residuals] : series) all.push_back(std::move(residuals));
  return all;
}

// Returns the mean square of the sums of `length` consecutive residuals: 1 if they are noise.
double MeanSquareOfSums(const Residuals& residuals, std::size_t length) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + length <= residuals.size(); ++i, ++count) {
    Eigen::VectorXd added = residuals[i];
    for (std::size_t k = i + 1; k < i + length; ++k) added += residuals[k];
    sum += added.squaredNorm() / static_cast<double>(length * residuals[i].size());
  }
  return sum / static_cast<double>(count);
}

// Returns whether the measurements fit as expected from their noise: half of them are within the
// median, so that less than half may be outliers of any size; and the inliers do not accumulate
// over any stretch of the path, as they do if the path is bent.
bool FitsItsNoise(const KeyFrameGraph& graph) {
  constexpr double kMedian = 0.0, kFar = 3.09;  // 50 and 99.9 %
  std::ptrdiff_t within = 0;
  for (Residuals& residuals : ResidualsOf(graph)) {
    for (Eigen::VectorXd& r : residuals) {
      const auto n = static_cast<double>(r.size());
      const double chi2 = r.squaredNorm();
      within += chi2 <= Chi2Quantile(n, kMedian) ? 1 : -1;
      if (!(chi2 <= Chi2Quantile(n, kFar))) r.setZero();
    }
    for (std::size_t length = 1; 2 * length <= residuals.size(); length *= 2) {
      if (MeanSquareOfSums(residuals, length) > 1.0) return false;
    }
  }
  return within >= 0;
}

}  // namespace

// One adjustment, on a copy of the map, and its result.
class FactorAdjuster::Job {
 public:
  Job(Map map, SubmapId submap, std::span<const LoopEdge> loops, KeyFrameMoves moves,
      const MeasurementModel& model, const UserFactorOptions& options,
      const KeyFrameGraphOptions& graph, int threads, RunProfile* profile)
      : map_(std::move(map)),
        submap_(submap),
        numbers_(FactorsOfWorld(map_, submap, {}).numbers),
        loops_(loops.begin(), loops.end()),
        moves_(std::move(moves)),
        model_(model),
        options_(options),
        graph_(graph),
        solver_threads_(std::max(1, threads)),
        profile_(profile),
        task_(threads > 0, [this](const std::stop_token& stop) { Run(stop); },
              {"user factors", profile, ThreadPriority::kBackground}) {}

  // Ends the job after the current iteration; so does the destructor.
  void Cancel() { task_.Cancel(); }
  bool IsDone() const { return task_.IsDone(); }
  SubmapId submap() const { return submap_; }
  // MapFactor::number of the factors in that world.
  const std::vector<std::size_t>& numbers() const { return numbers_; }

  // Rethrows the exception that ended the work. moves: of the keyframes, so far.
  FactorAdjustmentReport Write(Map* map, KeyFrameMoves* moves) {
    task_.Wait();
    if (!report_.accepted) return report_;
    Apply(correction_, map);
    for (auto& [id, move] : moves_) (*moves)[id] = move;
    return report_;
  }

 private:
  void Run(const std::stop_token& stop) {
    const StageTimer timer(profile_, "adjustment to user factors");
    const Stopwatch watch;
    std::atomic<bool> stopped = false;
    const std::stop_callback on_stop(stop, [&] { stopped = true; });
    for (const ReferenceFrameId id : map_.factors().frames()) {
      // Estimated anew each time: an estimate from a short path may be wrong.
      const auto T_FW = AlignFrame(map_, id, submap_, options_.max_angle);
      if (T_FW) map_.factors().Place(id, map_.Root(submap_), *T_FW);
    }
    Solve(&stopped);
    report_.seconds = watch.Seconds();
    map_ = Map();  // as large as the map itself
  }

  void Solve(const std::atomic<bool>* stopped) {
    if (map_.NumKeyFramesOf(submap_) < 2) {
      report_.message = "less than two keyframes";
      return;
    }
    KeyFrameGraph graph = MakeKeyFrameGraph(map_, model_, loops_, graph_, submap_);
    report_.keyframes = static_cast<int>(graph.keyframes.size());
    report_.factors = static_cast<int>(graph.graph.factors.size());
    report_.excluded = graph.excluded;
    report_.fault = graph.fault;
    if (graph.graph.factors.empty()) {
      report_.message = graph.excluded > 0 ? "no factor can be evaluated: " + graph.fault
                                           : "where the factors' frame lies is not known yet";
      return;
    }
    TakeOutMoves(&graph);
    report_.accepted = SolveAsStiffAsFits(stopped, &graph);
    if (!report_.accepted) return;
    for (std::size_t i = 0; i < graph.keyframes.size(); ++i) {
      const Pose& T_WC = graph.graph.nodes[i].pose;
      const Pose& before = map_.keyframe(graph.keyframes[i])->T_WC;
      report_.moved = std::max(report_.moved, (T_WC.p() - before.p()).norm());
      Pose& move = moves_.at(graph.keyframes[i]);
      move = move * before.Inverse() * T_WC;
      correction_.after.keyframes.emplace(graph.keyframes[i], T_WC);
    }
    correction_.after.frames = graph.FramePoses();
  }

  // Solves with the stiffest odometry that the factors allow: softer odometry would follow the
  // noise of the factors, and outliers. Returns false if nothing could be solved.
  bool SolveAsStiffAsFits(const std::atomic<bool>* stopped, KeyFrameGraph* graph) {
    PoseGraphOptions solve;
    solve.estimate_variance_factor = false;
    solve.solver.threads = solver_threads_;
    solve.solver.stop = stopped;
    const auto count = static_cast<std::int64_t>(graph->keyframes.size());
    const PoseGraph as_made = graph->graph;
    bool solved = false;
    for (const double trust : kTrust) {
      graph->graph = as_made;
      for (PoseGraphEdge& edge : graph->graph.edges) {
        if (edge.trusted && edge.i < count) edge.information *= trust;
      }
      const PoseGraphSummary summary = SolvePoseGraph(&graph->graph, solve);
      report_.message = summary.message;
      solved = summary.status != SolveStatus::kFailed;
      if (*stopped || (solved && FitsItsNoise(*graph))) break;
    }
    return solved;
  }

  // Sets the relative poses of odometry, and of covisible keyframes within some steps, to those by
  // images alone. Across a loop or a seam of submaps the current map is more accurate.
  void TakeOutMoves(KeyFrameGraph* graph) const {
    constexpr std::int64_t kNear = 30;  // steps
    const auto count = static_cast<std::int64_t>(graph->keyframes.size());
    const auto keyframe = [&](std::int64_t node) {
      return graph->keyframes[static_cast<std::size_t>(node)];
    };
    const auto by_images = [&](std::int64_t node) {
      return map_.keyframe(keyframe(node))->T_WC * moves_.at(keyframe(node)).Inverse();
    };
    for (PoseGraphEdge& edge : graph->graph.edges) {
      if (!edge.trusted || edge.i >= count || edge.j >= count) continue;
      const bool near = std::abs(edge.j - edge.i) <= kNear;
      const bool one_submap =
          map_.keyframe(keyframe(edge.i))->submap == map_.keyframe(keyframe(edge.j))->submap;
      if (near && one_submap) edge.Z = by_images(edge.i).Inverse() * by_images(edge.j);
    }
  }

  Map map_;
  const SubmapId submap_;
  const std::vector<std::size_t> numbers_;
  const std::vector<LoopEdge> loops_;
  KeyFrameMoves moves_;
  const MeasurementModel model_;  // a copy: T_BC may be re-estimated while this runs
  const UserFactorOptions options_;
  const KeyFrameGraphOptions graph_;
  const int solver_threads_;
  FactorAdjustmentReport report_;
  MapEdit correction_;
  RunProfile* const profile_;
  BackgroundTask task_;  // last: it uses all of the above and ends first
};

FactorAdjuster::FactorAdjuster(const MeasurementModel& model, const UserFactorOptions& options,
                               const KeyFrameGraphOptions& graph, int threads, RunProfile* profile)
    : model_(model),
      options_((options.Validate(), options)),
      graph_(graph),
      threads_(threads),
      profile_(profile) {}

FactorAdjuster::~FactorAdjuster() = default;

void FactorAdjuster::Adopt(const Map& map) {
  for (const SubmapId root : map.roots()) {
    MarkAdjusted(FactorsOfWorld(map, root, {}).numbers);
  }
}

void FactorAdjuster::MarkAdjusted(std::span<const std::size_t> numbers) {
  for (const std::size_t number : numbers) {
    if (adjusted_.size() <= number) adjusted_.resize(number + 1);
    adjusted_[number] = true;
  }
}

bool FactorAdjuster::Begin(const Map& map, SubmapId submap, std::span<const LoopEdge> loops) {
  if (!job_.HasRoom()) return false;
  const FactorsOfWorld factors(map, submap, adjusted_);
  const double share = std::ceil(options_.share * static_cast<double>(factors.old));
  if (static_cast<double>(factors.fresh) < std::max<double>(options_.every, share)) return false;
  return Start(map, submap, loops);
}

bool FactorAdjuster::BeginLast(const Map& map, SubmapId submap, std::span<const LoopEdge> loops) {
  const FactorsOfWorld factors(map, submap, adjusted_);
  return factors.fresh > 0 && Start(map, submap, loops);
}

bool FactorAdjuster::Start(const Map& map, SubmapId submap, std::span<const LoopEdge> loops) {
  if (!job_.IsEmpty()) return false;
  Inherit(map, &moves_);
  job_.Put(std::make_unique<Job>(map.Clone(), submap, loops, moves_, model_, options_, graph_,
                                 threads_, profile_));
  return true;
}

bool FactorAdjuster::HasResult() const {
  return !job_.IsEmpty() && job_->IsDone();
}

std::optional<FactorAdjustmentReport> FactorAdjuster::Finish(Map* map) {
  const std::unique_ptr<Job> job = job_.Take();
  if (!job) return std::nullopt;
  MarkAdjusted(job->numbers());
  return job->Write(map, &moves_);
}

void FactorAdjuster::Drop() {
  job_.Cancel();
}

SubmapId FactorAdjuster::submap() const {
  return job_.IsEmpty() ? SubmapId(kNoId) : job_->submap();
}

void FactorAdjuster::Remember(const Map& map, KeyFrameMoves by_loop) {
  if (by_loop.empty()) return;
  Inherit(map, &moves_);
  Inherit(map, &by_loop);
  for (const auto& [id, move] : by_loop) {
    Pose& so_far = moves_[id];
    so_far = so_far * move;
  }
}

}  // namespace highwall
