#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reference.h"
#include "sweep_record.h"

// Printed and written output of a sweep.
namespace highwall::bench {

enum class ReportFormat { kText, kMarkdown, kJson };

struct ReportOptions {
  ReportFormat format = ReportFormat::kText;
  bool times = true;                        // the Markdown contains times and memory
  bool unit = false;                        // the tables contain processor time in units of cv::ORB
  bool paper = false;                       // the paper's tables instead of ours
  std::vector<ReferenceSystem> references;  // systems to compare with
  std::filesystem::path data;               // the folder of the sequences, for references
  std::filesystem::path out;                // figures.json, runs.csv, table.md; empty: no files
};

// Throws IoError.
void Report(const std::vector<RunRecord>& records, const ReportOptions& options);

}  // namespace highwall::bench
