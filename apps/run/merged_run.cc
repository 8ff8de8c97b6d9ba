#include "run/merged_run.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/map/feature_type_mismatch.h>

#include "plots/map_pictures.h"
#include "plots/sparse_map_picture.h"
#include "run/run_output.h"
#include "run/run_report.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

std::string Describe(const PinholeCamera& camera) {
  return fmt::format("{} x {}, fx {:.6g}, fy {:.6g}, cx {:.6g}, cy {:.6g}", camera.width,
                     camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
}

void RequireOneCamera(const std::vector<FinishedRun>& runs) {
  const FinishedRun& first = runs.front();
  for (const FinishedRun& run : runs) {
    if (IsSameCamera(run.saved.camera, first.saved.camera)) continue;
    throw IoError(run.path, fmt::format("is a map of another camera ({}) than {} ({}): only maps "
                                        "of one camera can be merged",
                                        Describe(run.saved.camera), first.path.string(),
                                        Describe(first.saved.camera)));
  }
}

void RequireOneFeatureType(const std::vector<FinishedRun>& runs) {
  const FinishedRun& first = runs.front();
  for (const FinishedRun& run : runs) {
    const auto clash = FindMismatch(run.saved.map, first.saved.map);
    if (!clash) continue;
    throw IoError(run.path, fmt::format("is a map of points by {}, {} of points by {}: only maps "
                                        "of one kind of points can be merged",
                                        clash->first, first.path.string(), clash->second));
  }
}

bool IsOfOneImage(const Frame& a, const Frame& b) {
  return a.stamp == b.stamp && std::ranges::equal(a.features->points, b.features->points, {},
                                                  &PointFeature::uv, &PointFeature::uv);
}

std::size_t CountShared(const Map& map, const Map& other) {
  std::multimap<Stamp, const Frame*> others;
  for (const KeyFrameId id : other.keyframe_ids()) {
    const Frame& frame = other.keyframe(id)->frame;
    others.emplace(frame.stamp, &frame);
  }
  std::size_t shared = 0;
  for (const KeyFrameId id : map.keyframe_ids()) {
    const Frame& frame = map.keyframe(id)->frame;
    const auto [begin, end] = others.equal_range(frame.stamp);
    const auto is_same = [&](const auto& entry) { return IsOfOneImage(frame, *entry.second); };
    if (std::any_of(begin, end, is_same)) ++shared;
  }
  return shared;
}

// If a run loaded the map of another, or was merged from it, most keyframes of one are in the
// other; runs of overlapping parts of a recording share some.
void RequireKeyFramesOfTheirOwn(const std::vector<FinishedRun>& runs) {
  for (std::size_t later = 1; later < runs.size(); ++later) {
    for (std::size_t earlier = 0; earlier < later; ++earlier) {
      const FinishedRun *part = &runs[earlier], *whole = &runs[later];
      if (part->saved.map.num_keyframes() > whole->saved.map.num_keyframes()) {
        std::swap(part, whole);
      }
      const std::size_t keyframes = part->saved.map.num_keyframes();
      const std::size_t shared = CountShared(part->saved.map, whole->saved.map);
      if (2 * shared <= keyframes) continue;
      throw IoError(
          whole->path,
          fmt::format("holds {} of the {} keyframes of {} already: it went on in that map "
                      "or is of the same recording; leave {} out",
                      shared, keyframes, part->path.string(), part->path.string()));
    }
  }
}

// Returns the largest noise of all runs.
DepthNoise NoiseOf(const std::vector<FinishedRun>& runs) {
  constexpr double kDepth = 2.0;  // [m] where they are compared
  const auto sigma = [](const FinishedRun& run) { return run.depth_noise.Sigma(kDepth); };
  return std::ranges::max_element(runs, {}, sigma)->depth_noise;
}

// Returns all sessions if their frames do not overlap in time, otherwise only the one with most
// frames.
std::vector<std::size_t> OneAfterTheOther(const std::vector<Trajectory>& frames) {
  std::vector<std::size_t> sessions;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].empty()) sessions.push_back(i);
  }
  std::ranges::sort(sessions, {}, [&](std::size_t i) { return frames[i].front().stamp; });
  const auto overlap = [&](std::size_t a, std::size_t b) {
    return frames[b].front().stamp <= frames[a].back().stamp;
  };
  if (std::ranges::adjacent_find(sessions, overlap) == sessions.end()) return sessions;
  return {*std::ranges::max_element(sessions, {}, [&](std::size_t i) { return frames[i].size(); })};
}

std::size_t NumFrames(const MergedWorld& world) {
  return std::accumulate(world.frames.begin(), world.frames.end(), std::size_t{0},
                         [](std::size_t n, const Trajectory& t) { return n + t.size(); });
}

std::vector<MergedWorld> WorldsOf(const Map& map, const std::vector<Session>& sessions) {
  std::map<SubmapId, MergedWorld> by_root;
  for (const SubmapId root : map.roots()) {
    by_root[root] = {root, std::vector<Trajectory>(sessions.size()), {}};
  }
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    for (const AnchoredFrame& frame : sessions[i].frames) {
      MergedWorld& world = by_root.at(*map.RootOf(frame.pose.reference));
      world.frames[i].push_back({frame.stamp, frame.pose.T_WC(map)});
    }
  }
  std::vector<MergedWorld> worlds;
  for (auto& [root, world] : by_root) {
    // Parts of a session may have been merged.
    for (Trajectory& frames : world.frames) {
      std::ranges::stable_sort(frames, {}, &StampedPose::stamp);
    }
    world.in_one_file = OneAfterTheOther(world.frames);
    worlds.push_back(std::move(world));
  }
  std::ranges::stable_sort(worlds, std::greater(), NumFrames);
  return worlds;
}

Trajectory InOneFile(const MergedWorld& world) {
  Trajectory all;
  for (const std::size_t session : world.in_one_file) {
    const Trajectory& frames = world.frames[session];
    all.insert(all.end(), frames.begin(), frames.end());
  }
  return all;
}

// Returns the keyframes of the sessions in one file.
Trajectory KeyFramesIn(const MergedWorld& world, const MergedRuns& runs) {
  const Map& map = runs.merged.map;
  std::set<KeyFrameId> ids;
  for (const std::size_t session : world.in_one_file) {
    for (const AnchoredFrame& frame : runs.sessions[session].frames) {
      if (map.RootOf(frame.pose.reference) == world.root) ids.insert(frame.pose.reference);
    }
  }
  Trajectory keyframes;
  for (const KeyFrameId id : ids) {
    keyframes.push_back({map.keyframe(id)->frame.stamp, map.keyframe(id)->T_WC});
  }
  std::ranges::stable_sort(keyframes, {}, &StampedPose::stamp);
  return keyframes;
}

nlohmann::json RunsJson(const MergedRuns& runs) {
  nlohmann::json all = nlohmann::json::array();
  for (std::size_t i = 0; i < runs.sessions.size(); ++i) {
    const Session& session = runs.sessions[i];
    nlohmann::json files = nlohmann::json::array(), places = nlohmann::json::array();
    for (std::size_t place = 0; place < runs.worlds.size(); ++place) {
      if (runs.worlds[place].frames[i].empty()) continue;
      files.push_back(NameOfSubmap(TrajectoryOfRun(i), place));
      places.push_back(runs.worlds[place].root.value());
    }
    all.push_back({{"name", session.name},
                   {"frames", session.frames.size()},
                   {"frames_left_out", session.left_out},
                   {"submaps", places},
                   {"trajectories", files}});
  }
  return all;
}

nlohmann::json WorldsJson(const MergedRuns& runs) {
  nlohmann::json all = nlohmann::json::array();
  for (const MergedWorld& world : runs.worlds) {
    nlohmann::json sessions = nlohmann::json::array(), in_one_file = nlohmann::json::array();
    for (std::size_t i = 0; i < world.frames.size(); ++i) {
      if (!world.frames[i].empty()) sessions.push_back(i + 1);
    }
    for (const std::size_t session : world.in_one_file) in_one_file.push_back(session + 1);
    all.push_back({{"id", world.root.value()},
                   {"frames", NumFrames(world)},
                   {"keyframes", runs.merged.map.NumKeyFramesOf(world.root)},
                   {"runs", sessions},
                   {"trajectory", NameOfSubmap(kTrajectoryFile, all.size())},
                   {"runs_in_trajectory", in_one_file}});
  }
  return all;
}

nlohmann::json LoopsJson(const MergedRuns& runs) {
  nlohmann::json events = nlohmann::json::array();
  std::size_t closed = 0, refused = 0, merges = 0;
  for (const LoopReport& report : runs.merged.loops) {
    const LoopEdge& edge = report.loop.edge;
    const bool merged = report.accepted && report.merge.has_value();
    nlohmann::json event = {{"keyframe", edge.keyframe.value()},
                            {"match", edge.match.value()},
                            {"maps", {runs.RunOf(edge.match) + 1, runs.RunOf(edge.keyframe) + 1}},
                            {"result", !report.accepted ? "refused"
                                       : merged         ? "merged"
                                                        : "closed"}};
    if (!report.accepted) event["because"] = report.message;
    events.push_back(std::move(event));
    ++(report.accepted ? closed : refused);
    if (merged) ++merges;
  }
  return {{"closed", closed}, {"refused", refused}, {"merges", merges}, {"events", events}};
}

nlohmann::json ReportOf(const MergedRuns& runs) {
  nlohmann::json maps = nlohmann::json::array();
  for (std::size_t i = 0; i < runs.runs.size(); ++i) {
    maps.push_back({{"path", AbsoluteName(runs.runs[i].path)},
                    {"keyframes", runs.merged.keyframes[i].size()}});
  }
  const Map& map = runs.merged.map;
  return {{"versions", VersionsJson()},
          {"maps", maps},
          {"runs", RunsJson(runs)},
          {"submaps", WorldsJson(runs)},
          {"loops", LoopsJson(runs)},
          {"keyframes", map.num_keyframes()},
          {"landmarks", {{"points", map.num<MapPoint>()}, {"lines", map.num<MapLine>()}}},
          {"depth_noise", ToJson(NoiseOf(runs.runs))},
          {"complete", true}};
}

}  // namespace

std::size_t MergedRuns::RunOf(KeyFrameId keyframe) const {
  const auto has = [&](const std::vector<KeyFrameId>& ids) {
    return std::ranges::binary_search(ids, keyframe);
  };
  return static_cast<std::size_t>(std::ranges::find_if(merged.keyframes, has) -
                                  merged.keyframes.begin());
}

bool MergedRuns::IsIn(std::size_t run, const MergedWorld& world) const {
  return std::ranges::any_of(merged.keyframes[run],
                             [&](KeyFrameId id) { return merged.map.RootOf(id) == world.root; });
}

MergedRuns MergeRuns(std::vector<FinishedRun> runs, const MergeProgress& progress) {
  HIGHWALL_REQUIRE(!runs.empty(), "MergeRuns: there are no runs");
  RequireOneCamera(runs);
  RequireOneFeatureType(runs);
  RequireKeyFramesOfTheirOwn(runs);
  MergedRuns result;
  result.camera = runs.front().saved.camera;
  RgbdSensor sensor;
  sensor.camera = result.camera;
  sensor.depth_noise = NoiseOf(runs);
  std::vector<Map> maps;
  for (FinishedRun& run : runs) maps.push_back(std::exchange(run.saved.map, Map()));
  result.merged = MergeMaps(sensor, std::move(maps), {}, progress);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (Session& session : runs[i].sessions) {
      // A loaded map has consecutive ids.
      for (AnchoredFrame& frame : session.frames) {
        KeyFrameId& reference = frame.pose.reference;
        reference = result.merged.keyframes[i][reference.index()];
      }
      result.sessions.push_back(std::move(session));
    }
    runs[i].sessions.clear();
  }
  result.runs = std::move(runs);
  result.worlds = WorldsOf(result.merged.map, result.sessions);
  return result;
}

nlohmann::json WriteMergedRuns(const fs::path& folder, const MergedRuns& runs) {
  BeginFolder(folder);
  SaveMap(folder / kMapFile, runs.camera, runs.merged.map);
  for (std::size_t place = 0; place < runs.worlds.size(); ++place) {
    const MergedWorld& world = runs.worlds[place];
    const auto path = [&](const std::string& name) { return folder / NameOfSubmap(name, place); };
    WriteTumTrajectory(path(kTrajectoryFile), InOneFile(world));
    WriteTumTrajectory(path(kKeyframesFile), KeyFramesIn(world, runs));
    for (std::size_t i = 0; i < world.frames.size(); ++i) {
      if (!world.frames[i].empty()) WriteTumTrajectory(path(TrajectoryOfRun(i)), world.frames[i]);
    }
  }
  if (!runs.worlds.empty()) {
    const MergedWorld& largest = runs.worlds.front();
    const SparseMap sparse =
        SurveyMap(runs.merged.map, largest.root, InOneFile(largest), KeyFramesIn(largest, runs));
    const cv::Mat picture = DrawSparseMap(sparse, Eigen::Quaterniond::Identity(), 1200);
    if (!picture.empty()) WritePng(folder / kSparseMapFile, picture);
  }
  nlohmann::json report = ReportOf(runs);
  WriteReport(folder, report);
  return report;
}

}  // namespace highwall::apps
