#include "report/run_data.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/image_io.h>

#include "files/trajectory_file.h"
#include "images/encode.h"
#include "report/base64.h"
#include "report/report_graph.h"
#include "report/report_motion.h"
#include "report/report_number.h"
#include "report/report_words.h"
#include "run/finished_run.h"
#include "run/recording_identity.h"
#include "run/run_dataset.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kJpegQuality = 88;

struct Picture {
  const char* file;
  const char* of;
};
constexpr std::array kPictures = {
    Picture{"cloud.png", "The cloud from the side, coloured as the camera saw it"},
    Picture{"cloud_top.png", "The cloud from above"},
    Picture{"octree.png", "The octree from the side, coloured by height: violet low, yellow high"},
    Picture{"octree_top.png", "The octree from above, coloured by height: violet low, yellow high"},
    Picture{kSparseMapFile,
            "The sparse map from above: points black, lines green, keyframes blue, the path of "
            "the camera orange"}};

// Returns the frames of the map at `place`, after the final adjustment if there was one; empty if
// the file does not exist.
Trajectory TrajectoryOf(const fs::path& folder, std::size_t place) {
  for (const char* name : {kAdjustedFile, kTrajectoryFile}) {
    const fs::path path = folder / NameOfSubmap(name, place);
    if (fs::exists(path)) return ReadTumTrajectory(path);
  }
  return {};
}

// Converts stamps of run.json to seconds after the first frame.
json SecondsOf(const json& stamps, Stamp start, std::size_t stride = 1) {
  json seconds = json::array();
  for (std::size_t i = 0; i < stamps.size(); i += stride) {
    const std::optional<Stamp> stamp = ParseStamp(stamps[i].get<std::string>());
    seconds.push_back(stamp ? json(Rounded(ToSeconds(*stamp - start), 1e-4)) : json());
  }
  return seconds;
}

json EveryNth(const json& values, std::size_t stride) {
  json kept = json::array();
  for (std::size_t i = 0; i < values.size(); i += stride) kept.push_back(values[i]);
  return kept;
}

// Returns columns of a run.json table with "stamp", thinned to about `limit` rows.
json CurvesOf(const json& table, std::initializer_list<const char*> columns, Stamp start,
              std::size_t limit) {
  const json& stamps = table.at("stamp");
  const std::size_t stride = std::max<std::size_t>(1, (stamps.size() + limit - 1) / limit);
  json curves = {{"t", SecondsOf(stamps, start, stride)}};
  for (const char* column : columns) curves[column] = EveryNth(table.at(column), stride);
  return curves;
}

json ImuOf(const json& run, Stamp start, std::size_t limit) {
  if (!run.contains("imu") || !run["imu"].contains("intervals")) return nullptr;
  const json& imu = run["imu"];
  json curves = CurvesOf(imu["intervals"], {"weight", "innovation_per_dof"}, start, limit);
  if (imu.contains("states")) {
    curves["states"] = CurvesOf(
        imu["states"], {"gyroscope_bias", "accelerometer_bias", "time_offset"}, start, limit);
  }
  return curves;
}

json LostOf(const json& run, Stamp start) {
  const json stamps = run.value("lost_stamps", json::array());
  const json reasons = run.value("lost_because", json::array());
  json lost = json::array();
  const json seconds = SecondsOf(stamps, start);
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    lost.push_back({{"t", seconds[i]}, {"because", i < reasons.size() ? reasons[i] : json("")}});
  }
  return lost;
}

// Time spans without a gap of more than a second.
json SpansOf(const Trajectory& trajectory, Stamp start) {
  constexpr Stamp kHole = 1'000'000'000;
  json spans = json::array();
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const double t = Rounded(ToSeconds(trajectory[i].stamp - start), 1e-4);
    if (i == 0 || trajectory[i].stamp - trajectory[i - 1].stamp > kHole) spans.push_back({t, t});
    spans.back()[1] = t;
  }
  return spans;
}

json MapsOf(const json& run, const std::vector<Trajectory>& trajectories, Stamp start) {
  json maps = json::array();
  const json submaps = run.value("submaps", json::array());
  const std::size_t first = FirstPlace(run);
  for (std::size_t i = 0; i < trajectories.size(); ++i) {
    const json submap = i < submaps.size() ? submaps[i] : json::object();
    maps.push_back({{"name", NameOfSubmap(kTrajectoryFile, first + i)},
                    {"frames", trajectories[i].size()},
                    {"keyframes", submap.value("keyframes", json())},
                    {"spans", SpansOf(trajectories[i], start)}});
  }
  return maps;
}

// place: of the largest map.
json PicturesOf(const fs::path& folder, std::size_t place) {
  json pictures = json::array();
  for (const Picture& picture : kPictures) {
    const fs::path path = folder / NameOfSubmap(picture.file, place);
    if (!fs::exists(path)) continue;
    const std::vector<std::uint8_t> jpeg = EncodeJpeg(ReadColourImage(path), kJpegQuality);
    pictures.push_back(
        {{"name", picture.file},
         {"of", picture.of},
         {"src", "data:image/jpeg;base64," + Base64Of(std::span<const std::uint8_t>(jpeg))}});
  }
  return pictures;
}

// Returns the ground truth of the dataset, if the dataset is unambiguous.
std::optional<Trajectory> TruthOf(const fs::path& folder, const json& run,
                                  const RunDataOptions& options) {
  if (options.truth) return ReadTrajectoryFile(*options.truth).poses;
  const std::vector<fs::path> datasets = DatasetsOfRun(folder, run);
  if (datasets.size() != 1) return std::nullopt;
  const fs::path beside = datasets.front() / "groundtruth.txt";
  if (!fs::exists(beside)) return std::nullopt;
  // That of another recording would be compared with poses that it knows nothing of.
  if (!DifferenceFromRun(datasets.front(), run).empty()) return std::nullopt;
  try {
    return ReadTrajectoryFile(beside).poses;
  } catch (const IoError&) {  // the run has warned about it already, and the page does not need it
    return std::nullopt;
  }
}

// Returns the stamp of the first frame of the run, with or without a pose.
Stamp StartOf(const json& run, const std::vector<Trajectory>& trajectories) {
  if (run.contains("per_frame") && !run["per_frame"]["stamp"].empty()) {
    if (const auto stamp = ParseStamp(run["per_frame"]["stamp"][0].get<std::string>())) {
      return *stamp;
    }
  }
  Stamp start = trajectories.front().front().stamp;
  for (const Trajectory& trajectory : trajectories) {
    if (!trajectory.empty()) start = std::min(start, trajectory.front().stamp);
  }
  return start;
}

// Per-frame data is stored in separate curves.
json WithoutSeries(json run) {
  for (const char* key : {"per_frame", "lost_stamps", "lost_because"}) run.erase(key);
  if (run.contains("imu")) {
    for (const char* key : {"intervals", "states"}) run["imu"].erase(key);
  }
  return run;
}

json GraphOf(const fs::path& folder, const Trajectory& trajectory) {
  const fs::path path = folder / kMapFile;
  return fs::exists(path) ? GraphJson(LoadMap(path).map, trajectory) : json::object();
}

std::vector<Trajectory> TrajectoriesOf(const fs::path& folder, const json& run) {
  std::vector<Trajectory> trajectories;
  const std::size_t maps = std::max<std::size_t>(1, run.value("submaps", json::array()).size());
  const std::size_t first = FirstPlace(run);
  for (std::size_t i = 0; i < maps; ++i) trajectories.push_back(TrajectoryOf(folder, first + i));
  if (trajectories.front().empty()) {
    throw IoError(folder / NameOfSubmap(kTrajectoryFile, first), "holds no pose");
  }
  return trajectories;
}

json Assemble(const fs::path& folder, const json& run, const RunDataOptions& options) {
  const std::vector<Trajectory> trajectories = TrajectoriesOf(folder, run);
  const Trajectory& largest = trajectories.front();
  const Stamp start = StartOf(run, trajectories);
  const std::optional<Trajectory> truth = TruthOf(folder, run, options);
  const std::optional<MotionErrors> errors =
      truth ? CompareWithTruth(*truth, largest) : std::nullopt;
  json data = {{"name", fs::weakly_canonical(folder).filename().string()},
               {"folder", folder.string()},
               {"path", PathJson(largest, start, errors, options.samples)},
               {"errors", errors ? ErrorsJson(*errors, start, options.samples) : json()},
               {"maps", MapsOf(run, trajectories, start)},
               {"lost", LostOf(run, start)},
               {"imu", ImuOf(run, start, options.samples)},
               {"graph", GraphOf(folder, largest)},
               {"loops", LoopsJson(largest, start,
                                   run.value(json::json_pointer("/loops/events"), json::array()))},
               {"scene", SceneJson(folder, FirstPlace(run), options.scene)},
               {"pictures", PicturesOf(folder, FirstPlace(run))}};
  data["words"] = SummaryInWords(run, data["errors"]);
  data["frames"] =
      run.contains("per_frame")
          ? CurvesOf(run["per_frame"], {"points", "lines", "milliseconds"}, start, options.samples)
          : json();
  data["run"] = WithoutSeries(run);
  return data;
}

}  // namespace

json RunData(const fs::path& folder, const RunDataOptions& options) {
  const json run = ReadReport(folder);
  try {
    return Assemble(folder, run, options);
  } catch (const json::exception&) {
    throw IoError(folder / kReportFile, "is damaged: run highwall slam again");
  }
}

}  // namespace highwall::apps
