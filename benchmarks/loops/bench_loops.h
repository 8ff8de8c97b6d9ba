#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/frontend/features/frame.h>

namespace highwall::bench {

// Walks that come back: is every return found, is anything false, how good is the trajectory?
// scene: room, for `seconds` with laps of at most 20 s, RGB-D alone; mine or road, once round, with
// an IMU.
nlohmann::json BenchReturns(const std::string& scene, int seeds, double seconds);

// The camera is blinded and put down elsewhere in the room: how many frames until it knows where?
nlohmann::json BenchKidnapped(int seeds);

// A room seen for so long, lap after lap: what the process holds after each of them. imu: with
// its readings.
nlohmann::json BenchEndurance(double minutes, bool imu);

// Recall and time of a query among `keyframes` keyframes: ours, OpenCV's FLANN LSH, faiss.
nlohmann::json BenchIndex(int keyframes);

// Loops over up to `keyframes` keyframes, and over a half, a quarter, an eighth of them, that have
// drifted as odometry does: error before and after, and the time it takes.
nlohmann::json BenchCorrection(int keyframes, int seeds);

// Which loops are taken as the map grows: true ones, ones within and beyond the drift of the way;
// and how often geometry verifies a second place that looks like the first.
nlohmann::json BenchAcceptance(const std::vector<int>& sizes, int seeds);

// Descriptors of all keyframes, one below the other, and what a query finds among them.
struct DescriptorSet {
  std::vector<std::shared_ptr<const FrameFeatures>> keyframes;
  std::vector<int> keyframe_of;  // of every row
  cv::Mat descriptors;           // N x 32 CV_8U
};
struct Query {
  std::shared_ptr<const FrameFeatures> features;
  int place = 0;  // keyframe / copies
};

// Shares of right places and times of faiss' binary indexes; empty without faiss.
std::vector<nlohmann::json> BenchFaiss(const DescriptorSet& set, const std::vector<Query>& queries,
                                       int copies);

// Share of right places and times of an index. fill(): builds it. answer(): the keyframe that it
// takes for the query's, -1 for none; right where it is of the place asked for. Also told in a line
// on standard error.
nlohmann::json BenchOne(const std::string& name, const std::vector<Query>& queries, int copies,
                        const std::function<void()>& fill,
                        const std::function<int(const Query&)>& answer);

// The keyframe with most votes, -1 for none. neighbours: row numbers, -1 for none, of every query
// descriptor.
int BestKeyFrame(const DescriptorSet& set, const std::vector<std::vector<int>>& neighbours);

}  // namespace highwall::bench
