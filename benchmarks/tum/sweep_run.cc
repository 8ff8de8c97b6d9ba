#include "sweep_run.h"

#include <malloc.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/mapping/point_cloud_io.h>

#include "cache_folder.h"
#include "run/process_memory.h"
#include "run/slam_run.h"
#include "timing.h"

namespace highwall::bench {
namespace {

// Keeps OpenCV on one thread, so that the clock of the caller counts all of its work.
class OneOpenCvThread {
 public:
  OneOpenCvThread() { cv::setNumThreads(1); }
  ~OneOpenCvThread() { cv::setNumThreads(before_); }
  OneOpenCvThread(const OneOpenCvThread&) = delete;
  OneOpenCvThread& operator=(const OneOpenCvThread&) = delete;

 private:
  const int before_ = cv::getNumThreads();
};

// Times cv::ORB on images of a sequence, evenly spaced over it: the unit of processor time of the
// machine as it is at the moment.
class OrbUnit {
 public:
  explicit OrbUnit(const Dataset& images) : images_(images) {}

  void Measure(const std::function<bool()>& stop) {
    const OneOpenCvThread single;
    const std::size_t count = std::min(images_.size(), kMostImages);
    for (std::size_t i = 0; i < count && !(stop && stop()); ++i) {
      const std::optional<RgbdImage> image = images_.Load(i * images_.size() / count);
      if (image) TimeOn(image->bgr);
    }
  }
  double WallMs() const { return apps::Summarize(wall_ms_).median; }
  double ProcessorMs() const { return apps::Summarize(processor_ms_).median; }

 private:
  static constexpr std::size_t kMostImages = 100;

  void TimeOn(const cv::Mat& bgr) {
    cv::cvtColor(bgr, gray_, cv::COLOR_BGR2GRAY);
    double processor = 0.0;
    wall_ms_.push_back(1e3 * WallSeconds([&] {
                         processor = ThreadSeconds([&] {
                           orb_->detectAndCompute(gray_, cv::noArray(), keypoints_, descriptors_);
                         });
                       }));
    processor_ms_.push_back(1e3 * processor);
  }

  const Dataset& images_;
  cv::Ptr<cv::ORB> orb_ = cv::ORB::create(1000, 1.2F, 8);
  cv::Mat gray_, descriptors_;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<double> wall_ms_, processor_ms_;
};

// Resets the peak memory, so that memory before the run is excluded if Linux allows it.
void ForgetPeakMemory() {
  ::malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}

void AddStatistics(const std::string& name, const ErrorStatistics& of, Scores* figures) {
  const std::pair<const char*, double> statistics[] = {
      {"max_m", of.max},   {"mean_m", of.mean}, {"median_m", of.median}, {"min_m", of.min},
      {"rmse_m", of.rmse}, {"sse_m2", of.sse},  {"std_m", of.std}};
  for (const auto& [statistic, value] : statistics) (*figures)[name + "_" + statistic] = value;
}

template <class Compute>
void AddError(const std::string& name, const Trajectory* truth, const Compute& compute,
              Scores* figures) {
  double& rmse = (*figures)[name + "_rmse_m"];
  if (truth == nullptr) return;
  try {
    AddStatistics(name, compute().statistics, figures);
  } catch (const InvalidArgument&) {  // too few poses
    rmse = -1.0;
  }
}

void AddErrors(const Trajectory* truth, const Trajectory& estimate, Scores* figures) {
  AddError(
      "ape", truth, [&] { return AbsolutePoseError(*truth, estimate); }, figures);
  AddError(
      "rpe_1_frame", truth, [&] { return RelativePoseError(*truth, estimate); }, figures);
  AddError(
      "rpe_30_frames", truth, [&] { return RelativePoseError(*truth, estimate, kThirtyFrames); },
      figures);
}

void AddTimes(const apps::SlamRun& run, Scores* figures) {
  Scores& f = *figures;
  f["tracking_ms"] = run.times.tracking.median;
  f["tracking_p99_ms"] = run.times.tracking.p99;
  f["frame_ms"] = run.times.frame.median;
  f["frame_mean_ms"] = run.times.frame.mean;
  f["frame_p95_ms"] = run.times.frame.p95;
  f["frame_p99_ms"] = run.times.frame.p99;
  f["frame_worst_ms"] = run.times.frame.worst;
  f["processor_ms"] = apps::ProcessorMsPerFrame(run);
  const auto frames = static_cast<double>(std::max<std::size_t>(run.frames, 1));
  f["decoding_processor_ms"] = 1e3 * run.processor.decoding / frames;
  f["mapping_ms"] = run.times.mapping.median;
  f["seconds"] = run.seconds;
  f["peak_memory_mib"] = apps::PeakMemoryMib();
}

void AddLive(const apps::SlamRun& run, const Trajectory* truth, Scores* figures) {
  Scores& f = *figures;
  f["dropped_frames"] = static_cast<double>(run.dropped);
  f["delay_ms"] = run.times.delay.median;
  f["delay_p99_ms"] = run.times.delay.p99;
  AddError(
      "causal_ape", truth, [&] { return AbsolutePoseError(*truth, run.largest.causal); }, figures);
}

void AddUnits(const OrbUnit& orb, Scores* figures) {
  Scores& f = *figures;
  f["orb_ms"] = orb.WallMs();
  f["orb_processor_ms"] = orb.ProcessorMs();
  f["tracking_over_orb"] = f["tracking_ms"] / f["orb_ms"];
  f["processor_over_orb"] = f["processor_ms"] / f["orb_processor_ms"];
}

void AddMapSizes(const DenseMap& map, Scores* figures) {
  const CacheFolder scratch("", "highwall_bench_tum");
  const auto ply = scratch.path() / "cloud.ply", bt = scratch.path() / "map.bt";
  WritePly(ply, map.cloud);
  map.octree.WriteBinary(bt);
  (*figures)["cloud_mb"] = static_cast<double>(std::filesystem::file_size(ply)) / 1e6;
  (*figures)["octree_mb"] = static_cast<double>(std::filesystem::file_size(bt)) / 1e6;
}

void AddCounts(const apps::SlamRun& run, Scores* figures) {
  Scores& f = *figures;
  f["coverage"] = apps::Coverage(run);
  f["frames"] = static_cast<double>(run.frames + run.skipped + run.dropped);
  f["lost_frames"] = static_cast<double>(run.lost.size());
  f["submaps"] = static_cast<double>(run.others.size() + (run.largest.trajectory.empty() ? 0 : 1));
  f["loops_closed"] = static_cast<double>(run.loops.closed);
  f["keyframes"] = static_cast<double>(run.keyframes.size());
  f["points"] = static_cast<double>(run.points);
  f["lines"] = static_cast<double>(run.lines);
}

}  // namespace

std::optional<RunRecord> RunOnce(const std::filesystem::path& dataset, const RunKey& key,
                                 const std::function<bool()>& stop) {
  if (key.synchronous) cv::setNumThreads(1);  // as `highwall slam --deterministic`
  const OwnSetting setting(
      key.setting.switches, dataset,
      {.synchronous = key.synchronous, .map = key.setting.map, .live_rate = key.live_rate});
  OrbUnit orb(setting.images());
  orb.Measure(stop);
  ForgetPeakMemory();
  apps::SlamRun run = setting.RunWhole(0, NameOf(key).string(), stop);
  if (run.left > 0) return std::nullopt;
  RunRecord record{key, {}, run.loss_reasons, {}};
  AddTimes(run, &record.figures);
  orb.Measure({});  // the run is complete
  AddUnits(orb, &record.figures);
  AddCounts(run, &record.figures);
  if (run.largest.dense) AddMapSizes(*run.largest.dense, &record.figures);
  if (setting.is_live()) AddLive(run, setting.images().groundtruth(), &record.figures);
  apps::SubmapRun& map = run.largest;
  record.trajectory = std::move(map.adjusted.empty() ? map.trajectory : map.adjusted);
  AddErrors(setting.images().groundtruth(), record.trajectory, &record.figures);
  return record;
}

}  // namespace highwall::bench
