// highwall merge: merges finished runs of one place into one map with trajectories in one world.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/json_text.h"
#include "run/folder_lock.h"
#include "run/merged_run.h"
#include "run/output_checks.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

struct MergeArguments {
  std::vector<std::string> runs;
  std::string out;
  bool overwrite = false;
  bool json = false;
};

// Returns the canonical path; missing parts are kept as they are.
fs::path Real(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::weakly_canonical(fs::absolute(path), error);
  return real.has_filename() ? real : real.parent_path();
}

bool IsWithin(const fs::path& inner, const fs::path& outer) {
  const auto end = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first;
  return end == outer.end();
}

// The inputs must not be overwritten.
void RequireApart(const MergeArguments& arguments) {
  const fs::path out = Real(arguments.out);
  std::map<fs::path, std::string> seen;
  for (const std::string& run : arguments.runs) {
    const fs::path path = Real(run);
    const auto [same, is_new] = seen.emplace(path, run);
    if (!is_new) {
      throw InvalidArgument(fmt::format("{} is given twice{}", run,
                                        same->second == run ? "" : ", as " + same->second));
    }
    if (IsWithin(out, path)) {
      throw InvalidArgument(
          fmt::format("--out {} is {} {}, which is to be merged: choose another "
                      "folder",
                      arguments.out, out == path ? "the run" : "in the run", run));
    }
    if (fs::is_regular_file(path) && out / kMapFile == path) {
      throw InvalidArgument(
          fmt::format("--out {} holds {}, which is to be merged: choose another "
                      "folder",
                      arguments.out, run));
    }
  }
}

// Returns the reason why runs were not merged, if known: the last test that rejected a loop.
std::string WhyApart(const MergedRuns& runs, std::size_t run) {
  const auto is_of = [&](const LoopReport& report) {
    const std::size_t a = runs.RunOf(report.loop.edge.match);
    const std::size_t b = runs.RunOf(report.loop.edge.keyframe);
    return !report.accepted && a != b && (a == run || b == run);
  };
  const auto& loops = runs.merged.loops;
  const auto count = std::ranges::count_if(loops, is_of);
  if (count == 0) return "no place of it was recognized in another";
  const auto last = std::find_if(loops.rbegin(), loops.rend(), is_of);
  return fmt::format("{} {} rejected, the last because: {}", count,
                     count == 1 ? "place was" : "places were", last->message);
}

void PrintSummary(const MergedRuns& runs, const nlohmann::json& report, const std::string& out) {
  const Map& map = runs.merged.map;
  fmt::print("runs        {}\n", runs.runs.size());
  for (std::size_t i = 0; i < runs.sessions.size(); ++i) {
    const Session& session = runs.sessions[i];
    fmt::print("            {}: {} frames in {}{}\n", session.name, session.frames.size(),
               fmt::join(report["runs"][i]["trajectories"].get<std::vector<std::string>>(), ", "),
               session.left_out > 0
                   ? fmt::format(", {} without a keyframe left out", session.left_out)
                   : "");
  }
  const nlohmann::json& loops = report["loops"];
  fmt::print("merges      {} of submaps\n", loops["merges"].get<std::size_t>());
  fmt::print("loops       {} closed, {} rejected\n", loops["closed"].get<std::size_t>(),
             loops["refused"].get<std::size_t>());
  fmt::print("map         {} keyframes, {} points, {} lines\n", map.num_keyframes(),
             map.num<MapPoint>(), map.num<MapLine>());
  fmt::print("submaps     {}\n", runs.worlds.size() == 1
                                     ? "one: all keyframes share a world"
                                     : fmt::format("{} separate worlds", runs.worlds.size()));
  for (std::size_t run = 0; run < runs.runs.size(); ++run) {
    if (runs.worlds.empty() || runs.IsIn(run, runs.worlds.front())) continue;
    fmt::print("apart       {}: {}\n", runs.runs[run].path.string(), WhyApart(runs, run));
  }
  if (!runs.worlds.empty() &&
      runs.worlds.front().in_one_file.size() < report["submaps"][0]["runs"].size()) {
    fmt::print("stamps      of the runs overlap: trajectory.txt is that of {}\n",
               runs.sessions[runs.worlds.front().in_one_file.front()].name);
  }
  fmt::print("results in  {}\n", out);
}

int RunMerge(const MergeArguments& arguments) {
  RequireApart(arguments);
  RequireRunFolder(arguments.out, arguments.overwrite);
  const FolderLock lock(arguments.out);
  std::vector<FinishedRun> runs;
  for (const std::string& run : arguments.runs) runs.push_back(ReadFinishedRun(run));
  MergedRuns merged;
  {
    Progress progress("merging");
    merged = MergeRuns(std::move(runs),
                       [&](std::size_t done, std::size_t total) { progress.Update(done, total); });
  }
  const nlohmann::json report = [&] {
    const Progress progress("writing the results");
    return WriteMergedRuns(arguments.out, merged);
  }();
  if (arguments.json) {
    fmt::print("{}\n", JsonText(report));
  } else {
    PrintSummary(merged, report, arguments.out);
  }
  return kExitOk;
}

}  // namespace

void AddMergeCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<MergeArguments>();
  CLI::App* command = app.add_subcommand(
      "merge", "Merge finished runs of one place, with one camera, into one map");
  command
      ->add_option("runs", arguments->runs,
                   "Folders of runs (highwall slam --out), of merged runs, or maps of --save-map")
      ->required();
  command->add_option("--out", arguments->out, "Folder for the map and the trajectories")
      ->required()
      ->check(NotEmpty());
  command->add_flag("--overwrite", arguments->overwrite, kOverwriteHelp);
  command->add_flag("--json", arguments->json, "Print the report as one JSON object");
  command->footer(
      "Example:\n  highwall merge monday tuesday --out office\n"
      "writes map.hwmap (for highwall slam --load-map), trajectory_run1.txt of monday and\n"
      "trajectory_run2.txt of tuesday in one world, and run.json. A run that overlaps no other\n"
      "keeps a world of its own, in files numbered _2 and so on, and the summary states the "
      "reason.");
  command->callback([arguments, &action] {
    if (arguments->runs.size() < 2) {
      throw CLI::ValidationError("runs", "two runs or more are needed to merge them");
    }
    action = [arguments] { return RunMerge(*arguments); };
  });
}

}  // namespace highwall::apps
