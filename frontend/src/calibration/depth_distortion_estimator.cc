#include "calibration/depth_distortion_estimator.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include <highwall/frontend/calibration/camera_calibration.h>
#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/internal/stage_timer.h>

#include "features/corrected_depth.h"
#include "map/map_edit.h"

namespace highwall {
namespace {

constexpr std::size_t kFirst = 12;  // keyframes of a world at the first estimate
constexpr int kMost = 60;           // maximum number of keyframes used, the newest ones
// Growth in keyframes before the next search: the information is in the keyframes, and a search,
// with the adjustment of the map that follows, is worth its time if it could have doubled.
constexpr double kGrowth = 2.0;
constexpr double kBeyond = 3.0;  // standard deviations of a significant pattern
// Ratio of sigmas that justifies moving the map for a new pattern. Twice the information gives
// 0.71.
constexpr double kBetter = 0.9;

// Returns the keyframes of a world that were made in this run, ascending.
std::vector<KeyFrameId> MadeIn(const Map& map, SubmapId submap, KeyFrameId given) {
  std::vector<KeyFrameId> ids = map.KeyFramesOf(submap);
  std::erase_if(ids, [given](KeyFrameId id) { return id <= given; });
  return ids;
}

void CorrectDepth(const PinholeCamera& camera, const DepthPattern& pattern, KeyFrameId given,
                  Map* map) {
  for (const KeyFrameId id : map->keyframe_ids()) {
    if (id <= given) continue;
    Frame& frame = map->keyframe(id)->frame;
    frame.features = CorrectedDepth(*frame.features, camera, pattern);
  }
}

}  // namespace

// One search, on a copy of the map, and its result.
class DepthDistortionEstimator::Job {
 public:
  Job(Map map, const MeasurementModel& model, SubmapId submap, KeyFrameId given,
      const DepthDistortionEstimator& finder)
      : map_(std::move(map)),
        model_(model),
        submap_(submap),
        given_(given),
        camera_(finder.camera_),
        bundle_(finder.bundle_),
        known_sigma_(finder.sigma_),
        solver_threads_(std::max(1, finder.threads_)),
        profile_(finder.profile_),
        task_(finder.threads_ > 0, [this](const std::stop_token& stop) { Run(stop); },
              {"depth pattern", profile_, ThreadPriority::kBackground}) {}

  void Cancel() { task_.Cancel(); }
  bool IsDone() const { return task_.IsDone(); }
  SubmapId submap() const { return submap_; }
  // To be called once it is done.
  bool HasFound() const { return !found_.IsZero(); }

  // Returns the pattern found, zero if there is none.
  DepthPattern Write(Map* map) {
    task_.Wait();
    if (found_.IsZero()) return {};
    CorrectDepth(camera_, found_, given_, map);
    Apply(correction_, map);
    return found_;
  }
  // [1/m] RMS of its standard deviations.
  double sigma() const { return sigma_; }

 private:
  void Run(const std::stop_token& stop) {
    const StageTimer timer(profile_, "depth pattern");
    const std::optional<DepthPattern> pattern = Find();
    if (pattern && !stop.stop_requested()) Adjust(*pattern, stop);
    map_ = Map();  // as large as the map itself
  }

  // Returns empty if the pattern is not observable. A first pattern must be significant; the rest
  // of a known one need not be, but is only used if it is much more accurate by now.
  std::optional<DepthPattern> Find() {
    std::vector<KeyFrameId> ids = MadeIn(map_, submap_, given_);
    if (ids.size() > std::size_t{kMost}) ids.erase(ids.begin(), ids.end() - kMost);
    // Empty without points, or with points only that the solver cannot distinguish.
    const std::optional<CameraCalibration> found =
        CalibrateCamera(map_, model_, ids, {.intrinsics = false, .pattern_of = camera_});
    if (!found || !found->depth_pattern_seen) return std::nullopt;
    sigma_ = found->depth_pattern_sigma.Rms();
    const bool counts = known_sigma_ ? sigma_ < kBetter * *known_sigma_
                                     : found->depth_pattern.Rms() > kBeyond * sigma_;
    return counts ? std::optional(found->depth_pattern) : std::nullopt;
  }

  void Adjust(const DepthPattern& pattern, const std::stop_token& stop) {
    CorrectDepth(camera_, pattern, given_, &map_);
    BundleAdjuster adjuster(map_, model_, map_.KeyFramesOf(submap_), {}, bundle_, solver_threads_);
    adjuster.Solve(stop);
    if (stop.stop_requested() || !adjuster.Write(&map_).usable) return;
    correction_ = AdjustedTo(map_, adjuster.outliers(), submap_);
    found_ = pattern;
  }

  Map map_;
  const MeasurementModel model_;  // a copy: T_BC may be re-estimated while this runs
  const SubmapId submap_;
  const KeyFrameId given_;
  const PinholeCamera camera_;
  const BundleAdjustmentOptions bundle_;
  const std::optional<double> known_sigma_;  // [1/m] of the known pattern, RMS
  const int solver_threads_;
  double sigma_ = 0.0;  // [1/m] of the new pattern
  DepthPattern found_;
  MapEdit correction_;
  RunProfile* const profile_;
  BackgroundTask task_;  // last: it uses all of the above and ends first
};

DepthDistortionEstimator::DepthDistortionEstimator(const PinholeCamera& camera,
                                                   const DepthPatternOptions& options,
                                                   const BundleAdjustmentOptions& bundle,
                                                   int threads, RunProfile* profile)
    : camera_(camera),
      options_((options.Validate(), options)),
      bundle_(bundle),
      threads_(threads),
      profile_(profile),
      next_(kFirst) {}

DepthDistortionEstimator::~DepthDistortionEstimator() = default;

void DepthDistortionEstimator::Begin(const Map& map, const MeasurementModel& model, SubmapId submap,
                                     KeyFrameId given) {
  if (!options_.enabled || !IsIdle() || !job_.HasRoom()) return;
  job_.Take();  // a search that has found nothing
  const std::size_t keyframes = MadeIn(map, submap, given).size();
  if (keyframes < next_) return;
  next_ = static_cast<std::size_t>(std::ceil(kGrowth * static_cast<double>(keyframes)));
  job_.Put(std::make_unique<Job>(map.Clone(), model, submap, given, *this));
}

bool DepthDistortionEstimator::HasResult() const {
  return !job_.IsEmpty() && job_->IsDone() && job_->HasFound();
}

bool DepthDistortionEstimator::Finish(Map* map) {
  const std::unique_ptr<Job> job = job_.Take();
  if (!job) return false;
  const DepthPattern found = job->Write(map);
  if (found.IsZero()) return false;
  pattern_.nodes += found.nodes;
  sigma_ = job->sigma();
  return true;
}

bool DepthDistortionEstimator::IsIdle() const {
  return job_.IsEmpty() || (job_->IsDone() && !job_->HasFound());
}

SubmapId DepthDistortionEstimator::submap() const {
  return job_.IsEmpty() ? SubmapId(kNoId) : job_->submap();
}

void DepthDistortionEstimator::Drop() {
  job_.Cancel();
}

}  // namespace highwall
