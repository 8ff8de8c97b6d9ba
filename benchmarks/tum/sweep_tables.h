#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "sweep_record.h"

// The runs of a sweep as tables: for people, for Markdown, CSV and JSON.
namespace highwall::bench {

// The runs of one sequence with one setting, over all seeds: a row.
struct SweepRow {
  std::string sequence, setting;
  std::vector<RunRecord> runs;
  Scores median;
  Scores low, high;                                 // over the runs
  std::map<std::string, std::size_t> loss_reasons;  // frames of all runs
};

SweepRow MakeRow(std::vector<RunRecord> runs);
// Rows in the order in which their first runs come.
std::vector<SweepRow> MakeRows(const std::vector<RunRecord>& records);

// On a terminal.
std::string TextHeader();
std::string TextLine(const SweepRow& row);
// {"sequences": {SEQUENCE: {SETTING: {"switches", "median", "low", "high", "loss_reasons",
// "runs"}}}}
nlohmann::json ToJson(const std::vector<SweepRow>& rows);
// times: what depends on the machine and on what else it does as well, times and memory.
std::string ToMarkdown(const std::vector<SweepRow>& rows, bool times = true);
// A line a run.
std::string ToCsv(const std::vector<SweepRow>& rows);

// figures.json (`report`), runs.csv and table.md in `folder`. Throws IoError.
void WriteTables(const std::filesystem::path& folder, const nlohmann::json& report,
                 const std::vector<SweepRow>& rows, const std::string& markdown);

}  // namespace highwall::bench
