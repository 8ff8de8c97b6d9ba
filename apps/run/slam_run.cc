#include "run/slam_run.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/frontend/features/make_point_extractor.h>
#include <highwall/frontend/local/global_adjustment.h>
#include <highwall/frontend/map/feature_type_mismatch.h>
#include <highwall/frontend/map/map.h>
#include <highwall/internal/stage_timer.h>
#include <highwall/internal/stopwatch.h>

#include "cli/attempt.h"
#include "run/dense_stage.h"
#include "run/depth_scale_check.h"
#include "run/finished_run.h"
#include "run/frame_source.h"
#include "run/loaded_map.h"
#include "run/loss_advice.h"
#include "run/process_memory.h"
#include "run/run_observer.h"
#include "run/trace_file.h"

namespace highwall::apps {
namespace {

// A less accurate scale does not show whether a depth camera is calibrated.
constexpr double kMaxScaleSigma = 0.02;
constexpr Stamp kStateInterval = 250'000'000;  // [ns] between ImuStates: biases change slowly

// Samples of StageTimes, one per frame.
struct StageSamples {
  std::vector<double> points, lines, features, pose, tracking, mapping, frame;

  void Add(const FrameTimes& times, bool keyframe) {
    points.push_back(times.points);
    lines.push_back(times.lines);
    features.push_back(times.features);
    pose.push_back(times.tracking);
    tracking.push_back(times.features + times.tracking);
    if (keyframe) mapping.push_back(times.mapping);
    frame.push_back(times.total);
  }

  StageTimes Summary() const {
    return {Summarize(points),
            Summarize(lines),
            Summarize(features),
            Summarize(pose),
            Summarize(tracking),
            Summarize(mapping),
            Summarize(frame),
            {},
            {}};
  }
};

// Frames of a recording, in the order of their stamps: a stamp far ahead of the others is a pause
// of the recording, which may be longer than that of a live camera.
class StampedFrames {
 public:
  FrameResult Track(const RgbdImage& image, SlamSystem& slam) {
    const bool paused = last_ && ToSeconds(image.stamp - *last_) > kLongestPause;
    last_ = image.stamp;
    if (!paused) return slam.Track(image);
    try {
      return slam.Track(image);
    } catch (const InvalidArgument&) {
      return slam.Track(image);  // accepted on the second call
    }
  }

 private:
  std::optional<Stamp> last_;
};

// Does the same for GPS fixes.
class GpsReplay {
 public:
  GpsReplay(const std::optional<GpsFeed>& feed, SlamSystem& slam) : feed_(feed) {
    if (feed_) frame_ = slam.AddReferenceFrame();
  }

  void FeedUntil(Stamp image, SlamSystem& slam) {
    if (!feed_) return;
    for (; next_ < feed_->fixes.size() && feed_->fixes[next_].stamp <= image; ++next_) {
      slam.AddFactor(MakeGpsFactor(feed_->fixes[next_], feed_->antenna_B, frame_));
    }
  }

  // Call last.
  std::optional<GpsSummary> Summary(const SlamSystem& slam) const {
    if (!feed_) return std::nullopt;
    return SummarizeGps(*feed_, slam.factor_counts_by_source()[kGpsSource], slam.T_FW(frame_),
                        slam.trajectory());
  }

 private:
  const std::optional<GpsFeed>& feed_;
  ReferenceFrameId frame_;
  std::size_t next_ = 0;
};

// Accumulates an InertialSummary.
class InertialTally {
 public:
  void Add(const FrameResult& result) {
    if (!result.inertial) return;
    const InertialReport& report = *result.inertial;
    summary_.last = report;
    if (report.status == InertialStatus::kGivenUp) {
      ++summary_.given_up;
      summary_.given_up_because = report.reason;
    }
    if (report.estimate && !summary_.initialized) summary_.initialized = result.stamp;
    AddState(result.stamp, report);
    if (result.state == TrackingState::kInertial) ++summary_.dead_reckoned;
    if (report.saturated) ++summary_.saturated;
    if (report.tight) tight_milliseconds_.push_back(report.tight->milliseconds);
    if (report.tight && !report.tight->accepted) ++summary_.refused_updates;
    if (report.contradicted) {
      ++summary_.contradicted;
    } else if (report.restarted) {
      ++summary_.restarts;
    }
    if (report.weight > 0.0) {
      const int dof = report.innovation_dof;
      WeighedInterval& interval =
          summary_.intervals.emplace_back(WeighedInterval{result.stamp, report.weight, {}});
      if (dof > 0) interval.innovation = report.squared_innovation / dof;
    }
    squared_innovation_ += report.squared_innovation;
    dof_ += report.innovation_dof;
  }

  InertialSummary Summary() const {
    InertialSummary summary = summary_;
    summary.tight = Summarize(tight_milliseconds_);
    if (const auto n = static_cast<double>(summary.intervals.size()); n > 0.0) {
      double weights = 0.0;
      for (const WeighedInterval& interval : summary.intervals) weights += interval.weight;
      summary.mean_weight = weights / n;
      summary.reduced_share =
          static_cast<double>(std::ranges::count_if(
              summary.intervals, [](const WeighedInterval& i) { return i.weight < 1.0; })) /
          n;
    }
    if (dof_ > 0) summary.mean_innovation = squared_innovation_ / dof_;
    return summary;
  }

 private:
  void AddState(Stamp stamp, const InertialReport& report) {
    std::vector<ImuState>& states = summary_.states;
    if (!report.estimate) return;
    if (!states.empty() && stamp - states.back().stamp < kStateInterval) return;
    states.push_back({stamp, report.estimate->bias, report.time_offset});
  }

  InertialSummary summary_;
  std::vector<double> tight_milliseconds_;
  double squared_innovation_ = 0.0;
  int dof_ = 0;
};

Map LoadMapFor(const std::filesystem::path& path, const PinholeCamera& camera,
               const FrameBuilderOptions& frame) {
  if (path.empty()) return {};
  SavedMap saved = LoadMap(path);
  const FeatureType kind = MakePointExtractor(frame)->kind();
  if (const auto clash = FindMismatch(saved.map, kind)) {
    throw IoError(path, "is a map of points by " + clash->first + ", this run finds them by " +
                            clash->second + ": choose another " +
                            (saved.map.feature_type().name != kind.name ? "--point-detector"
                                                                        : "frame.orb.pyramid"));
  }
  if (!IsSameCamera(saved.camera, camera)) throw IoError(path, "is a map of another camera");
  return std::move(saved.map);
}

SlamSystem MakeSystem(const RgbdSensor& sensor, const SlamRunOptions& options,
                      RunProfile* profile) {
  SlamOptions slam = options.slam;
  if (options.live) slam.mapper.wait = false;
  SlamInputs inputs{.map = LoadMapFor(options.load_map, sensor.camera, slam.frame),
                    .profile = profile};
  if (options.imu) inputs.imu = options.imu->calibration;
  return SlamSystem(sensor, slam, std::move(inputs));
}

void Record(const std::vector<LoopReport>& reports, std::vector<LoopEvent>* events) {
  for (const LoopReport& report : reports) {
    if (report.bundle) continue;  // of a loop already recorded
    events->push_back(
        {report.loop.edge, report.accepted, report.merge.has_value(), report.message});
  }
}

void Count(const std::vector<LoopReport>& reports, LoopCounts* counts) {
  for (const LoopReport& report : reports) {
    counts->worst_seconds = std::max(counts->worst_seconds, report.seconds);
    if (report.bundle) continue;  // of a loop already counted
    if (report.accepted && report.merge) ++counts->merges;
    ++(report.accepted ? counts->closed : counts->refused);
    counts->fused_points += static_cast<std::size_t>(report.fused_points);
    counts->fused_lines += static_cast<std::size_t>(report.fused_lines);
  }
}

void Count(const BundleAdjustmentReport& report, AdjustmentCounts* counts) {
  ++counts->all;
  if (report.refused) ++counts->refused;
  if (!report.usable && !report.refused) ++counts->failed;
  if (report.usable && !report.moved) ++counts->unmoved;
  counts->rejected_steps += static_cast<std::size_t>(report.rejected_steps);
}

void Count(const std::vector<LoopReport>& reports, AdjustmentCounts* counts) {
  for (const LoopReport& report : reports) {
    if (report.bundle) Count(*report.bundle, counts);
  }
}

// Returns the extrinsics estimated online, if available.
Pose ExtrinsicsOf(const SlamRunOptions& options, const SlamRun& run) {
  if (!options.imu) return Pose();
  if (!run.inertial || !run.inertial->last.extrinsics) return options.imu->calibration.T_BC;
  return run.inertial->last.extrinsics->T_BC;
}

MeasurementModel ModelOf(const Map& map, const RgbdSensor& sensor, const SlamRunOptions& options,
                         const SlamRun& run) {
  return MeasurementModel(sensor, options.slam.measurement, ExtrinsicsOf(options, run),
                          map.feature_type().pyramid);
}

std::optional<DepthScale> ScaleOf(const Map& map, const RgbdSensor& sensor,
                                  const SlamRunOptions& options, const SlamRun& run) {
  if (!map.gravity_W()) return std::nullopt;
  const MeasurementModel model = ModelOf(map, sensor, options, run);
  return EstimateDepthScale(AdjustedWithoutImu(map, model, kGlobalAdjustment), model.T_BC());
}

void TakeScale(const std::optional<DepthScale>& scale, const RgbdSensor& sensor,
               InertialSummary* inertial) {
  if (!scale) return;
  if (scale->sigma <= kMaxScaleSigma) inertial->depth_scale = scale;
  if (IsScaleMeaningful(inertial->last)) {
    inertial->scale_finding = CheckDepthScale(*scale, sensor.depth_factor);
  }
}

// Accumulates the results of the frames of a run.
class RunTally {
 public:
  void Add(const FrameResult& result) {
    ++run_.frames;
    samples_.Add(result.times, result.mapping.has_value());
    inertial_.Add(result);
    Count(result.loops, &run_.loops);
    Count(result.loops, &run_.adjustments);
    if (result.adjustment) Count(*result.adjustment, &run_.adjustments);
    Record(result.loops, &run_.loop_events);
    run_.matched_points += result.matched_points;
    run_.matched_lines += result.matched_lines;
    run_.per_frame.push_back(
        {result.stamp, result.matched_points, result.matched_lines, result.times.total});
    if (result.reason) reasons_[result.stamp] = *result.reason;
    if (result.repeated) ++run_.repeated;
    if (result.colour_delay > 0) {
      run_.late_colour[result.stamp - result.colour_delay] = result.stamp;
    }
    if (HasPose(result.state)) {
      ++tracked_;
      causal_[result.submap].push_back({result.stamp, result.T_WC});
    }
    if (result.relocalized) ++run_.relocalizations;
    if (!result.unobservable_directions.empty()) ++run_.open_frames;
    if (!result.mapping) return;
    ++run_.keyframes_made;
    run_.keyframe_stamps[result.mapping->keyframe] = result.stamp - result.colour_delay;
  }

  // Call once, last. submaps: final ones, those with the loaded map first.
  SlamRun Take(std::vector<SubmapTrajectory> submaps) {
    SlamRun run = std::move(run_);
    if (tracked_ > 0) {
      run.matched_points /= static_cast<double>(tracked_);
      run.matched_lines /= static_cast<double>(tracked_);
    }
    std::set<Stamp> posed;
    for (SubmapTrajectory& submap : submaps) {
      for (const StampedPose& pose : submap.frames) posed.insert(pose.stamp);
      run.others.push_back({submap.submap,
                            submap.keyframes,
                            std::move(causal_[submap.submap]),
                            std::move(submap.frames),
                            std::move(submap.velocities),
                            {}});
    }
    for (const TrackedFrame& frame : run.per_frame) {
      if (posed.contains(frame.stamp)) continue;
      const auto reason = reasons_.find(frame.stamp);
      run.lost.push_back(frame.stamp);
      run.lost_because.push_back(reason != reasons_.end() ? ToString(reason->second) : "dropped");
      ++run.loss_reasons[run.lost_because.back()];
    }
    if (!run.others.empty()) {
      run.largest = std::move(run.others.front());
      run.others.erase(run.others.begin());
    }
    run.inertial = inertial_.Summary();
    run.times = samples_.Summary();
    return run;
  }

 private:
  SlamRun run_;
  std::size_t tracked_ = 0;
  std::map<Stamp, LossReason> reasons_;
  std::map<SubmapId, Trajectory> causal_;
  StageSamples samples_;
  InertialTally inertial_;
};

// Returns the keyframes that the run has made in its largest world.
Trajectory KeyFramesOf(const SlamRun& run, const LoadedMap& loaded, const Map& map) {
  if (run.largest.submap == kNoId) return {};
  return loaded.NewKeyFrames(run.largest.submap, map);
}

// Finalizes the map after tracking.
void FinishMap(const RgbdSensor& sensor, const SlamRunOptions& options, const LoadedMap& loaded,
               SlamSystem& slam, SlamRun* run) {
  run->refined = slam.refined_frames();
  run->sensor = slam.sensor();
  run->levels = slam.map().feature_type().pyramid.levels;
  const auto attempt = [run](const char* what, const auto& work) {
    Attempt(what, &run->failures, work);
  };
  if (run->inertial) {
    attempt("scale of the depth", [&] {
      TakeScale(ScaleOf(slam.map(), sensor, options, *run), sensor, &*run->inertial);
    });
  }
  if (options.adjust_all && slam.map().num_keyframes() > 1) {
    attempt("adjustment of everything", [&] {
      slam.AdjustAll();
      std::vector<SubmapTrajectory> submaps = loaded.First(slam.submaps(), slam.map());
      run->largest.adjusted = std::move(submaps.front().frames);
      for (std::size_t i = 1; i < submaps.size(); ++i) {
        run->others[i - 1].adjusted = std::move(submaps[i].frames);
      }
    });
  }
  if (options.calibrate && run->largest.submap != kNoId) {
    attempt("calibration of the camera", [&] {
      std::string reason;
      run->camera = CalibrateCamera(slam.map(), ModelOf(slam.map(), sensor, options, *run),
                                    run->largest.submap, *options.calibrate, &reason);
      if (!run->camera) throw std::runtime_error(reason);
    });
  }
  for (const std::filesystem::path& path : {options.save_map, options.keep_map}) {
    if (path.empty() || run->largest.trajectory.empty()) continue;
    attempt("saved map", [&] { SaveMap(path, sensor.camera, slam.map()); });
  }
  const SubmapId drawn = run->largest.submap != kNoId ? run->largest.submap : kFirstSubmap;
  run->keyframes = KeyFramesOf(*run, loaded, slam.map());
  run->sparse =
      SurveyMap(slam.map(), drawn,
                run->largest.adjusted.empty() ? run->largest.trajectory : run->largest.adjusted,
                run->keyframes);
  run->points = slam.map().num<MapPoint>();
  run->lines = slam.map().num<MapLine>();
}

// Destroys the system, whose memory is free for the dense map from then on, and returns its
// verdict.
SensorVerdict End(SlamSystem slam) {
  SensorVerdict verdict = slam.verdict();
  { const SlamSystem ended = std::move(slam); }
  ReturnFreeMemory();
  return verdict;
}

void SaveTrace(const SlamRunOptions& options, const RunProfile& profile, SlamRun* run) {
  if (options.trace.empty() || run->largest.trajectory.empty()) return;
  Attempt("trace", &run->failures, [&] { WriteTrace(options.trace, profile.trace()); });
}

// Returns everything that was found before, during and after tracking. report: called for what is
// found only now; may be empty.
SensorVerdict VerdictOf(const SlamRun& run, const SlamRunOptions& options,
                        const SensorVerdict& tracked, const FindingCallback& report) {
  SensorVerdict verdict = options.before;
  for (const SensorFinding& finding : tracked.findings) verdict.Add(finding);
  const auto add = [&](const SensorFinding& finding) {
    if (verdict.Add(finding) && report) report(finding);
  };
  // While tracking, an IMU that contradicts the scale of the depth is given up as well.
  const auto is_of_scale = [](const SensorFinding& finding) {
    return finding.fault == SensorFault::kDepthScale;
  };
  if (run.inertial && run.inertial->last.status == InertialStatus::kGivenUp &&
      std::ranges::none_of(verdict.findings, IsOfImu) &&
      std::ranges::none_of(tracked.findings, is_of_scale)) {
    add({SensorFault::kImuInconsistent, Trust::kDoubtful,
         "the IMU is not used: " + run.inertial->last.reason,
         "check the section imu of calibration.yaml with highwall calibrate"});
  }
  if (run.inertial && run.inertial->scale_finding &&
      std::ranges::none_of(verdict.findings, LeavesNoScale)) {
    add(*run.inertial->scale_finding);
  }
  if (!run.map_met && !run.largest.trajectory.empty()) {
    add({SensorFault::kMapNotMet, Trust::kDoubtful,
         "the loaded map was never recognized: the poses are in a world of their own",
         "give the map of this place, or leave --load-map out"});
  }
  if (options.load_map.empty()) {
    if (auto losses = UnexplainedLosses(run.loss_reasons, run.frames)) add(*losses);
  }
  const auto& dense = run.largest.dense;
  if (dense && dense->cloud.size() == 0 && run.keyframes.size() > 1) {
    add({SensorFault::kEmptyMap, Trust::kDoubtful,
         "the dense map is empty: hardly any depth reading is in the sensor's range",
         "check depth_factor and depth_range with highwall info"});
  }
  return verdict;
}

double PosedShare(const SlamRun& run, std::size_t images) {
  const std::size_t posed = run.frames - run.lost.size();
  return images > 0 ? static_cast<double>(posed) / static_cast<double>(images) : 0.0;
}

// Counts in the processed part of the recording.
std::size_t CountWithoutDepth(const Dataset& dataset, const SlamRunOptions& options) {
  const auto is_in = [&](Stamp stamp) {
    const bool after = options.begin == 0 ||
                       (options.begin < dataset.size() && stamp >= dataset.stamp(options.begin));
    return after && (options.end >= dataset.size() || stamp < dataset.stamp(options.end));
  };
  return static_cast<std::size_t>(std::ranges::count_if(dataset.stamps_without_depth(), is_in));
}

MemoryAtRest Measure(const SlamSystem& slam, DenseStage* mapping) {
  MemoryAtRest memory{.peak_mib = PeakMemoryMib(), .held = slam.memory()};
  for (MemoryShare& share : mapping->memory()) memory.held.push_back(std::move(share));
  ReturnFreeMemory();
  memory.mib = ResidentMemoryMib();
  return memory;
}

// Tracks the frames until the last one, or until a stop is requested.
void TrackAll(const SlamRunOptions& options, const RunCallbacks& callbacks, FrameSource* reader,
              ImuReplay* imu, GpsReplay* gps, SlamSystem* slam, RunTally* tally) {
  StampedFrames tracked;
  const auto stopped = [&] { return options.stop && reader->left() > 0 && options.stop(); };
  while (const std::optional<RgbdImage> image = stopped() ? std::nullopt : reader->Next()) {
    imu->FeedUntil(image->stamp, *slam);
    gps->FeedUntil(image->stamp, *slam);
    // How many wait depends on the machine, on which a deterministic run must not depend.
    if (options.slam.threads > 0) slam->SetBacklog(reader->waiting());
    const FrameResult result = tracked.Track(*image, *slam);
    tally->Add(result);
    reader->Measure(image->stamp);
    if (callbacks.on_frame) {
      callbacks.on_frame(result, *image, reader->position(), reader->count());
    }
    if (options.observer) {
      options.observer->OnFrame(result, *image, *slam,
                                {reader->position(), reader->count(), reader->dropped()});
    }
  }
}

// camera: null, or in the place of the dataset, which is empty.
SlamRun RunOn(const Dataset& dataset, ImageSource* camera, const RgbdSensor& sensor,
              const SlamRunOptions& options, const RunCallbacks& callbacks) {
  const Stopwatch stopwatch;
  RunProfile profile(!options.trace.empty());
  const ProfiledThread caller({"tracking", &profile});
  SlamSystem slam = MakeSystem(sensor, options, &profile);
  const LoadedMap loaded(slam.map());
  ImuReplay imu(options.imu, camera);
  GpsReplay gps(options.gps, slam);
  DenseStage mapping(slam, dataset, sensor, options, &profile);
  SlamCallbacks followed{.on_finding = callbacks.on_finding};
  mapping.AddTo(&followed);
  if (options.observer) options.observer->AddTo(&followed);
  slam.SetCallbacks(std::move(followed));
  FrameSource reader(dataset, camera, options, &profile);

  RunTally tally;
  TrackAll(options, callbacks, &reader, &imu, &gps, &slam, &tally);
  const std::size_t dropped = reader.dropped(), left = reader.left();
  std::vector<LoopReport> last;
  std::vector<std::string> failures;
  if (!reader.failure().empty()) failures.push_back(reader.failure());
  Attempt("last adjustment", &failures, [&] { last = slam.Finish(); });
  SlamRun run = tally.Take(loaded.First(slam.submaps(), slam.map()));
  run.map_met = loaded.IsMet(run.largest.submap, slam.map());
  run.failures = std::move(failures);
  Count(last, &run.loops);
  Count(last, &run.adjustments);
  Record(last, &run.loop_events);
  if (!options.imu) run.inertial.reset();
  run.gps = gps.Summary(slam);
  run.dropped = dropped;
  run.times.delay = Summarize(reader.delays());
  run.postponed = slam.postponed();
  run.left = left;
  run.is_of_camera = camera != nullptr;
  run.skipped = reader.count() - run.left - run.frames - run.dropped;
  run.without_depth = CountWithoutDepth(dataset, options);
  run.keyframes = KeyFramesOf(run, loaded, slam.map());
  if (callbacks.on_tracked && !run.largest.trajectory.empty()) callbacks.on_tracked(run);
  FinishMap(sensor, options, loaded, slam, &run);
  mapping.Complete();
  run.memory = Measure(slam, &mapping);
  const SensorVerdict verdict = End(std::move(slam));
  mapping.Finish(&run);
  run.verdict = VerdictOf(run, options, verdict, callbacks.on_finding);
  run.seconds = stopwatch.Seconds();
  run.processor = profile.processor_seconds();
  SaveTrace(options, profile, &run);
  return run;
}

}  // namespace

TimingStatistics Summarize(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double quantile) {
    return samples[static_cast<std::size_t>(quantile * static_cast<double>(samples.size() - 1))];
  };
  return {
      std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size()),
      at(0.5),
      at(0.95),
      at(0.99),
      samples.back(),
      samples.size()};
}

double Mib(const MemoryShare& share) {
  return static_cast<double>(share.bytes) / (1024.0 * 1024.0);
}

double Coverage(const SlamRun& run) {
  return PosedShare(run, run.frames + run.skipped + run.dropped);
}

double ColourCoverage(const SlamRun& run) {
  return PosedShare(run, CountColourImages(run));
}

std::size_t CountColourImages(const SlamRun& run) {
  return run.frames + run.skipped + run.dropped + run.without_depth;
}

double ProcessorMsPerFrame(const SlamRun& run) {
  if (run.frames == 0) return 0.0;
  return 1e3 * (run.processor.process - run.processor.decoding) / static_cast<double>(run.frames);
}

void RequireWhole(const SlamRun& run) {
  if (!run.failures.empty()) throw std::runtime_error(run.failures.front());
}

SlamRun RunSlam(const Dataset& dataset, const RgbdSensor& sensor, const SlamRunOptions& options,
                const RunCallbacks& callbacks) {
  return RunOn(dataset, nullptr, sensor, options, callbacks);
}

SlamRun RunSlam(ImageSource& camera, const RgbdSensor& sensor, const SlamRunOptions& options,
                const RunCallbacks& callbacks) {
  return RunOn(NoDataset(), &camera, sensor, options, callbacks);
}

}  // namespace highwall::apps
