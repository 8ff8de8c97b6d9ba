// highwall_bench_robustness: real sequences with simulated degradations: frames without a pose,
// maps, merges and errors, one table per sequence, compared with the original sequence.
#include <CLI/App.hpp>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/open_dataset.h>

#include "abuses.h"
#include "bench_main.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/json_text.h"
#include "medians.h"
#include "run/config.h"
#include "run/run_report.h"
#include "scores.h"

namespace highwall::bench {
namespace {

struct Arguments {
  std::vector<std::string> datasets;
  std::string second, only, json;
  std::uint64_t seed = 1;
  int runs = 1;
  std::size_t max_frames = SIZE_MAX;
  bool parallel = false;
};

RgbdSensor SensorOf(const std::filesystem::path& directory) {
  return apps::ResolveConfig("", directory).config.sensor;
}

std::string Label(const std::filesystem::path& directory) {
  const std::filesystem::path whole = std::filesystem::absolute(directory).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

// Runs of one abuse, or the reason for their failure.
struct Row {
  std::string name;
  std::vector<AbuseScores> runs;
  Scores median;
  std::optional<double> ratio;  // of the error to that of the untouched sequence
  std::string failure;
};

Row RunAll(const Abuse& abuse, const std::string& label, const Dataset& images,
           const RgbdSensor& sensor, const Arguments& arguments) {
  Row row{.name = abuse.name, .runs = {}, .median = {}, .ratio = {}, .failure = {}};
  std::vector<Scores> figures;
  try {
    for (int i = 0; i < arguments.runs; ++i) {
      apps::Progress progress(fmt::format("{} {}", label, abuse.name));
      const AbusedSequence sequence(FramesOf(images, arguments.max_frames), abuse,
                                    arguments.seed + static_cast<std::uint64_t>(i));
      row.runs.push_back(
          RunAbused(sequence, sensor, !arguments.parallel,
                    [&](std::size_t done, std::size_t total) { progress.Update(done, total); }));
      figures.push_back(row.runs.back().figures);
    }
    row.median = Medians(figures);
  } catch (const std::exception& error) {  // continues with the other abuses
    row.failure = error.what();
  }
  return row;
}

std::optional<double> Find(const Scores& scores, const std::string& figure) {
  const auto found = scores.find(figure);
  return found != scores.end() ? std::optional(found->second) : std::nullopt;
}

std::string Cell(const char* format, const std::optional<double>& value) {
  return value ? fmt::format(fmt::runtime(format), *value) : "-";
}

void PrintHeader(const std::string& label) {
  fmt::print(
      "### {}\n\n"
      "| abuse | frames | without a pose | the first | maps | merges | APE RMSE | over untouched | "
      "drift |\n|---|---|---|---|---|---|---|---|---|\n",
      label);
}

void PrintRow(const Row& row) {
  if (!row.failure.empty()) {
    fmt::print("| {} | failed: {} | | | | | | | |\n", row.name, row.failure);
  } else {
    const Scores& figures = row.median;
    std::string frames = fmt::format("{}", figures.at("frames"));
    if (figures.at("elsewhere") > 0.0) {
      frames += fmt::format(" + {} elsewhere", figures.at("elsewhere"));
      if (const auto taken = Find(figures, "elsewhere_taken_home"); taken && *taken > 0.0) {
        frames += fmt::format(" ({} taken for home)", *taken);
      }
    }
    const auto ape = Find(figures, "ape_rmse_m"), drift = Find(figures, "drift_m_per_m");
    fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", row.name, frames,
               figures.at("without_pose"), Cell("{}", Find(figures, "first_without_pose")),
               figures.at("maps"), figures.at("merges"),
               ape ? fmt::format("{:.1f} mm", 1e3 * *ape) : "-", Cell("{:.2f}", row.ratio),
               drift ? fmt::format("{:.1f} mm/m", 1e3 * *drift) : "-");
  }
  std::fflush(stdout);
}

nlohmann::ordered_json ToJson(const Row& row) {
  nlohmann::ordered_json json;
  if (!row.failure.empty()) {
    json["failure"] = row.failure;
    return json;
  }
  json["median"] = row.median;
  if (row.ratio) json["median"]["ape_over_untouched"] = *row.ratio;
  for (const AbuseScores& run : row.runs) {
    nlohmann::ordered_json figures = run.figures;
    figures["reasons"] = run.reasons;
    json["runs"].push_back(std::move(figures));
  }
  return json;
}

// Returns the rows of one sequence in their order, untouched first.
nlohmann::ordered_json RunSequence(const std::filesystem::path& directory,
                                   const Arguments& arguments, int* failures) {
  const RgbdSensor sensor = SensorOf(directory);
  const std::unique_ptr<const Dataset> images = OpenDataset(directory, sensor);
  if (images->groundtruth() == nullptr) {
    throw IoError(directory / "groundtruth.txt", "is missing or empty; errors need it");
  }
  std::unique_ptr<const Dataset> second;
  if (!arguments.second.empty()) {
    RgbdSensor other = SensorOf(arguments.second);
    other.camera = sensor.camera;
    second = OpenDataset(arguments.second, other);
    if (second->size() < 2) throw IoError(arguments.second, "must have two frames or more");
  }
  const std::regex wanted(arguments.only);
  const std::string label = Label(directory);
  PrintHeader(label);
  nlohmann::ordered_json json;
  std::optional<double> untouched;
  for (const Abuse& abuse : AllAbuses(second.get())) {
    const bool first = json.empty();
    if (!first && !std::regex_search(abuse.name, wanted)) continue;
    Row row = RunAll(abuse, label, *images, sensor, arguments);
    const std::optional<double> ape = Find(row.median, "ape_rmse_m");
    if (first) untouched = ape;
    if (ape && untouched) row.ratio = *ape / *untouched;
    if (!row.failure.empty()) ++*failures;
    PrintRow(row);
    json[row.name] = ToJson(row);
  }
  fmt::print("\n");
  return json;
}

void Write(const std::filesystem::path& path, const nlohmann::ordered_json& report) {
  AtomicFile file(path);
  file.stream() << apps::JsonText(report, 2) << '\n';
  file.Commit();
}

void RequireDifferentNames(const std::vector<std::string>& datasets) {
  std::set<std::string> names;
  for (const std::string& dataset : datasets) {
    if (!names.insert(Label(dataset)).second) {
      throw IoError(dataset, "has the name of another dataset; run them apart");
    }
  }
}

void Bench(const Arguments& arguments) {
  RequireDifferentNames(arguments.datasets);
  if (!arguments.json.empty()) AtomicFile{arguments.json};  // fails early if it cannot be written
  nlohmann::ordered_json report;
  report["versions"] = apps::VersionsJson();
  report["seed"] = arguments.seed;
  report["runs"] = arguments.runs;
  int failures = 0;
  for (const std::string& dataset : arguments.datasets) {
    report["sequences"][Label(dataset)] = RunSequence(dataset, arguments, &failures);
    if (!arguments.json.empty()) Write(arguments.json, report);
  }
  if (failures > 0) throw std::runtime_error(fmt::format("{} rows of the tables", failures));
}

CLI::Validator RegularExpression() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        try {
          const std::regex regex(text);
          return "";
        } catch (const std::regex_error& error) {
          return "'" + text + "' is no regular expression: " + error.what();
        }
      },
      "REGEX");
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--dataset", arguments.datasets,
                 "Folder in the layout of TUM RGB-D, with groundtruth.txt and a known calibration; "
                 "may be given again")
      ->check(apps::NotEmpty())
      ->required();
  app.add_option("--second", arguments.second,
                 "Another place, with images of the same size: where a kidnapped camera is taken; "
                 "without it none is")
      ->check(apps::NotEmpty());
  app.add_option("--only", arguments.only,
                 "The abuses whose names hold a match of this; the sequence untouched comes anyway")
      ->check(RegularExpression());
  app.add_option("--seed", arguments.seed, "Of everything random")->capture_default_str();
  app.add_option("--runs", arguments.runs, "Runs of each, a seed each; the table has their medians")
      ->check(apps::Between(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--max-frames", arguments.max_frames, "The first frames of each dataset alone")
      ->check(apps::Between(2.0, 1e9));
  app.add_option("--json", arguments.json, "Also write every figure of every run to this file")
      ->check(apps::NotEmpty());
  app.add_flag("--parallel", arguments.parallel,
               "Map and close loops on threads of their own: no run is like another");
  app.footer(
      "Example: highwall_bench_robustness --dataset fr1_xyz --second fr3_teddy --only 'depth' "
      "--json table.json");
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  const BenchName name{"highwall_bench_robustness",
                       "Recordings spoiled on purpose, against themselves untouched."};
  return RunBench<Arguments>(name, argc, argv, AddOptions, Bench);
}
