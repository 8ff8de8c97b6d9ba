#include "sweep_tables.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>

#include "files/json_text.h"

namespace highwall::bench {
namespace {

// Returns a text such as "10 blurred, 3 dark".
std::string LossText(const std::map<std::string, std::size_t>& reasons, const char* separator) {
  std::vector<std::string> parts;
  for (const auto& [reason, frames] : reasons)
    parts.push_back(fmt::format("{} {}", frames, reason));
  return fmt::format("{}", fmt::join(parts, separator));
}

// Returns a figure and, if the runs differ, their minimum and maximum.
std::string SpreadCell(const SweepRow& row, const std::string& figure, double factor, int digits) {
  const auto median = row.median.find(figure);
  const bool error = figure.ends_with("rmse_m");
  if (median == row.median.end() || (error && median->second <= 0.0)) return "";
  const auto text = [&](const Scores& scores) {
    return fmt::format("{:.{}f}", factor * scores.at(figure), digits);
  };
  const std::string low = text(row.low), high = text(row.high);
  return low == high ? text(row.median) : fmt::format("{} ({} to {})", text(row.median), low, high);
}

struct Column {
  const char* title;
  const char* figure;
  double factor;
  int digits;
  bool of_machine = false;
  bool of_unit = false;  // in units of cv::ORB
};

constexpr Column kMarkdownColumns[] = {
    {"APE RMSE [mm]", "ape_rmse_m", 1e3, 2},
    {"RPE RMSE, 1 frame [mm]", "rpe_1_frame_rmse_m", 1e3, 2},
    {"RPE RMSE, 30 frames [mm]", "rpe_30_frames_rmse_m", 1e3, 2},
    {"coverage", "coverage", 1.0, 3},
    {"lost", "lost_frames", 1.0, 0},
    {"causal APE RMSE [mm]", "causal_ape_rmse_m", 1e3, 2},
    {"dropped", "dropped_frames", 1.0, 0, true},
    {"delay, median [ms]", "delay_ms", 1.0, 1, true},
    {"delay, 99 % [ms]", "delay_p99_ms", 1.0, 0, true},
    {"frame, median [ms]", "frame_ms", 1.0, 1, true},
    {"frame, 95 % [ms]", "frame_p95_ms", 1.0, 0, true},
    {"frame, 99 % [ms]", "frame_p99_ms", 1.0, 0, true},
    {"frame, worst [ms]", "frame_worst_ms", 1.0, 0, true},
    {"processor, per frame [ms]", "processor_ms", 1.0, 1, true},
    {"processor, per frame [ORB]", "processor_over_orb", 1.0, 2, true, true},
    {"memory [MiB]", "peak_memory_mib", 1.0, 0, true},
    {"keyframes", "keyframes", 1.0, 0},
    {"points", "points", 1.0, 0},
    {"lines", "lines", 1.0, 0},
    {"cloud [MB]", "cloud_mb", 1.0, 1},
    {"octree [MB]", "octree_mb", 1.0, 4}};

struct TextColumn {
  const char* title;
  const char* figure;
  int width, digits;
  bool of_unit = false;  // in units of cv::ORB
  bool of_live = false;  // of live mode

  bool IsIn(const MoreColumns& more) const {
    return (more.unit || !of_unit) && (more.live || !of_live);
  }
};

constexpr TextColumn kTextColumns[] = {{"APE m", "ape_rmse_m", 8, 5},
                                       {"RPE1 m", "rpe_1_frame_rmse_m", 8, 5},
                                       {"RPE30 m", "rpe_30_frames_rmse_m", 8, 5},
                                       {"cover", "coverage", 6, 3},
                                       {"lost", "lost_frames", 5, 0},
                                       {"causal", "causal_ape_rmse_m", 8, 5, false, true},
                                       {"drop", "dropped_frames", 5, 0, false, true},
                                       {"delay", "delay_ms", 6, 1, false, true},
                                       {"delay 99", "delay_p99_ms", 8, 1, false, true},
                                       {"kf", "keyframes", 4, 0},
                                       {"track ms", "tracking_ms", 8, 2},
                                       {"track 99", "tracking_p99_ms", 8, 2},
                                       {"frame ms", "frame_ms", 8, 2},
                                       {"mean", "frame_mean_ms", 8, 2},
                                       {"frame 95", "frame_p95_ms", 8, 2},
                                       {"frame 99", "frame_p99_ms", 8, 2},
                                       {"worst", "frame_worst_ms", 8, 2},
                                       {"cpu ms", "processor_ms", 8, 2},
                                       {"cpu/ORB", "processor_over_orb", 8, 2, true},
                                       {"ORB ms", "orb_ms", 6, 2},
                                       {"ratio", "tracking_over_orb", 6, 2},
                                       {"MiB", "peak_memory_mib", 5, 0}};

// Returns the columns for which any row has a value.
std::vector<Column> UsedColumns(const std::vector<SweepRow>& rows, bool times, bool unit) {
  std::vector<Column> used;
  std::ranges::copy_if(kMarkdownColumns, std::back_inserter(used), [&](const Column& column) {
    if ((column.of_machine && !times) || (column.of_unit && !unit)) return false;
    return std::ranges::any_of(rows, [&](const SweepRow& row) {
      return !SpreadCell(row, column.figure, column.factor, column.digits).empty();
    });
  });
  return used;
}

std::string Quoted(std::string text) {
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) {
    text.insert(at, 1, '"');
  }
  return '"' + text + '"';
}

void WriteText(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.stream() << text;
  file.Commit();
}

}  // namespace

SweepRow MakeRow(std::vector<RunRecord> runs) {
  HIGHWALL_REQUIRE(!runs.empty(), "a row of no runs");
  SweepRow row{
      runs.front().key.sequence, runs.front().key.setting.name, std::move(runs), {}, {}, {}, {}};
  std::vector<Scores> figures;
  for (const RunRecord& run : row.runs) {
    figures.push_back(run.figures);
    for (const auto& [name, value] : run.figures) {
      const auto [low, first] = row.low.try_emplace(name, value);
      low->second = std::min(low->second, value);
      const auto high = row.high.try_emplace(name, value).first;
      high->second = std::max(high->second, value);
    }
    for (const auto& [reason, frames] : run.loss_reasons) row.loss_reasons[reason] += frames;
  }
  row.median = Medians(figures);
  return row;
}

std::vector<SweepRow> MakeRows(const std::vector<RunRecord>& records) {
  std::vector<std::vector<RunRecord>> groups;
  for (const RunRecord& record : records) {
    const auto group = std::ranges::find_if(groups, [&](const std::vector<RunRecord>& other) {
      return other.front().key.sequence == record.key.sequence &&
             other.front().key.setting.name == record.key.setting.name;
    });
    (group != groups.end() ? *group : groups.emplace_back()).push_back(record);
  }
  std::vector<SweepRow> rows;
  for (std::vector<RunRecord>& group : groups) rows.push_back(MakeRow(std::move(group)));
  return rows;
}

std::string TextHeader(const MoreColumns& more) {
  std::string line = fmt::format("{:<23} {:<16}", "sequence", "setting");
  for (const TextColumn& column : kTextColumns) {
    if (column.IsIn(more)) line += fmt::format(" {:>{}}", column.title, column.width);
  }
  return line + '\n';
}

std::string TextLine(const SweepRow& row, const MoreColumns& more) {
  std::string line = fmt::format("{:<23} {:<16}", row.sequence, row.setting);
  for (const TextColumn& column : kTextColumns) {
    if (!column.IsIn(more)) continue;
    const auto figure = row.median.find(column.figure);
    const std::string cell = figure == row.median.end()
                                 ? "-"  // of a run by an earlier version
                                 : fmt::format("{:.{}f}", figure->second, column.digits);
    line += fmt::format(" {:>{}}", cell, column.width);
  }
  line += '\n';
  if (!row.loss_reasons.empty()) {
    line += fmt::format("{:<23} {:<16} lost: {}\n", "", "", LossText(row.loss_reasons, ", "));
  }
  return line;
}

nlohmann::json ToJson(const std::vector<SweepRow>& rows) {
  nlohmann::json report;
  for (const SweepRow& row : rows) {
    nlohmann::json& entry = report["sequences"][row.sequence][row.setting];
    entry["switches"] = row.runs.front().key.setting.switches;
    entry["median"] = row.median;
    entry["low"] = row.low;
    entry["high"] = row.high;
    entry["loss_reasons"] = row.loss_reasons;
    for (const RunRecord& run : row.runs) {
      nlohmann::json& figures = entry["runs"].emplace_back(run.figures);
      if (run.key.seed > 0) figures["seed"] = run.key.seed;
    }
  }
  return report;
}

std::string ToMarkdown(const std::vector<SweepRow>& rows, bool times, bool unit) {
  const std::vector<Column> columns = UsedColumns(rows, times, unit);
  const bool losses =
      std::ranges::any_of(rows, [](const SweepRow& row) { return !row.loss_reasons.empty(); });
  std::string text = "| sequence | setting | runs |", rule = "|---|---|---|";
  for (const Column& column : columns) {
    text += fmt::format(" {} |", column.title);
    rule += "---|";
  }
  text += (losses ? " why lost |\n" + rule + "---|\n" : "\n" + rule + "\n");
  for (const SweepRow& row : rows) {
    text += fmt::format("| {} | {} | {} |", row.sequence, row.setting, row.runs.size());
    for (const Column& column : columns) {
      const std::string cell = SpreadCell(row, column.figure, column.factor, column.digits);
      text += fmt::format(" {} |", cell.empty() ? "-" : cell);
    }
    text += losses ? fmt::format(" {} |\n", LossText(row.loss_reasons, ", ")) : "\n";
  }
  return text;
}

std::string ToCsv(const std::vector<SweepRow>& rows) {
  std::set<std::string> figures;
  for (const SweepRow& row : rows) {
    for (const auto& [name, value] : row.median) figures.insert(name);
  }
  std::string text = fmt::format("sequence,seed,setting,switches,lockstep,run,{},loss_reasons\n",
                                 fmt::join(figures, ","));
  for (const SweepRow& row : rows) {
    for (const RunRecord& run : row.runs) {
      const RunKey& key = run.key;
      text += fmt::format("{},{},{},{},{:d},{}", Quoted(key.sequence), key.seed,
                          Quoted(key.setting.name), Quoted(key.setting.switches), key.synchronous,
                          key.run);
      for (const std::string& name : figures) {
        const auto figure = run.figures.find(name);
        text += figure == run.figures.end() ? "," : fmt::format(",{}", figure->second);
      }
      text += fmt::format(",{}\n", Quoted(LossText(run.loss_reasons, "; ")));
    }
  }
  return text;
}

void WriteTables(const std::filesystem::path& folder, const nlohmann::json& report,
                 const std::vector<SweepRow>& rows, const std::string& markdown) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw IoError(folder, "cannot be made: " + error.message());
  WriteText(folder / "figures.json", apps::JsonText(report, 2) + "\n");
  WriteText(folder / "runs.csv", ToCsv(rows));
  WriteText(folder / "table.md", markdown);
}

}  // namespace highwall::bench
