#include "sweep_record.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>

#include "files/json_text.h"
#include "run/run_report.h"

namespace highwall::bench {
namespace {

std::string AsFileName(std::string name) {
  std::ranges::replace(name, '/', '_');
  return name;
}

std::filesystem::path TrajectoryFile(std::filesystem::path record) {
  return record.replace_extension(".txt");
}

std::set<std::filesystem::path> RecordFiles(const std::filesystem::path& runs) {
  std::error_code error;
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(runs, error)) {
    if (entry.path().extension() == ".json") files.insert(entry.path());
  }
  if (error || files.empty()) throw IoError(runs, "holds no run of a sweep");
  return files;
}

MapChoice MapChoiceOf(const std::string& name) {
  for (const MapChoice map : {MapChoice::kDefault, MapChoice::kPaper}) {
    if (ToString(map) == name) return map;
  }
  return MapChoice::kNone;
}

}  // namespace

std::filesystem::path NameOf(const RunKey& key) {
  std::filesystem::path name = AsFileName(key.sequence);
  if (key.seed > 0) name /= fmt::format("seed{}", key.seed);
  return name / key.setting.name / std::to_string(key.run);
}

std::filesystem::path RecordFile(const std::filesystem::path& sweep, const RunKey& key) {
  return sweep / "runs" / (NameOf(key).string() + ".json");
}

void WriteRecord(const std::filesystem::path& sweep, const RunRecord& record) {
  const std::filesystem::path path = RecordFile(sweep, record.key);
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  if (error) throw IoError(path.parent_path(), "cannot be made: " + error.message());
  WriteTumTrajectory(TrajectoryFile(path), record.trajectory);
  const nlohmann::json json{
      {"sequence", record.key.sequence},         {"seed", record.key.seed},
      {"setting", record.key.setting.name},      {"switches", record.key.setting.switches},
      {"map", ToString(record.key.setting.map)}, {"run", record.key.run},
      {"lockstep", record.key.synchronous},      {"live_rate", record.key.live_rate},
      {"versions", apps::VersionsJson()},        {"figures", record.figures},
      {"loss_reasons", record.loss_reasons}};
  AtomicFile file(path);
  file.stream() << apps::JsonText(json, 2) << '\n';
  file.Commit();
}

RunRecord ReadRecord(const std::filesystem::path& file) {
  RunRecord record;
  try {
    std::ifstream stream(file);
    if (!stream) throw IoError(file, "cannot be read");
    const nlohmann::json json = nlohmann::json::parse(stream);
    record.key.sequence = apps::StringIn(json.at("sequence"));
    json.at("seed").get_to(record.key.seed);
    record.key.setting.name = apps::StringIn(json.at("setting"));
    record.key.setting.switches = apps::StringIn(json.at("switches"));
    record.key.setting.map = MapChoiceOf(json.at("map"));
    json.at("run").get_to(record.key.run);
    json.at("lockstep").get_to(record.key.synchronous);
    record.key.live_rate = json.value("live_rate", 0.0);  // absent from earlier versions
    json.at("figures").get_to(record.figures);
    json.at("loss_reasons").get_to(record.loss_reasons);
  } catch (const nlohmann::json::exception& error) {
    throw IoError(
        file, fmt::format("is no record of a run ({}): remove it to run it again", error.what()));
  }
  record.trajectory = ReadTumTrajectory(TrajectoryFile(file));
  return record;
}

std::vector<RunRecord> MergeRecords(const std::vector<std::filesystem::path>& sweeps,
                                    const std::vector<std::string>& sequences) {
  std::map<std::filesystem::path, RunRecord> records;  // by their names
  for (const std::filesystem::path& sweep : sweeps) {
    for (const std::filesystem::path& file : RecordFiles(sweep / "runs")) {
      RunRecord record = ReadRecord(file);
      const std::string& sequence = record.key.sequence;
      if (!sequences.empty() && std::ranges::find(sequences, sequence) == sequences.end()) continue;
      const auto [at, added] = records.try_emplace(NameOf(record.key), std::move(record));
      if (!added) throw IoError(file, "is in another of the sweeps as well: leave one out");
    }
  }
  if (records.empty()) throw IoError(sweeps.front() / "runs", "holds no run of these sequences");
  std::vector<RunRecord> merged;
  for (auto& [name, record] : records) merged.push_back(std::move(record));
  return merged;
}

}  // namespace highwall::bench
