#include "sweep_report.h"

#include <algorithm>
#include <cstdio>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "files/json_text.h"
#include "paper_tables.h"
#include "run/run_report.h"
#include "sweep_tables.h"

namespace highwall::bench {
namespace {

// Returns the maximum peak memory of all runs [MiB].
double PeakMemory(const std::vector<RunRecord>& records) {
  double peak = 0.0;
  for (const RunRecord& record : records) {
    peak = std::max(peak, record.figures.at("peak_memory_mib"));
  }
  return peak;
}

std::size_t MostRuns(const std::vector<SweepRow>& rows) {
  std::size_t most = 0;
  for (const SweepRow& row : rows) most = std::max(most, row.runs.size());
  return most;
}

}  // namespace

void Report(const std::vector<RunRecord>& records, const ReportOptions& options) {
  const std::vector<SweepRow> rows = MakeRows(records);
  const std::vector<Comparison> comparisons = CompareAll(rows, options.references, options.data);
  nlohmann::json json = ToJson(rows);
  json["versions"] = apps::VersionsJson();
  json["runs"] = MostRuns(rows);
  json["peak_memory_mib"] = PeakMemory(records);
  if (!comparisons.empty()) json["references"] = ToJson(comparisons);
  std::string markdown =
      options.paper ? PaperTables(rows) : ToMarkdown(rows, options.times, options.unit);
  const std::string against = comparisons.empty() ? "" : '\n' + ToMarkdown(comparisons);
  markdown += against;
  if (!options.out.empty()) WriteTables(options.out, json, rows, markdown);
  switch (options.format) {
    case ReportFormat::kJson:
      fmt::print("{}\n", apps::JsonText(json, 2));
      return;
    case ReportFormat::kMarkdown:
      fmt::print("{}", markdown);
      return;
    case ReportFormat::kText:
      fmt::print("medians of {} runs; peak memory {:.0f} MiB\n{}", MostRuns(rows),
                 PeakMemory(records), against);
  }
}

}  // namespace highwall::bench
