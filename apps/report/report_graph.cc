#include "report/report_graph.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/stamp.h>

#include "plots/sparse_map_picture.h"
#include "report/base64.h"
#include "report/report_number.h"
#include "run/finished_run.h"

namespace highwall::apps {
namespace {

constexpr int kLeastShared = 15;           // minimum number of landmarks for a drawn edge
constexpr std::size_t kEdgesEach = 4;      // per keyframe, those with most common landmarks
constexpr std::size_t kMostLines = 8'000;  // the longest ones

nlohmann::json CovisibleJson(const Map& map, const std::vector<KeyFrameId>& keyframes) {
  std::map<KeyFrameId, std::size_t> places;
  for (std::size_t i = 0; i < keyframes.size(); ++i) places[keyframes[i]] = i;
  std::map<std::pair<std::size_t, std::size_t>, int> edges;
  for (const auto& [id, place] : places) {
    std::vector<std::pair<KeyFrameId, int>> neighbours = map.Covisible(id, kLeastShared);
    std::ranges::stable_sort(neighbours, std::greater(), &std::pair<KeyFrameId, int>::second);
    if (neighbours.size() > kEdgesEach) neighbours.resize(kEdgesEach);
    for (const auto& [other, shared] : neighbours) {
      const auto at = places.find(other);
      if (at != places.end()) edges[std::minmax(place, at->second)] = shared;
    }
  }
  nlohmann::json json = nlohmann::json::array();
  for (const auto& [pair, shared] : edges) json.push_back({pair.first, pair.second, shared});
  return json;
}

nlohmann::json KeyFramesJson(const Map& map, const std::vector<KeyFrameId>& keyframes) {
  nlohmann::json json = nlohmann::json::array();
  for (const KeyFrameId id : keyframes) {
    const KeyFrame& keyframe = *map.keyframe(id);
    const Eigen::Quaterniond q = keyframe.T_WC.q();
    json.push_back({{"stamp", FormatStamp(keyframe.frame.stamp)},
                    {"position", PositionJson(keyframe.T_WC.p())},
                    {"rotation",
                     {Rounded(q.x(), 1e-5), Rounded(q.y(), 1e-5), Rounded(q.z(), 1e-5),
                      Rounded(q.w(), 1e-5)}}});
  }
  return json;
}

// Returns the position of a frame in the trajectory, or null if it is not part of it.
nlohmann::json PlaceOf(const Trajectory& trajectory, const std::optional<Stamp>& stamp) {
  if (!stamp) return nullptr;
  const auto at = std::ranges::lower_bound(trajectory, *stamp, {}, &StampedPose::stamp);
  if (at == trajectory.end() || at->stamp != *stamp) return nullptr;
  return PositionJson(at->pose.p());
}

nlohmann::json SecondsAfter(Stamp start, const std::optional<Stamp>& stamp) {
  return stamp ? nlohmann::json(Rounded(ToSeconds(*stamp - start), 1e-3)) : nlohmann::json();
}

std::string LinesBase64(std::vector<Segment3> lines) {
  if (lines.size() > kMostLines) {
    std::ranges::stable_sort(lines, std::greater(), &Segment3::Length);
    lines.resize(kMostLines);
  }
  std::vector<float> ends;
  for (const Segment3& line : lines) {
    for (int i = 0; i < Segment3::kSize; ++i) ends.push_back(static_cast<float>(line.data()[i]));
  }
  return Base64Of(std::span<const float>(ends));
}

}  // namespace

nlohmann::json GraphJson(const Map& map, const Trajectory& trajectory) {
  const std::vector<AnchoredFrame> anchored = AnchorFrames(trajectory, map);
  if (anchored.empty()) return nlohmann::json::object();
  const SubmapId world = *map.RootOf(anchored.front().pose.reference);
  const std::vector<KeyFrameId> keyframes = map.KeyFramesOf(world);
  SparseMap sparse = SurveyMap(map, world, {}, {});
  return {{"keyframes", KeyFramesJson(map, keyframes)},
          {"covisible", CovisibleJson(map, keyframes)},
          {"points", sparse.points_W.size()},
          {"line_count", sparse.lines_W.size()},
          {"lines", LinesBase64(std::move(sparse.lines_W))}};
}

nlohmann::json LoopsJson(const Trajectory& trajectory, Stamp start, const nlohmann::json& events) {
  nlohmann::json json = nlohmann::json::array();
  for (nlohmann::json event : events) {
    const auto keyframe = ParseStamp(event.value("keyframe_stamp", std::string()));
    const auto match = ParseStamp(event.value("match_stamp", std::string()));
    event["from"] = PlaceOf(trajectory, keyframe);
    event["to"] = PlaceOf(trajectory, match);
    event["t"] = SecondsAfter(start, keyframe);
    event["t_match"] = SecondsAfter(start, match);
    json.push_back(std::move(event));
  }
  return json;
}

}  // namespace highwall::apps
