#include "loops/loop_closer.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <stop_token>
#include <utility>

#include <highwall/internal/stage_timer.h>
#include <highwall/internal/stopwatch.h>

namespace highwall {

struct LoopCloser::Result {
  LoopReport report;
  MapEdit correction;
  KeyFrameMoves by_factors{};
};

// One loop closure in progress: a copy of the map, and the results.
class LoopCloser::Job {
 public:
  Job(Map map, Loop loop, std::vector<LoopEdge> old_loops, const MeasurementModel& model,
      const LoopCloserOptions& options, const BundleAdjustmentOptions& bundle, int threads,
      RunProfile* profile)
      : map_(std::move(map)),
        loop_(std::move(loop)),
        submap_(map_.keyframe(loop_.edge.keyframe)->submap),
        old_loops_(std::move(old_loops)),
        model_(model),
        options_(options),
        bundle_(bundle),
        solver_threads_(std::max(1, threads)),
        profile_(profile),
        task_(threads > 0, [this](const std::stop_token& stop) { Run(stop); },
              {"loops", profile, ThreadPriority::kBackground}) {}

  // Ends the job after the current iteration; so does the destructor.
  void Cancel() { task_.Cancel(); }
  // Rethrows the exception that ended the work.
  void Wait() { task_.Wait(); }
  // Returns whether the work has ended and all results can be taken.
  bool IsDone() const { return task_.IsDone(); }

  // Returns whether the loop itself, not the adjustment after it, is being closed or waits to be
  // taken.
  bool IsClosing() const { return !corrected_taken_; }
  // That of the newer keyframe.
  SubmapId submap() const { return submap_; }

  bool HasResults() const {
    const std::lock_guard lock(mutex_);
    return !results_.empty();
  }

  std::vector<Result> Take() {
    const std::lock_guard lock(mutex_);
    corrected_taken_ = corrected_taken_ || !results_.empty();
    return std::exchange(results_, {});
  }

 private:
  void Run(const std::stop_token& stop) {
    const StageTimer timer(profile_, "loop closing");
    Close(stop);
    map_ = Map();  // as large as the map itself
  }

  void Close(const std::stop_token& stop) {
    LoopCorrectionResult closed = CorrectLoop(old_loops_, loop_, model_, options_.graph,
                                              options_.correction, &map_, solver_threads_);
    Result result;
    result.report.accepted = closed.accepted;
    result.report.message = closed.message;
    result.report.fused_points = static_cast<int>(closed.fusion.merged.points.size());
    result.report.fused_lines = static_cast<int>(closed.fusion.merged.lines.size());
    result.report.merge = closed.merge;
    result.by_factors = std::move(closed.by_factors);
    if (closed.accepted) {
      result.correction = {GeometryOf(map_, submap_), std::move(closed.fusion), {}, closed.merge};
    }
    Put(std::move(result));
    if (!closed.accepted || !options_.adjust || stop.stop_requested()) return;

    const StageTimer timer(profile_, "adjustment after a loop");
    BundleAdjuster adjuster(map_, model_, map_.KeyFramesOf(submap_), {}, bundle_, solver_threads_);
    adjuster.Solve(stop);
    if (stop.stop_requested()) return;
    const BundleAdjustmentReport bundle = adjuster.Write(&map_);
    result = {};
    result.report.accepted = true;
    result.report.bundle = bundle;
    if (bundle.usable) {
      result.correction = AdjustedTo(map_, adjuster.outliers(), submap_);
    }
    Put(std::move(result));
  }

  void Put(Result result) {
    result.report.loop = loop_;
    result.report.seconds = watch_.Seconds();
    const std::lock_guard lock(mutex_);
    results_.push_back(std::move(result));
  }

  const Stopwatch watch_;
  Map map_;
  const Loop loop_;
  const SubmapId submap_;
  const std::vector<LoopEdge> old_loops_;
  const MeasurementModel model_;  // a copy: T_BC may be re-estimated while this runs
  const LoopCloserOptions options_;
  const BundleAdjustmentOptions bundle_;
  const int solver_threads_;
  RunProfile* const profile_;
  bool corrected_taken_ = false;
  mutable std::mutex mutex_;
  std::vector<Result> results_;
  BackgroundTask task_;  // last: it uses all of the above and ends first
};

LoopCloser::LoopCloser(const MeasurementModel& model, const LoopCloserOptions& options, int threads,
                       const BundleAdjustmentOptions& bundle, RunProfile* profile)
    : model_(model),
      options_((options.Validate(), options)),
      bundle_(bundle),
      threads_(threads),
      profile_(profile),
      detector_(model, options.detector, options.graph) {}

LoopCloser::~LoopCloser() = default;

bool LoopCloser::InsertKeyFrame(const Map& map, KeyFrameId keyframe,
                                const std::function<void()>& prepare) {
  // Until the map is corrected, the following keyframes would detect the same loop.
  if (!options_.enabled || IsClosing() || !job_.HasRoom()) return false;
  return Close(map, detector_.Detect(map, keyframe, loops_), prepare);
}

bool LoopCloser::InsertLast(const Map& map, std::span<const KeyFrameId> newest,
                            const std::function<void()>& prepare) {
  if (!options_.enabled || IsClosing()) return false;
  return Close(map, detector_.DetectLast(map, newest, loops_), prepare);
}

bool LoopCloser::Close(const Map& map, std::optional<Loop> loop,
                       const std::function<void()>& prepare) {
  if (!loop) return false;
  Drop();  // the adjustment after an older loop
  if (prepare) prepare();
  job_.Put(std::make_unique<Job>(map.Clone(), std::move(*loop), loops_, model_, options_, bundle_,
                                 threads_, profile_));
  return true;
}

std::vector<LoopReport> LoopCloser::TakeRefused() {
  std::vector<LoopReport> reports;
  for (RefusedLoop& refused : detector_.TakeRefused()) {
    reports.push_back({.loop = {.edge = refused.edge}, .message = std::move(refused.reason)});
  }
  return reports;
}

KeyFrameMoves LoopCloser::TakeMovesByFactors() {
  return std::exchange(by_factors_, {});
}

bool LoopCloser::IsClosing() const {
  return !job_.IsEmpty() && job_->IsClosing();
}

bool LoopCloser::HasResult() const {
  return !job_.IsEmpty() && (job_->HasResults() || job_->IsDone());
}

std::vector<LoopReport> LoopCloser::Update(Map* map) {
  if (job_.IsEmpty()) return {};
  return job_->IsDone() ? Finish(map) : Take(*job_, map);
}

std::vector<LoopReport> LoopCloser::Take(Job& job, Map* map) {
  std::vector<LoopReport> reports;
  for (Result& result : job.Take()) {
    if (result.report.accepted) {
      // A failed adjustment is not applied.
      if (!result.report.bundle || result.report.bundle->usable) Apply(result.correction, map);
      if (!result.report.bundle) {
        loops_.push_back(result.report.loop.edge);
        by_factors_ = std::move(result.by_factors);
      }
    }
    reports.push_back(std::move(result.report));
  }
  return reports;
}

SubmapId LoopCloser::submap() const {
  return job_.IsEmpty() ? SubmapId(kNoId) : job_->submap();
}

void LoopCloser::Drop() {
  detector_.Forget();
  job_.Cancel();
}

std::vector<LoopReport> LoopCloser::Finish(Map* map) {
  const std::unique_ptr<Job> job = job_.Take();
  if (!job) return {};
  job->Wait();  // first: nothing is applied if the work threw
  return Take(*job, map);
}

}  // namespace highwall
