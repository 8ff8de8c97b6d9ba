#include "run/finished_run.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "files/json_text.h"
#include "run/run_dataset.h"
#include "run/run_files.h"
#include "run/run_report.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

// Tolerance for the pose of a keyframe's frame, which is smoothed; those of another session differ
// more.
constexpr double kSamePose = 0.02;  // [m], and [rad]

// Returns the map of a run: the one in its folder, otherwise the one saved by --save-map.
fs::path MapOfRun(const fs::path& folder, const nlohmann::json& report) {
  using Pointer = nlohmann::json::json_pointer;
  if (report.value(Pointer("/options/localize_only"), false)) {
    throw IoError(folder,
                  "is a localization (highwall slam --localize), which makes no map: give the run "
                  "that made its map");
  }
  const fs::path map = folder / kMapFile;
  if (fs::exists(map)) return map;
  const std::string saved = FromUtf8(report.value(Pointer("/options/saved_map"), std::string()));
  const std::vector<fs::path> places = PlacesOf(saved, folder);
  if (places.size() == 1) return places.front();
  throw IoError(map,
                "is not there: run highwall slam again, which writes it, or give a map that "
                "--save-map wrote in place of the run");
}

void AddFrames(const Trajectory& trajectory, const Map& map, Session* session) {
  std::vector<AnchoredFrame> frames = AnchorFrames(trajectory, map);
  if (frames.empty()) session->left_out += trajectory.size();
  session->frames.insert(session->frames.end(), frames.begin(), frames.end());
}

// Reads the sessions of merged runs.
std::vector<Session> ReadMergedSessions(const fs::path& folder, const nlohmann::json& report,
                                        const Map& map) {
  std::vector<Session> sessions;
  for (const nlohmann::json& run : report.at("runs")) {
    Session& session = sessions.emplace_back();
    session.name = StringIn(run.at("name"));
    for (const nlohmann::json& file : run.at("trajectories")) {
      AddFrames(ReadTumTrajectory(folder / file.get<std::string>()), map, &session);
    }
  }
  return sessions;
}

Session ReadSession(const fs::path& folder, const nlohmann::json& report, const Map& map) {
  Session session;
  session.name = folder.string();
  const std::size_t worlds = report.value("submaps", nlohmann::json::array()).size();
  const std::size_t first = FirstPlace(report);
  for (std::size_t i = first; i < first + std::max<std::size_t>(worlds, 1); ++i) {
    // The map reflects the final adjustment, if there was one.
    const fs::path adjusted = folder / NameOfSubmap(kAdjustedFile, i);
    const fs::path plain = folder / NameOfSubmap(kTrajectoryFile, i);
    AddFrames(ReadTumTrajectory(fs::exists(adjusted) ? adjusted : plain), map, &session);
  }
  return session;
}

Trajectory KeyFrameTrajectory(const Map& map, SubmapId world) {
  Trajectory trajectory;
  for (const KeyFrameId id : map.KeyFramesOf(world)) {
    trajectory.push_back({map.keyframe(id)->frame.stamp, map.keyframe(id)->T_WC});
  }
  std::ranges::stable_sort(trajectory, {}, &StampedPose::stamp);
  return trajectory;
}

FinishedRun ReadFolder(const fs::path& folder) {
  const nlohmann::json report = ReadReport(folder);
  FinishedRun run;
  run.path = folder;
  try {
    run.saved = LoadMap(MapOfRun(folder, report));
    run.depth_noise = DepthNoiseOf(report);
    if (report.contains("runs")) {
      run.sessions = ReadMergedSessions(folder, report, run.saved.map);
    } else {
      run.sessions = {ReadSession(folder, report, run.saved.map)};
    }
  } catch (const nlohmann::json::exception&) {
    throw IoError(folder / kReportFile, "is damaged: run highwall slam again");
  } catch (const InvalidArgument& error) {
    throw IoError(folder / kReportFile, error.what());
  }
  return run;
}

// A frame that is a keyframe.
struct Anchor {
  const StampedPose* frame;
  KeyFrameId keyframe;
};

// Returns the anchors ascending in time, all of one world: the one with most of them. In another
// world, a session that began at the same time may initially have the same poses.
std::vector<Anchor> FindAnchors(const Trajectory& frames, const Map& map) {
  std::map<SubmapId, std::vector<Anchor>> by_world;
  for (const KeyFrameId id : map.keyframe_ids()) {
    const KeyFrame& keyframe = *map.keyframe(id);
    const Stamp stamp = keyframe.frame.stamp;
    auto frame = std::ranges::lower_bound(frames, stamp, {}, &StampedPose::stamp);
    for (; frame != frames.end() && frame->stamp == stamp; ++frame) {
      const Pose off = frame->pose.Inverse() * keyframe.T_WC;
      if (off.p().norm() > kSamePose || off.Angle() > kSamePose) continue;
      by_world[map.Root(keyframe.submap)].push_back({&*frame, id});
    }
  }
  if (by_world.empty()) return {};
  std::vector<Anchor> anchors =
      std::ranges::max_element(by_world, {}, [](const auto& w) { return w.second.size(); })->second;
  std::ranges::stable_sort(anchors, {}, [](const Anchor& a) { return a.frame->stamp; });
  return anchors;
}

}  // namespace

nlohmann::json ReadReport(const fs::path& folder) {
  const fs::path path = folder / kReportFile;
  nlohmann::json report = ReadJson(path);
  if (report.is_null()) {
    throw IoError(folder,
                  "is no finished run: it has no run.json (highwall slam --out, or "
                  "highwall merge --out, writes one in the end)");
  }
  if (!report.is_object()) throw IoError(path, "is damaged: run highwall slam again");
  return report;
}

bool IsSameCamera(const PinholeCamera& a, const PinholeCamera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy;
}

std::vector<AnchoredFrame> AnchorFrames(const Trajectory& frames, const Map& map) {
  const std::vector<Anchor> anchors = FindAnchors(frames, map);
  if (anchors.empty()) return {};
  const auto stamp_of = [](const Anchor& anchor) { return anchor.frame->stamp; };
  std::vector<AnchoredFrame> anchored;
  for (const StampedPose& frame : frames) {
    auto nearest = std::ranges::lower_bound(anchors, frame.stamp, {}, stamp_of);
    const bool has_before = nearest != anchors.begin();
    if (nearest == anchors.end() || (has_before && frame.stamp - stamp_of(*std::prev(nearest)) <=
                                                       stamp_of(*nearest) - frame.stamp)) {
      --nearest;
    }
    anchored.push_back({frame.stamp, AnchoredPose::At(map, nearest->keyframe, frame.pose)});
  }
  return anchored;
}

FinishedRun ReadFinishedRun(const fs::path& path) {
  if (fs::is_directory(path)) return ReadFolder(path);
  if (!fs::exists(path)) throw IoError(path, "is not there: give the folder of a finished run");
  FinishedRun run;
  run.path = path;
  run.saved = LoadMap(path);
  Session& session = run.sessions.emplace_back();
  session.name = path.string();
  for (const SubmapId root : run.saved.map.roots()) {
    AddFrames(KeyFrameTrajectory(run.saved.map, root), run.saved.map, &session);
  }
  return run;
}

}  // namespace highwall::apps
