#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/frontend/features/frame.h>

namespace highwall::bench {

// Measures closed walks: loops found, false loops, and trajectory error. scene: room, for `seconds`
// with laps of at most 20 s, RGB-D only; mine or road, one lap, with an IMU.
nlohmann::json BenchReturns(const std::string& scene, int seeds, double seconds);

// Blinds the camera and moves it elsewhere in the room: counts the frames until relocalization.
nlohmann::json BenchKidnapped(int seeds);

// Observes a room for several minutes, lap after lap: memory of the process after each lap. imu:
// with its readings.
nlohmann::json BenchEndurance(double minutes, bool imu);

// Recall and time of a query among `keyframes` keyframes: ours, OpenCV's FLANN LSH, faiss.
nlohmann::json BenchIndex(int keyframes);

// Closes loops over up to `keyframes` keyframes, and over a half, a quarter, an eighth of them,
// with odometry drift: error before and after, and the time it takes.
nlohmann::json BenchCorrection(int keyframes, int seeds);

// Measures which loops are accepted as the map grows: true ones, and ones within and beyond the
// drift of the path; and how often geometry verifies a different place with similar appearance.
nlohmann::json BenchAcceptance(const std::vector<int>& sizes, int seeds);

// Measures what the edges of the keyframe graph state about their errors, in walks with a weak
// stretch: squared errors by RelativeCovariance, on average 6 for the right one. scene: room, by
// images alone; mine or road, with an IMU.
nlohmann::json BenchEdges(const std::string& scene, int seeds);

// Descriptors of all keyframes, row by row, for queries.
struct DescriptorSet {
  std::vector<std::shared_ptr<const FrameFeatures>> keyframes;
  std::vector<int> keyframe_of;  // of every row
  cv::Mat descriptors;           // N x 32 CV_8U
};
struct Query {
  std::shared_ptr<const FrameFeatures> features;
  int place = 0;  // keyframe / copies
};

// Recall and time of faiss' binary indexes; empty without faiss.
std::vector<nlohmann::json> BenchFaiss(const DescriptorSet& set, const std::vector<Query>& queries,
                                       int copies);

// Measures recall and time of an index. fill(): builds it. answer(): returns the keyframe that it
// selects for the query, -1 for none; correct if it shows the queried place. Also prints a line on
// standard error.
nlohmann::json BenchOne(const std::string& name, const std::vector<Query>& queries, int copies,
                        const std::function<void()>& fill,
                        const std::function<int(const Query&)>& answer);

// Returns the keyframe with most votes, -1 for none. neighbours: row numbers, -1 for none, of every
// query descriptor.
int BestKeyFrame(const DescriptorSet& set, const std::vector<std::vector<int>>& neighbours);

}  // namespace highwall::bench
