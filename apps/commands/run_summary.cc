#include "commands/run_summary.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/core.h>

#include "run/depth_scale_check.h"
#include "run/loss_advice.h"
#include "run/run_files.h"
#include "run/run_output.h"

namespace highwall::apps {
namespace {

void WarnOfImu(const std::string& command, const SlamRun& run) {
  if (!run.inertial) return;
  if (run.inertial->initialized) {
    if (run.inertial->given_up == 0) return;
    fmt::print(stderr, "highwall {}: warning: the IMU was not used for {} frames: {}\n", command,
               run.inertial->given_up, run.inertial->given_up_because);
    return;
  }
  fmt::print(
      stderr, "highwall {}: warning: the IMU was not used: {}\n", command,
      run.inertial->last.reason.empty() ? "it was never initialized" : run.inertial->last.reason);
}

void WarnOfGps(const std::string& command, const SlamRun& run) {
  if (!run.gps || run.gps->T_GW) return;
  fmt::print(stderr,
             "highwall {}: warning: the GPS was not used: {} of its {} fixes belong to tracked "
             "frames, too few or too close together to locate the map in the frame of the GPS\n",
             command, run.gps->used, run.gps->fixes);
}

// Whether the scale of the depth is known and no finding contradicts it, or states it already.
bool IsDepthScaleNews(const SlamRun& run) {
  const auto is_of_scale = [](const SensorFinding& finding) {
    return finding.fault == SensorFault::kDepthScale || LeavesNoScale(finding);
  };
  return run.inertial && run.inertial->depth_scale && IsScaleMeaningful(run.inertial->last) &&
         std::ranges::none_of(run.verdict.findings, is_of_scale);
}

// Significant, and larger than the calibration error of most depth cameras.
void WarnOfDepth(const std::string& command, const SlamRun& run, double depth_factor) {
  if (!IsDepthScaleNews(run)) return;
  const DepthScale& depth = *run.inertial->depth_scale;
  const double off = std::abs(depth.scale - 1.0);
  if (off <= 0.01 || off <= 3.0 * depth.sigma) return;
  fmt::print(stderr,
             "highwall {}: warning: depth reads {:.1f} % too {}: set depth_factor: {:.5g} in "
             "calibration.yaml\n",
             command, 100.0 * std::abs(1.0 / depth.scale - 1.0),
             depth.scale < 1.0 ? "long" : "short", depth_factor / depth.scale);
}

void PrintInertial(const InertialSummary& inertial) {
  if (!inertial.last.estimate) return;
  const InertialReport& last = inertial.last;
  fmt::print(
      "imu         t_d {:.2f} +- {:.2f} ms, gravity +- {:.2f} deg, {} frames by the IMU alone\n",
      last.time_offset * 1e3, last.time_offset_sigma * 1e3, last.gravity_sigma * 180.0 / M_PI,
      inertial.dead_reckoned);
  if (inertial.contradicted > 0 || inertial.saturated > 0) {
    fmt::print("            images contradict {} intervals, {} intervals saturate the sensor\n",
               inertial.contradicted, inertial.saturated);
  }
  if (const auto& mount = last.extrinsics) {
    const Eigen::Vector3d p = 1e3 * mount->T_BC.p(), s = 1e3 * mount->lever_arm_sigma;
    fmt::print(
        "camera at   {:.1f} {:.1f} {:.1f} mm in the IMU's frame, +- {:.1f} {:.1f} {:.1f} mm\n",
        p.x(), p.y(), p.z(), s.x(), s.y(), s.z());
  }
  if (const auto& depth = inertial.depth_scale) {
    fmt::print("depth       scale {:.4f} +- {:.4f} (true depth = scale x measured)\n", depth->scale,
               depth->sigma);
  }
}

void PrintMapping(const SlamRun& run) {
  fmt::print("map         {} keyframes, {} points, {} lines\n", run.keyframes.size(), run.points,
             run.lines);
  if (!run.sensor.depth_pattern.IsZero()) {
    fmt::print("depth       correction of the distortion over the image: {:.2f} % at 1 m (RMS)\n",
               100.0 * run.sensor.depth_pattern.Rms());
  }
  if (run.inertial) PrintInertial(*run.inertial);
  if (run.gps && run.gps->T_GW) {
    fmt::print("gps         {} of {} fixes used, {:.2f} m RMS from the trajectory\n", run.gps->used,
               run.gps->fixes, run.gps->rms);
  }
  fmt::print("loops       {} closed, {} rejected\n", run.loops.closed, run.loops.refused);
  const AdjustmentCounts& adjusted = run.adjustments;
  fmt::print(
      "adjustments {} of the map; {} rejected, {} failed, {} without effect; {} steps rejected\n",
      adjusted.all, adjusted.refused, adjusted.failed, adjusted.unmoved, adjusted.rejected_steps);
  fmt::print("mapping     {:.1f} ms a keyframe (median)\n", run.times.mapping.median);
}

void PrintLive(const SlamRun& run) {
  const TimingStatistics& delay = run.times.delay;
  fmt::print(
      "live        {} frames dropped; poses {:.1f} ms after their images (median), "
      "99 % within {:.1f}\n",
      run.dropped, delay.median, delay.p99);
  const PostponedWork& postponed = run.postponed;
  if (postponed.keyframes + postponed.loop_searches == 0) return;
  fmt::print("postponed   keyframes in {} frames; loops were not searched for {} keyframes\n",
             postponed.keyframes, postponed.loop_searches);
}

void PrintSubmaps(const SlamRun& run) {
  if (!run.map_met) {
    fmt::print(
        "map         no frame was recognized in the loaded map; {} is in a world of its own\n",
        NameOfSubmap(kTrajectoryFile, FirstPlace(run)));
  }
  if (run.loops.merges > 0) fmt::print("merges      {} of submaps\n", run.loops.merges);
  if (run.others.empty()) return;
  const std::size_t first = FirstPlace(run);
  std::string parts = fmt::format("{} frames in {}", run.largest.trajectory.size(),
                                  NameOfSubmap(kTrajectoryFile, first));
  for (std::size_t i = 0; i < run.others.size(); ++i) {
    parts += fmt::format(", {} in {}", run.others[i].trajectory.size(),
                         NameOfSubmap(kTrajectoryFile, first + i + 1));
  }
  fmt::print("submaps     {} separate worlds: {}\n", run.others.size() + 1, parts);
}

// Prints how to measure the accuracy, or how to judge it without a ground truth.
void PrintAccuracy(const SlamRun& run, const SlamArguments& arguments, bool has_truth) {
  const auto truth = std::filesystem::path(arguments.dataset) / "groundtruth.txt";
  if (has_truth && std::filesystem::exists(truth)) {
    const auto trajectory =
        std::filesystem::path(arguments.out) / NameOfSubmap(kTrajectoryFile, FirstPlace(run));
    fmt::print("accuracy    highwall eval ape {} {}\n", truth.string(), trajectory.string());
  } else if (!has_truth) {
    fmt::print(
        "accuracy    unknown: the recording has no ground truth. Judge it by closed loops, by "
        "double walls in the cloud, and by a second recording (highwall map compare)\n");
  }
}

void PrintMemory(const MemoryAtRest& memory) {
  double others = memory.mib;
  const auto print = [](double mib, const std::string& holder) {
    fmt::print("            {:6.1f} MiB {}\n", mib, holder);
  };
  fmt::print("            {:.0f} MiB at its peak before the results were written\n",
             memory.peak_mib);
  fmt::print("at rest     {:.0f} MiB, of these\n", memory.mib);
  for (const MemoryShare& share : memory.held) {
    print(Mib(share), share.holder);
    others -= Mib(share);
  }
  print(std::max(0.0, others), "the program, its libraries and what they keep");
}

}  // namespace

void WarnOfSensors(const std::string& command, const SlamRun& run, double depth_factor) {
  WarnOfImu(command, run);
  WarnOfDepth(command, run, depth_factor);
  WarnOfGps(command, run);
}

void PrintSummary(const SlamRun& run, const SlamArguments& arguments, bool has_truth,
                  double memory) {
  fmt::print("frames      {} ({} lost, {} skipped, {} relocalizations)\n", run.frames,
             run.lost.size(), run.skipped, run.relocalizations);
  fmt::print("coverage    {:.2f} % of the {} colour images of the recording have a pose{}\n",
             100.0 * ColourCoverage(run), CountColourImages(run),
             run.without_depth == 0
                 ? ""
                 : fmt::format("; {} have no depth image in time", run.without_depth));
  if (const std::string advice = LossAdvice(run.loss_reasons, run.lost.size()); !advice.empty()) {
    fmt::print("lost        {}\n", advice);
  }
  if (run.repeated > 0) fmt::print("repeated    {} colour images\n", run.repeated);
  PrintSubmaps(run);
  if (run.open_frames > 0) {
    fmt::print("degenerate  {} frames leave a direction of the pose unobservable\n",
               run.open_frames);
  }
  if (arguments.live) PrintLive(run);
  if (arguments.localize) {
    fmt::print("map         {} points, {} lines, not changed\n", run.points, run.lines);
  } else {
    PrintMapping(run);
  }
  fmt::print("tracking    {:.1f} ms a frame (median), 95 % within {:.1f} ms\n",
             run.times.tracking.median, run.times.tracking.p95);
  const TimingStatistics& frame = run.times.frame;
  fmt::print(
      "frame       {:.1f} ms (median), 95 % within {:.1f}, 99 % within {:.1f}, all within {:.1f}\n",
      frame.median, frame.p95, frame.p99, frame.worst);
  fmt::print("processor   {:.1f} s, {:.1f} ms a frame without decoding ({:.1f} s)\n",
             run.processor.process, ProcessorMsPerFrame(run), run.processor.decoding);
  if (const auto& dense = run.largest.dense) {
    fmt::print("dense map   {} points, {} octree nodes at {} m\n", dense->cloud.size(),
               dense->octree.NodeCount(), dense->octree.options().resolution);
  }
  fmt::print("memory      {:.0f} MiB at its peak\n", memory);
  if (arguments.memory_report) PrintMemory(run.memory);
  PrintAccuracy(run, arguments, has_truth);
  fmt::print("results in  {}\n", arguments.out);
  fmt::print("verdict     {}\n", run.verdict.Summary());
}

}  // namespace highwall::apps
