#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reference.h"
#include "sweep_record.h"

// What is printed and written of the runs of a sweep.
namespace highwall::bench {

enum class ReportFormat { kText, kMarkdown, kJson };

struct ReportOptions {
  ReportFormat format = ReportFormat::kText;
  bool times = true;                        // the Markdown has times and memory
  bool paper = false;                       // the paper's tables instead of ours
  std::vector<ReferenceSystem> references;  // systems to compare with
  std::filesystem::path data;               // the folder that holds the sequences, for references
  std::filesystem::path out;                // figures.json, runs.csv, table.md; empty: no files
};

// Throws IoError.
void Report(const std::vector<RunRecord>& records, const ReportOptions& options);

}  // namespace highwall::bench
