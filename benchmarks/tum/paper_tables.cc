#include "paper_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/core.h>

namespace highwall::bench {
namespace {

constexpr const char* kStatistics[] = {"max_m",  "mean_m", "median_m", "min_m",
                                       "rmse_m", "sse_m2", "std_m"};

// A row as printed in the paper [m]: max, mean, median, min, RMSE, SSE, std; not all are known.
struct PrintedErrors {
  const char* sequence;
  const char* method;
  std::array<std::optional<double>, 7> values;
};

const std::vector<PrintedErrors>& PrintedAte() {
  static const std::vector<PrintedErrors> rows{
      {"fr2_desk_with_person",
       "ORB-SLAM3, by the paper",
       {{0.027522, 0.010691, 0.009721, 0.001821, 0.011777, 0.021496, 0.004938}}},
      {"fr2_desk_with_person",
       "the paper",
       {{0.018487, 0.005951, 0.005655, 0.001261, 0.006580, 0.006278, 0.002808}}}};
  return rows;
}

const std::vector<PrintedErrors>& PrintedRpe() {
  static const std::vector<PrintedErrors> rows{
      {"fr2_desk_with_person",
       "ORB-SLAM3, by the paper",
       {{{}, 0.004784, {}, {}, 0.005695, {}, {}}}},
      {"fr2_desk_with_person", "the paper", {{{}, 0.005585, {}, {}, 0.006751, {}, {}}}}};
  return rows;
}

struct PrintedSizes {
  const char* sequence;
  double cloud, octree;  // [MB]
};

constexpr PrintedSizes kPrintedSizes[] = {
    {"fr1_desk", 6.5, 0.0435},  {"fr1_xyz", 7.3, 0.0457},          {"fr2_xyz", 6.2, 0.0524},
    {"fr2_desk", 29.8, 0.2032}, {"fr3_long_office", 53.2, 0.3146}, {"fr3_walk_rpy", 5.5, 0.0368}};

std::string Cell(const std::optional<double>& value) {
  return value ? fmt::format(" {:.6f} |", *value) : " - |";
}

std::string ErrorRow(const std::string& sequence, const std::string& method,
                     const std::array<std::optional<double>, 7>& values) {
  std::string line = fmt::format("| {} | {} |", sequence, method);
  for (const std::optional<double>& value : values) line += Cell(value);
  const auto &rmse = values[4], &sse = values[5];
  const bool known = rmse && sse && *rmse > 0.0;  // SSE = n RMSE^2
  return line + (known ? fmt::format(" {:.0f} |\n", *sse / (*rmse * *rmse)) : " - |\n");
}

// error: "ape" or "rpe_1_frame".
std::string ErrorTable(const std::string& title, const std::string& error,
                       const std::vector<SweepRow>& rows,
                       const std::vector<PrintedErrors>& printed) {
  std::string text =
      title +
      "\n\n| sequence | method | max | mean | median | min | RMSE | SSE [m²] | std | "
      "errors |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SweepRow& row = rows[i];
    std::array<std::optional<double>, 7> values;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto figure = row.median.find(error + "_" + kStatistics[k]);
      if (row.median.contains(error + "_mean_m")) values[k] = figure->second;
    }
    text += ErrorRow(row.sequence, row.setting, values);
    if (i + 1 < rows.size() && rows[i + 1].sequence == row.sequence) continue;
    for (const PrintedErrors& other : printed) {
      if (PaperNameOf(row.sequence) == other.sequence) {
        text += ErrorRow(row.sequence, other.method, other.values);
      }
    }
  }
  return text;
}

std::string SizeRow(const std::string& sequence, const std::string& settings, double cloud,
                    double octree) {
  return fmt::format("| {} | {} | {:.1f} | {:.4f} | {:.0f} |\n", sequence, settings, cloud, octree,
                     cloud / octree);
}

std::string SizeTable(const std::vector<SweepRow>& rows) {
  std::string text =
      "Table 4: size of the map [MB]\n\n| sequence | settings | cloud | octree | cloud / octree |\n"
      "|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SweepRow& row = rows[i];
    const auto cloud = row.median.find("cloud_mb"), octree = row.median.find("octree_mb");
    if (cloud != row.median.end() && octree != row.median.end()) {
      text += SizeRow(row.sequence, row.setting, cloud->second, octree->second);
    }
    if (i + 1 < rows.size() && rows[i + 1].sequence == row.sequence) continue;
    for (const PrintedSizes& other : kPrintedSizes) {
      if (PaperNameOf(row.sequence) == other.sequence) {
        text += SizeRow(row.sequence, "the paper", other.cloud, other.octree);
      }
    }
  }
  return text;
}

void Replace(std::string& text, const std::string& from, const std::string& to) {
  if (const std::size_t at = text.find(from); at != std::string::npos) {
    text.replace(at, from.size(), to);
  }
}

}  // namespace

std::vector<NamedSetting> PaperSettings() {
  return {{"points", "--features points", MapChoice::kDefault},
          {"points_and_lines", "", MapChoice::kDefault},
          {"as_the_paper", "--weighting paper --line-detector lsd --line-outliers paper",
           MapChoice::kPaper}};
}

std::string PaperNameOf(const std::string& sequence) {
  std::string name = sequence;
  Replace(name, "rgbd_dataset_", "");
  Replace(name, "freiburg", "fr");
  Replace(name, "long_office_household", "long_office");
  Replace(name, "walking", "walk");
  return name;
}

std::string PaperTables(const std::vector<SweepRow>& rows) {
  return ErrorTable("Table 1: absolute trajectory error [m]", "ape", rows, PrintedAte()) + '\n' +
         ErrorTable("Table 2: relative pose error, frame to frame [m]", "rpe_1_frame", rows,
                    PrintedRpe()) +
         '\n' + SizeTable(rows);
}

}  // namespace highwall::bench
