#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/memory_share.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/calibration/camera_calibration.h>
#include <highwall/frontend/calibration/depth_scale.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/image_source.h>
#include <highwall/frontend/system/slam_system.h>
#include <highwall/internal/run_profile.h>
#include <highwall/mapping/dense_mapper.h>

#include "plots/sparse_map_picture.h"
#include "run/gps_input.h"
#include "run/late_colour.h"

namespace highwall::apps {

class RunObserver;

// IMU data of a recording; readings in ascending order of their stamps.
struct ImuFeed {
  ImuCalibration calibration;
  std::vector<ImuSample> samples;
};

struct SlamRunOptions {
  SlamOptions slam;
  std::optional<GpsFeed> gps;  // empty: none
  std::optional<ImuFeed> imu;  // empty: RGB-D alone
  SensorVerdict before;        // what the recording shows before the first frame
  bool dense = true;           // build cloud, octree and grid
  DenseMapOptions map;
  std::size_t begin = 0, end = SIZE_MAX;  // frames of the dataset
  std::size_t prefetch = 2;               // frames decoded ahead
  bool live = false;                      // at the pace of the stamps; late frames are dropped
  double live_rate = 1.0;                 // > 0: of that pace
  std::filesystem::path load_map;         // initial map; empty: none
  std::filesystem::path save_map;         // output file; empty: none
  std::filesystem::path keep_map;         // likewise, in the folder of the run
  std::filesystem::path trace;            // output file of the stages of each thread; empty: none
  bool adjust_all = false;                // final adjustment of all keyframes and landmarks
  // If given, the camera is calibrated from the final map.
  std::optional<CameraCalibrationOptions> calibrate;
  RunObserver* observer = nullptr;  // must outlive the run; null: none
  // Called before each frame: true ends the run there, as if the recording ended; empty: never.
  std::function<bool()> stop{};
};

// Mean, median, 95th and 99th percentile and maximum of samples [ms]; zeros if there are none.
struct TimingStatistics {
  double mean = 0.0, median = 0.0, p95 = 0.0, p99 = 0.0, worst = 0.0;
  std::size_t count = 0;
};
TimingStatistics Summarize(std::vector<double> samples);

struct StageTimes {
  TimingStatistics points, lines;  // extraction, in parallel
  TimingStatistics features;       // both
  TimingStatistics pose;           // matching and pose estimation
  TimingStatistics tracking;       // features + pose: total per frame
  TimingStatistics mapping;        // local mapping, per keyframe
  TimingStatistics frame;          // all of SlamSystem::Track, with keyframes, waits and callbacks
  TimingStatistics dense;          // depth filters, cloud and octree of a keyframe
  TimingStatistics delay;          // from the arrival of a frame to its result, in live mode
};

// Interval between two images that an IMU factor connects.
struct WeighedInterval {
  Stamp end = 0;                     // of the image
  double weight = 0.0;               // of its IMU factor
  std::optional<double> innovation;  // squared, per degree of freedom, if available
};

// IMU state after an image.
struct ImuState {
  Stamp stamp = 0;
  ImuBias bias = ImuBias::Zero();  // [rad/s, m/s^2]
  double time_offset = 0.0;        // [s]
};

// IMU statistics of a run.
struct InertialSummary {
  InertialReport last;                     // of the last frame
  std::size_t given_up = 0;                // frames with the IMU given up
  std::string given_up_because;            // latest reason
  std::optional<Stamp> initialized;        // first frame with known gravity and biases
  std::size_t dead_reckoned = 0;           // frames with a pose predicted by the IMU alone
  std::size_t restarts = 0;                // due to missing readings
  std::size_t contradicted = 0;            // intervals with readings inconsistent with the images
  std::size_t saturated = 0;               // intervals with readings at the sensor's limit
  double mean_weight = 0.0;                // of the IMU factors
  double reduced_share = 0.0;              // of the IMU factors, those with a weight below 1
  double mean_innovation = 0.0;            // squared, per degree of freedom: 1 where consistent
  TimingStatistics tight;                  // updates of the tightly coupled smoother
  std::size_t refused_updates = 0;         // rejected ones among those
  std::vector<WeighedInterval> intervals;  // by images, ascending
  std::vector<ImuState> states;            // a few a second, ascending
  // Final estimate; empty if the motion does not determine it to 2 %.
  std::optional<DepthScale> depth_scale;
  std::optional<SensorFinding> scale_finding;  // by that estimate, however accurate it is
};

// Tracking result of a frame, as reported immediately after tracking.
struct TrackedFrame {
  Stamp stamp = 0;
  int points = 0, lines = 0;  // matched with the map
  double milliseconds = 0.0;  // StageTimes::frame
};

// Loop statistics of a run. Loops that merged submaps count as closed.
struct LoopCounts {
  std::size_t closed = 0, refused = 0, merges = 0;
  std::size_t fused_points = 0, fused_lines = 0;
  double worst_seconds = 0.0;  // from the detection of a loop to the adjusted map
};

// Bundle adjustment statistics of a run, including adjustments after loops.
struct AdjustmentCounts {
  std::size_t all = 0;
  std::size_t refused = 0;         // would have discarded too many observations
  std::size_t failed = 0;          // for other reasons
  std::size_t unmoved = 0;         // usable, but no step was taken
  std::size_t rejected_steps = 0;  // that increased the cost or made an observation invalid
};

// Frames with poses in one world.
struct SubmapRun {
  SubmapId submap = kNoId;
  std::size_t keyframes = 0;
  Trajectory causal;      // pose of each frame when it was tracked, if in this world
  Trajectory trajectory;  // after all loops and local adjustments of the run
  std::vector<FrameVelocity> velocities;         // of the frames of `trajectory`
  Trajectory adjusted;                           // also after the final adjustment, if enabled
  std::optional<DenseMap> dense = std::nullopt;  // in this world
};

// A closed or rejected loop.
struct LoopEvent {
  LoopEdge edge;
  bool accepted = false, merged = false;
  std::string message;
};

// The memory of the process after the last frame, with the complete map and no work in progress.
struct MemoryAtRest {
  double mib = 0.0;               // 0 where the system does not state it
  double peak_mib = 0.0;          // until then; writing the results comes after it
  std::vector<MemoryShare> held;  // by the system and by its dense map
};

struct SlamRun {
  // The world in which most frames have a pose: of those with the loaded map, if there are any.
  SubmapRun largest;
  std::vector<SubmapRun> others;  // not merged with it, larger ones first
  bool map_met = true;            // false: a map was loaded, and no frame has a pose in its world
  Trajectory keyframes;           // active keyframes of the largest
  SparseMap sparse;               // final
  LoopCounts loops;
  AdjustmentCounts adjustments;
  std::vector<LoopEvent> loop_events;
  std::map<KeyFrameId, Stamp> keyframe_stamps;  // of all created keyframes, including culled ones
  std::size_t frames = 0;                       // fed
  std::size_t skipped = 0;                      // unusable images
  std::size_t without_depth = 0;                // colour images without a matching depth image
  std::size_t dropped = 0;                      // late frames in live mode
  PostponedWork postponed;                      // because frames were late
  // Frames without a pose in any submap, including those before the map was initialized.
  std::vector<Stamp> lost;
  // Reason for each, by ToString(LossReason); "dropped": its submap was dropped.
  std::vector<std::string> lost_because;
  std::map<std::string, std::size_t> loss_reasons;  // number of frames per reason
  std::size_t repeated = 0;                         // colour images identical to the previous one
  LateColour late_colour;
  int refined = 0;                          // frames with a pose refined afterwards
  SensorEstimate sensor;                    // final
  SensorVerdict verdict;                    // with what was found before
  int levels = 0;                           // of the pyramid of its points
  std::optional<InertialSummary> inertial;  // with an IMU
  std::optional<GpsSummary> gps;            // with a GPS
  std::optional<CameraCalibration> camera;  // of the largest world, if requested
  std::size_t relocalizations = 0;
  std::size_t open_frames = 0;        // tracked, with an unobservable direction of the pose
  std::size_t points = 0, lines = 0;  // final number of landmarks
  std::size_t keyframes_made = 0;     // including culled ones
  double matched_points = 0.0, matched_lines = 0.0;  // mean per tracked frame
  std::vector<TrackedFrame> per_frame;               // including lost ones
  StageTimes times;
  double seconds = 0.0;                    // of the whole run, including the dense map
  RunProfile::ProcessorSeconds processor;  // likewise
  MemoryAtRest memory;
  // Steps that failed at the end, with the reasons; other steps were not affected.
  std::vector<std::string> failures;
  std::size_t left = 0;  // unprocessed frames after SlamRunOptions::stop ended the run
  bool is_of_camera = false;
};

double Mib(const MemoryShare& share);

// Returns the share of frames of the recording with a pose in any submap; unreadable and dropped
// frames count as frames without a pose.
double Coverage(const SlamRun& run);
// Returns the same share of its colour images, including those without depth, which are not frames.
double ColourCoverage(const SlamRun& run);
std::size_t CountColourImages(const SlamRun& run);

// Returns the processor time of a frame [ms]: of all threads over the whole run, the dense map
// included and the decoding of images not, divided by the frames; 0 if there are none.
double ProcessorMsPerFrame(const SlamRun& run);

// Throws std::runtime_error if there are failures, for callers that need a complete result.
void RequireWhole(const SlamRun& run);

// Called for each finding about the sensors as soon as it is significant.
using FindingCallback = std::function<void(const SensorFinding& finding)>;

// Called after each frame with the frame, its image, the number of processed frames, and the total.
using FrameCallback = std::function<void(const FrameResult& result, const RgbdImage& image,
                                         std::size_t done, std::size_t total)>;

// Called after the last frame if there is a pose, once the causal and final trajectories and the
// keyframes are known; all steps that take long or may fail come later.
using TrackedCallback = std::function<void(const SlamRun& run)>;

// What RunSlam() calls; any may be empty.
struct RunCallbacks {
  FrameCallback on_frame = {};
  TrackedCallback on_tracked = {};
  FindingCallback on_finding = {};
};

// Runs SlamSystem on a dataset, builds the dense map from the keyframes, and saves the map. Throws
// IoError for a map that cannot be loaded or belongs to another camera. Failures after tracking,
// and of the dense map at any time, are recorded in SlamRun::failures.
SlamRun RunSlam(const Dataset& dataset, const RgbdSensor& sensor, const SlamRunOptions& options,
                const RunCallbacks& callbacks = {});
// The same for a camera until it ends; SlamRunOptions::stop is not asked (ImageSource::Stop). With
// SlamRunOptions::imu its readings are those of the camera. The total that callbacks receive is the
// number of frames so far. A camera that fails after its first image is one of the failures.
SlamRun RunSlam(ImageSource& camera, const RgbdSensor& sensor, const SlamRunOptions& options,
                const RunCallbacks& callbacks = {});

}  // namespace highwall::apps
