#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/local/camera_calibration.h>
#include <highwall/frontend/local/depth_scale.h>
#include <highwall/frontend/system/slam_system.h>
#include <highwall/mapping/dense_mapper.h>

#include "gps_input.h"
#include "sparse_map_picture.h"

namespace highwall::apps {

// The IMU of a recording: readings in the order of their stamps.
struct ImuFeed {
  ImuCalibration calibration;
  std::vector<ImuSample> samples;
};

struct SlamRunOptions {
  SlamOptions slam;
  std::optional<GpsFeed> gps;  // empty: none
  std::optional<ImuFeed> imu;  // empty: RGB-D alone
  bool dense = true;           // build cloud, octree and grid
  DenseMapOptions map;
  std::size_t begin = 0, end = SIZE_MAX;  // frames of the dataset
  std::size_t prefetch = 4;               // frames decoded ahead
  bool live = false;                      // at the pace of the stamps, late frames dropped
  std::filesystem::path load_map;         // to go on in; empty: none
  std::filesystem::path save_map;         // to write in the end; empty: none
  std::filesystem::path keep_map;         // likewise: the one in the folder of the run
  bool adjust_all = false;                // all keyframes and landmarks together, in the end
  // The camera is calibrated by the map that results, where given.
  std::optional<CameraCalibrationOptions> calibrate;
  // Asked before each frame: true ends the run there, as if the recording ended; empty: never.
  std::function<bool()> stop{};
};

// Mean, median, 95th and 99th percentile of samples [ms]; zeros for none.
struct Milliseconds {
  double mean = 0.0, median = 0.0, p95 = 0.0, p99 = 0.0;
  std::size_t count = 0;
};
Milliseconds Summarize(std::vector<double> samples);

struct StageTimes {
  Milliseconds points, lines;  // extraction, side by side
  Milliseconds features;       // both
  Milliseconds pose;           // matching and pose estimation
  Milliseconds tracking;       // features + pose: what a frame costs
  Milliseconds mapping;        // local mapping, per keyframe
  Milliseconds frame;          // all of SlamSystem::Track, keyframes and loops included
  Milliseconds dense;          // depth filters, cloud and octree of a keyframe
};

// Between two images that the IMU ties.
struct WeighedInterval {
  Stamp end = 0;                     // of the image
  double weight = 0.0;               // of its IMU factor
  std::optional<double> innovation;  // squared, per degree of freedom, where it was formed
};

// What was known of the IMU after an image.
struct ImuState {
  Stamp stamp = 0;
  ImuBias bias = ImuBias::Zero();  // [rad/s, m/s^2]
  double time_offset = 0.0;        // [s]
};

// How the IMU fared over a run.
struct InertialSummary {
  InertialReport last;                     // of the last frame
  std::size_t given_up = 0;                // frames for which it was
  std::string given_up_because;            // the last time
  std::optional<Stamp> initialized;        // frame at which gravity and biases were known first
  std::size_t dead_reckoned = 0;           // frames whose pose is that of the IMU alone
  std::size_t restarts = 0;                // for want of readings
  std::size_t contradicted = 0;            // intervals whose readings the images contradict
  std::size_t saturated = 0;               // intervals with readings at the end of a sensor's range
  double mean_weight = 0.0;                // of the IMU factors
  double reduced_share = 0.0;              // of them, with a weight below 1
  double mean_innovation = 0.0;            // squared, per degree of freedom: 1 where consistent
  Milliseconds tight;                      // updates of the window of landmarks
  std::size_t refused_updates = 0;         // of those
  std::vector<WeighedInterval> intervals;  // by images, ascending
  std::vector<ImuState> states;            // a few a second, ascending
  // In the end; empty where the motion does not tell it to 2 %.
  std::optional<DepthScale> depth_scale;
};

// What a frame has come to, as it was told when it had been tracked.
struct TrackedFrame {
  Stamp stamp = 0;
  int points = 0, lines = 0;  // matched with the map
  double milliseconds = 0.0;  // StageTimes::frame
};

// What loops came to in a run. Those that joined submaps are among the closed.
struct LoopCounts {
  std::size_t closed = 0, refused = 0, merges = 0;
  std::size_t fused_points = 0, fused_lines = 0;
  double worst_seconds = 0.0;  // from the detection of a loop to the adjusted map
};

// What adjustments came to in a run, those after loops included.
struct AdjustmentCounts {
  std::size_t all = 0;
  std::size_t refused = 0;         // they would have forgotten too much
  std::size_t failed = 0;          // for other reasons
  std::size_t unmoved = 0;         // usable, and no step was taken
  std::size_t rejected_steps = 0;  // that led up, or where an observation cannot be
};

// Frames with poses in one world.
struct SubmapRun {
  SubmapId submap = kNoId;
  std::size_t keyframes = 0;
  Trajectory causal;      // each pose as it was when its frame had been tracked, if in this world
  Trajectory trajectory;  // after the loops and local adjustments of the whole run
  Trajectory adjusted;    // after the final adjustment as well, where asked for
  std::optional<DenseMap> dense = std::nullopt;  // in this world
};

// A loop that was closed or refused.
struct LoopEvent {
  LoopEdge edge;
  bool accepted = false, merged = false;
  std::string message;
};

struct SlamRun {
  SubmapRun largest;              // the world in which most frames have a pose
  std::vector<SubmapRun> others;  // that were not joined with it, larger ones first
  Trajectory keyframes;           // of the largest, live
  SparseMap sparse;               // in the end
  LoopCounts loops;
  AdjustmentCounts adjustments;
  std::vector<LoopEvent> loop_events;
  std::map<KeyFrameId, Stamp> keyframe_stamps;  // of all that were made, culled ones included
  std::size_t frames = 0;                       // fed
  std::size_t skipped = 0;                      // unusable images
  std::size_t without_depth = 0;                // colour images that have no depth image in time
  std::size_t dropped = 0;                      // that came too fast, where live
  // Frames without a pose in any submap, those before the map began included.
  std::vector<Stamp> lost;
  // Why each, by ToString(LossReason); "dropped": it was in a submap that was dropped.
  std::vector<std::string> lost_because;
  std::map<std::string, std::size_t> loss_reasons;  // how many of each
  std::size_t repeated = 0;                 // colour images that were the one before once more
  int refined = 0;                          // frames whose pose was found once more
  FrameTimingEstimate timing;               // in the end
  DepthPattern depth_pattern;               // likewise
  NoiseEstimate noise;                      // in the end
  int levels = 0;                           // of the pyramid of its points
  std::optional<InertialSummary> inertial;  // with an IMU
  std::optional<GpsSummary> gps;            // with a GPS
  std::optional<CameraCalibration> camera;  // of the largest world, where asked for
  std::size_t relocalizations = 0;
  std::size_t open_frames = 0;        // tracked, whose images leave a direction of the pose open
  std::size_t points = 0, lines = 0;  // landmarks in the end
  std::size_t keyframes_made = 0;     // culled ones included
  double matched_points = 0.0, matched_lines = 0.0;  // mean per tracked frame
  std::vector<TrackedFrame> per_frame;               // lost ones included
  StageTimes times;
  double seconds = 0.0;  // of the whole run, dense map included
  // What could not be done in the end, and why; it stopped nothing else.
  std::vector<std::string> failures;
  std::size_t left = 0;  // frames that were not looked at: SlamRunOptions::stop ended the run
};

// Share of the frames of the recording that have a pose in any submap: those that could not be
// read, and those that came too fast, have none.
double Coverage(const SlamRun& run);
// The same of its colour images, of which those without depth are no frames.
double ColourCoverage(const SlamRun& run);
std::size_t CountColourImages(const SlamRun& run);

// For those who can do without nothing: throws std::runtime_error where there are failures.
void RequireWhole(const SlamRun& run);

// Called after each frame with the frame, its image and how many lie behind and ahead.
using FrameCallback = std::function<void(const FrameResult& result, const RgbdImage& image,
                                         std::size_t done, std::size_t total)>;

// Called after the last frame, where there is a pose, when the causal and the final trajectory and
// the keyframes are known; all that takes long or may fail comes after it.
using TrackedCallback = std::function<void(const SlamRun& run)>;

// Feeds a dataset to SlamSystem, and the keyframes to the dense map; saves the map. Throws IoError
// for a map that cannot be loaded or is of another camera. What fails after tracking, and the dense
// map at any time, is among SlamRun::failures.
SlamRun RunSlam(const Dataset& dataset, const RgbdSensor& sensor, const SlamRunOptions& options,
                const FrameCallback& on_frame = {}, const TrackedCallback& on_tracked = {});

// The most memory that the process has held so far [MiB].
double PeakMemoryMib();

}  // namespace highwall::apps
