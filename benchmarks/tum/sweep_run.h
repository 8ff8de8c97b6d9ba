#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include <highwall/core/trajectory_error.h>

#include "sweep_record.h"

namespace highwall::bench {

// All pairs of frames with a distance of 30: a short sequence has only a few consecutive ones.
inline constexpr RelativePoseErrorOptions kThirtyFrames{.delta = 30.0, .all_pairs = true};

// Runs a dataset that `highwall slam` accepts. Throws IoError for an unusable one, and the errors
// of the run. stop: called between its frames; the result is empty if it ended the run.
//
// Figures, each with its unit in its name:
//   ape_, rpe_1_frame_, rpe_30_frames_
//                    {max,mean,median,min,rmse,std}_m and sse_m2, over all frames of the largest
//                    map, rigid alignment without scale; rmse is 0 without ground truth, and -1 if
//                    it cannot be computed
//   coverage, frames, lost_frames, submaps, loops_closed, keyframes, points, lines
//   tracking_ms, tracking_p99_ms    features, matching and pose of a frame
//   frame_ms, frame_mean_ms, frame_p95_ms, frame_p99_ms, frame_worst_ms
//                    wall time of a frame, with keyframes, loops and waits for other threads
//   processor_ms     processor time of all threads, per frame, without the decoding of images
//   decoding_processor_ms           that of decoding, likewise
//   mapping_ms, seconds, peak_memory_mib
//   orb_ms, orb_processor_ms        cv::ORB::detectAndCompute (1000 features, 8 levels) on images
//   of
//                    the sequence, OpenCV on one thread: median over the images, before and after
//                    the run; wall time, and processor time by the clock of that thread
//   tracking_over_orb, processor_over_orb   in these units
//   cloud_mb, octree_mb             of cloud.ply and map.bt, if there is a dense map
//   dropped_frames, delay_ms, delay_p99_ms, causal_ape_*    in live mode: frames that came too
//   fast,
//                    the time from the arrival of a frame to its pose, and the errors of the poses
//                    as they were at that time
std::optional<RunRecord> RunOnce(const std::filesystem::path& dataset, const RunKey& key,
                                 const std::function<bool()>& stop = {});

}  // namespace highwall::bench
