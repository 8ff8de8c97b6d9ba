#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include <highwall/core/trajectory_error.h>

#include "sweep_record.h"

namespace highwall::bench {

// Every pair of frames that are 30 apart: a short sequence has but a few that follow each other.
inline constexpr RelativePoseErrorOptions kThirtyFrames{.delta = 30.0, .all_pairs = true};

// Runs a dataset that `highwall slam` takes. Throws IoError for one that cannot be used, and what
// the run throws. stop: asked between its frames; empty where it has ended the run.
//
// Figures, each with its unit in its name:
//   ape_, rpe_1_frame_, rpe_30_frames_   {max,mean,median,min,rmse,std}_m and sse_m2, over all
//   frames
//                                        of the largest map, rigid alignment without scale; without
//                                        ground truth rmse is 0, and where it cannot be computed -1
//   coverage, frames, lost_frames, submaps, loops_closed, keyframes, points, lines
//   tracking_ms, tracking_p99_ms         features, matching and pose of a frame
//   frame_ms, frame_mean_ms, frame_p99_ms   all that a frame waits for, keyframes and loops
//   included mapping_ms, seconds, peak_memory_mib orb_ms, tracking_over_orb
//   cv::ORB::detectAndCompute on the same images, between them cloud_mb, octree_mb of cloud.ply and
//   map.bt, where there is a dense map
std::optional<RunRecord> RunOnce(const std::filesystem::path& dataset, const RunKey& key,
                                 const std::function<bool()>& stop = {});

}  // namespace highwall::bench
