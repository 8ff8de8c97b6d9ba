// highwall_bench_tum: accuracy and speed of the SLAM system on sequences that `highwall slam`
// accepts, and on generated ones. Each runs with each setting, several times; the table contains
// medians. "track" is features, matching and pose of a frame, "frame" its wall time with keyframes,
// loops and waits, "cpu" the processor time of all threads for a frame. Times are also given
// relative to cv::ORB::detectAndCompute on the same images, measured before and after each run.
// With
// --paired, two settings are
// compared with each other instead (paired.h); "merge" creates the tables of stored runs, "figures"
// compares with a file of figures (figures.h).
#include <CLI/App.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "bench_main.h"
#include "cli/option_checks.h"
#include "cli/stop_signals.h"
#include "figures.h"
#include "paired.h"
#include "paper_tables.h"
#include "run/process_memory.h"
#include "sweep.h"
#include "sweep_report.h"
#include "sweep_tables.h"

namespace highwall::bench {
namespace {

struct ReportArguments {
  std::string data;
  std::vector<std::string> sequences;
  std::vector<std::string> references;  // NAME=DIR
  std::string out;
  bool json = false, markdown = false, no_times = false, paper = false;
  MoreColumns more;
};

struct BenchArguments {
  ReportArguments report;
  std::vector<std::string> features{"points", "lines", "both"};
  std::vector<std::string> settings;  // NAME=SWITCHES
  std::vector<std::string> scenes;
  std::optional<double> duration;  // [s]
  double fps = SequenceOptions().fps;
  double scale = SequenceOptions().scale;
  int seeds = 1;
  int runs = 5;
  std::string shard = "1/1";
  bool dense = false;
  bool deterministic = false;
  double live_rate = 1.0;  // of more.live
  bool paired = false;
  std::pair<std::string, std::string> pair;  // of --paired
  std::string program;
  std::size_t step = PairedArguments().step;
};

// "NAME=SWITCHES".
NamedSetting ParseNamedSetting(const std::string& text) {
  constexpr const char* kOfNames =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.+";
  const std::size_t sign = text.find('=');
  const std::string name = text.substr(0, sign);
  if (sign == std::string::npos || name.empty() ||
      name.find_first_not_of(kOfNames) != std::string::npos || name.front() == '.') {
    throw CLI::ValidationError(
        "--setting", "must be NAME=SWITCHES, the name of letters, digits and -_.+, is " + text);
  }
  return {name, text.substr(sign + 1)};
}

std::vector<NamedSetting> SettingsOf(const BenchArguments& arguments) {
  if (arguments.report.paper) return PaperSettings();
  std::vector<NamedSetting> settings;
  for (const std::string& text : arguments.settings) settings.push_back(ParseNamedSetting(text));
  if (settings.empty()) {
    for (const std::string& name : arguments.features) {
      settings.push_back({name, "--features " + name});
    }
  }
  for (NamedSetting& setting : settings) {
    setting.map = arguments.dense ? MapChoice::kDefault : MapChoice::kNone;
  }
  return settings;
}

SweepPlan PlanOf(const BenchArguments& arguments) {
  SweepPlan plan{.data = arguments.report.data,
                 .sequences = arguments.report.sequences,
                 .scenes = {},
                 .seeds = arguments.seeds,
                 .settings = SettingsOf(arguments),
                 .runs = arguments.runs,
                 .synchronous = arguments.deterministic,
                 .live_rate = arguments.report.more.live ? arguments.live_rate : 0.0,
                 .out = arguments.report.out,
                 .shard = ParseShard(arguments.shard)};
  for (const std::string& scene : arguments.scenes) {
    plan.scenes.push_back({.scene = scene,
                           .duration = arguments.duration.value_or(DefaultDuration(scene)),
                           .fps = arguments.fps,
                           .scale = arguments.scale});
  }
  return plan;
}

ReportOptions ReportOptionsOf(const ReportArguments& arguments) {
  ReportOptions options;
  if (arguments.json) options.format = ReportFormat::kJson;
  if (arguments.markdown || arguments.paper) options.format = ReportFormat::kMarkdown;
  options.times = !arguments.no_times;
  options.unit = arguments.more.unit;
  options.paper = arguments.paper;
  for (const std::string& text : arguments.references) {
    options.references.push_back(ParseReference(text));
  }
  options.data = arguments.data;
  options.out = arguments.out;
  return options;
}

void Run(const BenchArguments& arguments) {
  const ReportOptions options = ReportOptionsOf(arguments.report);
  const bool text = options.format == ReportFormat::kText;
  SweepPlan plan = PlanOf(arguments);
  const apps::StopSignals signals;
  plan.stop = [&signals] { return signals.caught() != 0; };
  const MoreColumns& more = arguments.report.more;
  if (text) fmt::print("{}", TextHeader(more));
  const std::vector<RunRecord> records = RunSweep(plan, [&](const std::vector<RunRecord>& group) {
    if (!text) return;
    fmt::print("{}", TextLine(MakeRow(group), more));
    std::fflush(stdout);
  });
  const bool has_tables = plan.shard.count == 1 && !records.empty();  // a shard has none
  if (has_tables) Report(records, options);
  if (plan.stop()) throw apps::StoppedBySignal(signals.caught());
}

void Merge(const std::vector<std::string>& sweeps, const ReportArguments& arguments) {
  const std::vector<RunRecord> records =
      MergeRecords({sweeps.begin(), sweeps.end()}, arguments.sequences);
  const ReportOptions options = ReportOptionsOf(arguments);
  if (options.format == ReportFormat::kText) {
    MoreColumns more = arguments.more;
    more.live = std::ranges::any_of(
        records, [](const RunRecord& record) { return record.key.live_rate > 0.0; });
    fmt::print("{}", TextHeader(more));
    for (const SweepRow& row : MakeRows(records)) fmt::print("{}", TextLine(row, more));
  }
  Report(records, options);
}

// Compares two settings instead of several features. They are checked with the command line.
CLI::Option* AddPairedOptions(CLI::App& app, BenchArguments& arguments) {
  CLI::Option* paired =
      app.add_option("--paired", arguments.pair,
                     "Run two settings against each other, --runs times from beginnings --step "
                     "frames apart, in synchronous mode: the options of highwall slam of each, "
                     "\"\" for none")
          ->type_name("A B");
  app.add_option("--paired-program", arguments.program,
                 "The highwall of another build, which runs B")
      ->check(apps::NotEmpty())
      ->needs(paired);
  app.add_option("--step", arguments.step, "Frames from one beginning of --paired to the next")
      ->check(apps::Between(1.0, 1e6))
      ->needs(paired)
      ->capture_default_str();
  return paired;
}

CLI::Validator IsReference() {
  return {[](const std::string& text) -> std::string {
            try {
              ParseReference(text);
              return "";
            } catch (const InvalidArgument& error) {
              return error.what();
            }
          },
          "NAME=DIR"};
}

CLI::Validator IsShard() {
  return {[](const std::string& text) -> std::string {
            try {
              ParseShard(text);
              return "";
            } catch (const InvalidArgument& error) {
              return error.what();
            }
          },
          "N/COUNT"};
}

// Adds the options of both a sweep and a merge of sweeps. Returns those that --paired does not use.
std::vector<CLI::Option*> AddReportOptions(CLI::App& app, ReportArguments& arguments) {
  CLI::Option* json = app.add_flag("--json", arguments.json, "Print one JSON object");
  CLI::Option* markdown =
      app.add_flag("--markdown", arguments.markdown, "Print the table as Markdown")->excludes(json);
  return {
      app.add_option("--out", arguments.out,
                     "Folder that keeps each run, to continue where an earlier sweep ended, and "
                     "figures.json, runs.csv, table.md")
          ->check(apps::NotEmpty()),
      app.add_option("--reference", arguments.references,
                     "Compare with another system's trajectories on the same frames: "
                     "DIR/SEQUENCE_*.txt, one a run")
          ->check(IsReference()),
      markdown,
      app.add_flag("--no-times", arguments.no_times,
                   "Without what depends on the machine: times and memory")
          ->needs(markdown),
      app.add_flag("--unit", arguments.more.unit,
                   "Show the processor time of a frame in units of cv::ORB::detectAndCompute too, "
                   "measured before and after each run"),
      app.add_flag("--paper", arguments.paper,
                   "Tables 1, 2 and 4 of the paper: points, points and lines, and the paper's "
                   "own settings")
          ->excludes(json)};
}

// Adds the options of generated sequences.
std::vector<CLI::Option*> AddSceneOptions(CLI::App& app, BenchArguments& arguments) {
  CLI::Option* scenes = AddList(app, "--scenes", arguments.scenes, SceneNames(),
                                ": generated in --data, where they are not there");
  app.add_option("--seeds", arguments.seeds, "Sequences of each scene")
      ->check(apps::Between(1.0, 1000.0))
      ->needs(scenes);
  app.add_option("--duration", arguments.duration, "Of a scene [s], else a lap")
      ->check(apps::Between(1.0, 3600.0))
      ->needs(scenes);
  app.add_option("--fps", arguments.fps, "Of the scenes")
      ->check(apps::Between(1.0, 240.0))
      ->needs(scenes)
      ->capture_default_str();
  app.add_option("--scale", arguments.scale, "Of the sides of the images of the scenes")
      ->check(apps::Between(0.1, 4.0))
      ->needs(scenes)
      ->capture_default_str();
  return {scenes};
}

void CheckArguments(BenchArguments& arguments, const CLI::Option* paired) {
  if (arguments.report.sequences.empty() && arguments.scenes.empty()) {
    throw CLI::RequiredError("--sequences or --scenes");
  }
  arguments.paired = paired->count() > 0;
  if (!arguments.paired) {
    for (const NamedSetting& setting : SettingsOf(arguments)) {
      RequireSetting(setting.name, setting.switches,
                     {.synchronous = arguments.deterministic,
                      .map = setting.map,
                      .live_rate = arguments.report.more.live ? arguments.live_rate : 0.0});
    }
    return;
  }
  RequireSetting("A", arguments.pair.first);
  if (arguments.program.empty()) RequireSetting("B", arguments.pair.second);
}

void AddOptions(CLI::App& app, BenchArguments& arguments) {
  app.add_option("--data", arguments.report.data, "Folder that holds the sequences")->required();
  app.add_option("--sequences", arguments.report.sequences, "Folders in it, separated by commas")
      ->delimiter(',');
  app.add_option("--runs", arguments.runs, "Runs of each")->check(CLI::PositiveNumber);
  CLI::Option* settings = app.add_option("--setting", arguments.settings,
                                         "NAME=SWITCHES, what one would write behind highwall "
                                         "slam; may be given several times")
                              ->type_name("NAME=SWITCHES")
                              ->take_all();
  CLI::Option* features =
      AddList(app, "--features", arguments.features, {"points", "lines", "both"})
          ->excludes(settings);
  CLI::Option* dense =
      app.add_flag("--dense", arguments.dense, "Build cloud, octree and grid as well");
  CLI::Option* shard = app.add_option("--shard", arguments.shard,
                                      "Run only this part of the sweep: 2/4, the second of four")
                           ->check(IsShard());
  CLI::Option* deterministic = app.add_flag("--deterministic", arguments.deterministic,
                                            "Synchronous mode: everything on one thread");
  CLI::Option* live = app.add_flag("--live", arguments.report.more.live,
                                   "At the pace of the stamps: frames that come too fast are "
                                   "dropped and counted, and the delay of the poses is measured")
                          ->excludes(deterministic);
  app.add_option("--rate", arguments.live_rate, "Of the pace of the stamps; 2: twice as fast")
      ->check(apps::Between(0.1, 10.0))
      ->needs(live)
      ->capture_default_str();
  CLI::Option* paired = AddPairedOptions(app, arguments);
  for (CLI::Option* other : AddReportOptions(app, arguments.report)) other->excludes(paired);
  for (CLI::Option* other : AddSceneOptions(app, arguments)) other->excludes(paired);
  for (CLI::Option* other : {settings, features, dense, shard, live}) other->excludes(paired);
  app.callback([&arguments, paired] { CheckArguments(arguments, paired); });
  app.footer(
      "Examples:\n"
      "  highwall_bench_tum --data datasets --sequences fr1_xyz,fr3_teddy --runs 5 --out sweep\n"
      "  highwall_bench_tum merge sweep --markdown\n"
      "  highwall_bench_tum --data datasets --sequences fr1_xyz --paired \"\" \"--no-loops\"\n"
      "  highwall_bench_tum figures tests/expected/figures.json");
}

void RunEither(const BenchArguments& arguments) {
  if (!arguments.paired) return Run(arguments);
  RunPaired({.data = arguments.report.data,
             .sequences = arguments.report.sequences,
             .settings = arguments.pair,
             .program = arguments.program,
             .pairs = arguments.runs,
             .step = arguments.step,
             .json = arguments.report.json});
}

int MainOfMerge(int argc, char** argv) {
  const BenchName name{"highwall_bench_tum merge", "The tables of sweeps that were kept by --out."};
  std::vector<std::string> sweeps;
  ReportArguments arguments;
  return RunBench(
      name, argc, argv,
      [&](CLI::App& app) {
        app.add_option("sweeps", sweeps, "Folders of --out, all of one sweep or of several")
            ->required();
        app.add_option("--data", arguments.data,
                       "Folder that holds the sequences, for --reference");
        app.add_option("--sequences", arguments.sequences, "Of these alone, separated by commas")
            ->delimiter(',');
        AddReportOptions(app, arguments);
      },
      [&] { Merge(sweeps, arguments); });
}

int MainOfFigures(int argc, char** argv) {
  const BenchName name{"highwall_bench_tum figures",
                       "Figures of generated sequences against those in a file; exits with 3 where "
                       "one has moved."};
  std::string file, data;
  bool renew = false;
  return RunBench(
      name, argc, argv,
      [&](CLI::App& app) {
        app.add_option("file", file, "Such as tests/expected/figures.json")->required();
        app.add_option("--data", data, "Keep the sequences in this folder");
        app.add_flag("--renew", renew, "Write what was measured to the file");
      },
      [&] {
        if (!CheckFigures(file, data, renew)) throw std::runtime_error("figures have moved");
      });
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  highwall::apps::LimitHeaps();
  const std::string_view command = argc > 1 ? argv[1] : "";
  if (command == "merge") return MainOfMerge(argc - 1, argv + 1);
  if (command == "figures") return MainOfFigures(argc - 1, argv + 1);
  const BenchName name{"highwall_bench_tum",
                       "Accuracy and speed of Highwall on sequences. Also: highwall_bench_tum "
                       "merge --help, highwall_bench_tum figures --help."};
  return RunBench<BenchArguments>(name, argc, argv, AddOptions, RunEither);
}
