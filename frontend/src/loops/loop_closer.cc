#include "loops/loop_closer.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include <highwall/core/error.h>

#include "loops/map_correction.h"

namespace highwall {

struct LoopCloser::Result {
  LoopReport report;
  MapCorrection correction;
};

// One loop on its way: the copy of the map that it is closed in, and what has come out.
class LoopCloser::Job {
 public:
  Job(Map map, Loop loop, std::vector<LoopEdge> old_loops, const MeasurementModel& model,
      int levels, const LoopCloserOptions& options)
      : map_(std::move(map)),
        loop_(std::move(loop)),
        old_loops_(std::move(old_loops)),
        model_(model),
        levels_(levels),
        options_(options) {
    if (options_.background) {
      thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
    } else {
      Run({});
    }
  }

  // Gives up as soon as the iteration that runs is over; so does the destructor.
  void Stop() { thread_.request_stop(); }
  void Wait() {
    if (thread_.joinable()) thread_.join();
  }
  // Nothing is worked on any more, and all that came out can be taken.
  bool IsDone() const { return done_; }

  // The loop itself, not the adjustment after it, is still being closed, or waits to be taken.
  bool IsClosing() const { return !corrected_taken_; }

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
    try {
      Close(stop);
    } catch (const std::exception& error) {  // would end the process on a thread of its own
      Result failed;
      failed.report.message = error.what();
      Put(std::move(failed));
    }
    map_ = Map();  // as large as the map itself
    done_ = true;
  }

  void Close(const std::stop_token& stop) {
    LoopCorrectionResult closed =
        CorrectLoop(old_loops_, loop_, model_, levels_, options_.correction, &map_);
    Result result;
    result.report.accepted = closed.accepted;
    result.report.message = closed.message;
    result.report.fused_points = static_cast<int>(closed.fusion.points.size());
    result.report.fused_lines = static_cast<int>(closed.fusion.lines.size());
    if (closed.accepted) {
      result.correction = {GeometryOf(map_), std::move(closed.fusion), {}};
    }
    Put(std::move(result));
    if (!closed.accepted || !options_.adjust || stop.stop_requested()) return;

    BundleAdjuster adjuster(map_, model_, map_.keyframe_ids(), {}, options_.bundle);
    adjuster.Solve(stop);
    if (stop.stop_requested()) return;
    const BundleAdjustmentReport bundle = adjuster.Write(&map_);
    result = {};
    result.report.accepted = true;
    result.report.bundle = bundle;
    if (bundle.usable) {
      result.correction = {GeometryOf(map_), {}, adjuster.outliers()};
    }
    Put(std::move(result));
  }

  void Put(Result result) {
    result.report.loop = loop_;
    result.report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const std::lock_guard lock(mutex_);
    results_.push_back(std::move(result));
  }

  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  Map map_;
  const Loop loop_;
  const std::vector<LoopEdge> old_loops_;
  const MeasurementModel& model_;
  const int levels_;
  const LoopCloserOptions options_;
  bool corrected_taken_ = false;
  std::atomic<bool> done_ = false;
  mutable std::mutex mutex_;
  std::vector<Result> results_;
  std::jthread thread_;  // last: it uses all of the above and is joined first
};

LoopCloser::LoopCloser(const MeasurementModel& model, int levels, const LoopCloserOptions& options)
    : model_(model),
      levels_(levels),
      options_((options.Validate(), options)),
      detector_(model, levels, options.detector) {}

LoopCloser::~LoopCloser() = default;

bool LoopCloser::InsertKeyFrame(const Map& map, KeyFrameId keyframe) {
  std::erase_if(ending_, [](const auto& job) { return job->IsDone(); });
  // Until the map is corrected, the keyframes that follow see the same loop.
  if (!options_.enabled || (job_ && job_->IsClosing())) return false;
  auto loop = detector_.Detect(map, keyframe, loops_);
  if (!loop) return false;
  GiveUp();  // the adjustment after an older loop
  job_ = std::make_unique<Job>(map.Clone(), std::move(*loop), loops_, model_, levels_, options_);
  return true;
}

bool LoopCloser::HasNews() const {
  return job_ && job_->HasResults();
}

std::vector<LoopReport> LoopCloser::Update(Map* map) {
  std::vector<LoopReport> reports;
  if (!job_) return reports;
  const bool done = job_->IsDone();
  for (Result& result : job_->Take()) {
    if (result.report.accepted) {
      // Of an adjustment that failed nothing is to be applied.
      if (!result.report.bundle || result.report.bundle->usable) Apply(result.correction, map);
      if (!result.report.bundle) loops_.push_back(result.report.loop.edge);
    }
    reports.push_back(std::move(result.report));
  }
  if (done) job_.reset();
  return reports;
}

void LoopCloser::GiveUp() {
  if (!job_) return;
  job_->Stop();
  ending_.push_back(std::move(job_));
}

std::vector<LoopReport> LoopCloser::Finish(Map* map) {
  if (job_) job_->Wait();
  return Update(map);
}

}  // namespace highwall
