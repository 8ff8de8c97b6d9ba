#include "slam_run.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <numeric>

#include <highwall/frontend/frame_reader.h>

namespace highwall::apps {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// The samples of StageTimes, frame by frame.
struct StageSamples {
  std::vector<double> points, lines, features, pose, tracking, mapping, dense;

  void Add(const FrameTimes& times, bool keyframe) {
    points.push_back(times.points);
    lines.push_back(times.lines);
    features.push_back(times.features);
    pose.push_back(times.tracking);
    tracking.push_back(times.features + times.tracking);
    if (keyframe) mapping.push_back(times.mapping);
  }

  StageTimes Summary() const {
    return {Summarize(points),   Summarize(lines),   Summarize(features), Summarize(pose),
            Summarize(tracking), Summarize(mapping), Summarize(dense)};
  }
};

}  // namespace

Milliseconds Summarize(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double quantile) {
    return samples[static_cast<std::size_t>(quantile * static_cast<double>(samples.size() - 1))];
  };
  return {
      std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size()),
      at(0.5), at(0.95), samples.size()};
}

SlamRun RunSlam(const Dataset& dataset, const RgbdSensor& sensor, const SlamRunOptions& options,
                const FrameCallback& on_frame) {
  const auto start = Clock::now();
  SlamSystem slam(sensor, options.slam);
  DenseMapper mapper(options.map, sensor.camera);
  FrameReader reader(dataset,
                     {.begin = options.begin, .end = options.end, .prefetch = options.prefetch});

  SlamRun run;
  StageSamples samples;
  while (const std::optional<RgbdImage> image = reader.Next()) {
    const FrameResult result = slam.Track(*image);
    ++run.frames;
    samples.Add(result.times, result.mapping.has_value());
    if (result.state == TrackingState::kTracking) {
      run.matched_points += result.matched_points;
      run.matched_lines += result.matched_lines;
    } else {
      run.lost.push_back(result.stamp);
    }
    if (result.relocalized) ++run.relocalizations;
    if (result.mapping) {
      ++run.keyframes_made;
      if (options.dense) {
        const auto dense_start = Clock::now();
        const KeyFrameId id = result.mapping->keyframe;
        if (const auto* keyframe = slam.map().keyframe(id)) {
          mapper.AddKeyframe(id, image->depth, image->bgr, keyframe->T_WC);
        }
        for (const KeyFrameId culled : result.mapping->culled_keyframes) {
          mapper.RemoveKeyframe(culled);
        }
        samples.dense.push_back(MillisecondsSince(dense_start));
      }
    }
    if (on_frame) on_frame(result, *image, reader.position(), reader.count());
  }
  const std::size_t tracked = run.frames - run.lost.size();
  if (tracked > 0) {
    run.matched_points /= static_cast<double>(tracked);
    run.matched_lines /= static_cast<double>(tracked);
  }
  run.skipped = reader.count() - run.frames;
  run.trajectory = slam.trajectory();
  run.keyframes = slam.keyframe_trajectory();
  run.points = slam.map().num_points();
  run.lines = slam.map().num_lines();
  if (options.dense) {
    for (const KeyFrameId id : slam.map().keyframe_ids()) {
      mapper.SetPose(id, slam.map().keyframe(id)->T_WC);
    }
    run.dense = mapper.Finish();
  }
  run.times = samples.Summary();
  run.seconds = MillisecondsSince(start) * 1e-3;
  return run;
}

double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace highwall::apps
