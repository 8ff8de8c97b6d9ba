#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "sweep_record.h"

// Runs of a sweep as tables: text, Markdown, CSV and JSON.
namespace highwall::bench {

// Runs of one sequence with one setting, over all seeds: a row.
struct SweepRow {
  std::string sequence, setting;
  std::vector<RunRecord> runs;
  Scores median;
  Scores low, high;                                 // over the runs
  std::map<std::string, std::size_t> loss_reasons;  // frames of all runs
};

SweepRow MakeRow(std::vector<RunRecord> runs);
// Returns the rows in the order of their first runs.
std::vector<SweepRow> MakeRows(const std::vector<RunRecord>& records);

// Columns of the text for a terminal beside those that are always there.
struct MoreColumns {
  bool unit = false;  // processor time in units of cv::ORB
  bool live = false;  // of runs in live mode: dropped frames, delays, errors of the causal poses
};

// Text for a terminal.
std::string TextHeader(const MoreColumns& more = {});
std::string TextLine(const SweepRow& row, const MoreColumns& more = {});
// Returns {"sequences": {SEQUENCE: {SETTING: {"switches", "median", "low", "high", "loss_reasons",
// "runs"}}}}.
nlohmann::json ToJson(const std::vector<SweepRow>& rows);
// times: include times and memory, which depend on the machine and its load. unit: with times,
// include the processor time in units of cv::ORB.
std::string ToMarkdown(const std::vector<SweepRow>& rows, bool times = true, bool unit = false);
// Returns one line per run.
std::string ToCsv(const std::vector<SweepRow>& rows);

// Writes figures.json (`report`), runs.csv and table.md to `folder`. Throws IoError.
void WriteTables(const std::filesystem::path& folder, const nlohmann::json& report,
                 const std::vector<SweepRow>& rows, const std::string& markdown);

}  // namespace highwall::bench
