// highwall posegraph: optimizes a pose graph.
#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/pose_graph.h>
#include <highwall/frontend/loops/option_table.h>
#include <highwall/internal/stopwatch.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/json_text.h"
#include "plots/posegraph_plot.h"

namespace highwall::apps {
namespace {

struct PoseGraphArguments {
  std::filesystem::path input;
  std::filesystem::path output;
  std::string initialization = "chordal";
  RobustLoops robust = RobustLoops::kNone;
  double max_loop_chi2 = 0.0;
  int max_iterations = PoseGraphOptions().solver.max_iterations;
  bool json = false;
  std::optional<std::filesystem::path> plot;
};

PoseGraphInitialization FindInitialization(const std::string& name) {
  static const std::map<std::string, PoseGraphInitialization> initializations = {
      {"given", PoseGraphInitialization::kGiven},
      {"odometry", PoseGraphInitialization::kOdometry},
      {"tree", PoseGraphInitialization::kTree},
      {"chordal", PoseGraphInitialization::kChordal}};
  return initializations.at(name);
}

void PrintJson(const PoseGraph& graph, const PoseGraphSummary& summary, double total_seconds) {
  nlohmann::ordered_json rejected = nlohmann::ordered_json::array();
  for (const RejectedLoop& loop : summary.rejected) {
    rejected.push_back({{"edge", loop.edge},
                        {"i", graph.edges[loop.edge].i},
                        {"j", graph.edges[loop.edge].j},
                        {"chi2", loop.chi2},
                        {"weight", loop.weight},
                        {"reason", loop.reason}});
  }
  const nlohmann::ordered_json json = {{"initial_chi2", summary.initial_chi2},
                                       {"final_chi2", summary.final_chi2},
                                       {"iterations", summary.iterations},
                                       {"solve_seconds", summary.seconds},
                                       {"total_seconds", total_seconds},
                                       {"status", ToString(summary.status)},
                                       {"components", summary.components},
                                       {"warnings", summary.warnings},
                                       {"rejected", rejected}};
  fmt::print("{}\n", JsonText(json));
}

void PrintText(const PoseGraphArguments& arguments, const PoseGraph& graph,
               const PoseGraphSummary& summary, double total_seconds) {
  constexpr std::size_t kShown = 10;
  std::size_t loops = 0;
  for (const PoseGraphEdge& edge : graph.edges) loops += edge.IsLoop();
  const auto priors = static_cast<std::size_t>(
      std::ranges::count(graph.edges, graph.world.value_or(-1), &PoseGraphEdge::i));
  fmt::print("{}: {} nodes, {} edges, {} of them loops, {}in {}\n", arguments.input.string(),
             graph.nodes.size() - (graph.world ? 1 : 0), graph.edges.size() - priors, loops,
             priors > 0 ? fmt::format("{} prior{}, ", priors, priors > 1 ? "s" : "") : "",
             graph.space == PoseGraphSpace::kSe2 ? "SE(2)" : "SE(3)");
  fmt::print("  chi2        {:.6g} -> {:.6g}{}\n", summary.initial_chi2, summary.final_chi2,
             summary.rejected.empty() ? "" : " without the rejected loops");
  fmt::print("  iterations  {}, {}\n", summary.iterations, ToString(summary.status));
  fmt::print("  seconds     {:.3f}, with initialization {:.3f}\n", summary.seconds, total_seconds);
  if (arguments.robust == RobustLoops::kNone) return;
  fmt::print("  rejected    {} of {} loops\n", summary.rejected.size(), loops);
  for (std::size_t k = 0; k < summary.rejected.size() && k < kShown; ++k) {
    const RejectedLoop& loop = summary.rejected[k];
    fmt::print("    {} - {}: {}\n", graph.edges[loop.edge].i, graph.edges[loop.edge].j,
               loop.reason);
  }
  if (summary.rejected.size() > kShown) {
    fmt::print("    and {} more: see --json\n", summary.rejected.size() - kShown);
  }
}

void WritePlot(const PoseGraphArguments& arguments, const PoseGraph& before, const PoseGraph& after,
               const PoseGraphSummary& summary) {
  WritePoseGraphPlot(
      *arguments.plot,
      {.title = arguments.input.filename().string(),
       .before = fmt::format("{}: chi2 {:.6g}", arguments.initialization, summary.initial_chi2),
       .after = fmt::format("solved: chi2 {:.6g}, {} loops rejected", summary.final_chi2,
                            summary.rejected.size())},
      before, after, summary);
}

int RunPoseGraph(const PoseGraphArguments& arguments) {
  PoseGraph graph = ReadG2o(arguments.input);
  if (graph.edges.empty())
    throw IoError(arguments.input, "holds no edges: there is nothing to solve");
  if (!graph.has_poses && arguments.initialization == "given") {
    throw IoError(arguments.input,
                  "holds no vertices: use --init odometry, tree or chordal instead of given");
  }
  const Stopwatch stopwatch;
  InitializePoseGraph(&graph, FindInitialization(arguments.initialization));
  const PoseGraph before = graph;
  PoseGraphOptions options{.robust = arguments.robust, .max_loop_chi2 = arguments.max_loop_chi2};
  options.solver.max_iterations = arguments.max_iterations;
  PoseGraphSummary summary;
  {
    Progress progress("solving");
    options.on_progress = [&progress](const PoseGraphProgress& state) {
      progress.Update(static_cast<std::size_t>(state.iterations));
    };
    summary = SolvePoseGraph(&graph, options);
  }
  const double total_seconds = stopwatch.Seconds();
  for (const std::string& warning : summary.warnings) {
    fmt::print(stderr, "highwall posegraph: warning: {}: {}\n", arguments.input.string(), warning);
  }
  if (summary.status == SolveStatus::kFailed) {
    fmt::print(stderr, "highwall posegraph: failed: {}\n", summary.message);
    return kExitFailed;
  }
  WriteG2o(arguments.output, graph);
  if (arguments.plot) WritePlot(arguments, before, graph, summary);
  if (arguments.json) {
    PrintJson(graph, summary, total_seconds);
  } else {
    PrintText(arguments, graph, summary, total_seconds);
  }
  return kExitOk;
}

}  // namespace

void AddPosegraphCommand(CLI::App& app, CommandAction& action) {
  CLI::App* command = app.add_subcommand(
      "posegraph", "Optimize a pose graph (g2o, SE(2) or SE(3)), and reject false loops if asked");
  const auto arguments = std::make_shared<PoseGraphArguments>();
  command->add_option("input", arguments->input, "g2o file, with or without vertices")->required();
  command->add_option("output", arguments->output, "g2o file of the same graph, solved")
      ->required();
  command->add_option("--init", arguments->initialization, "Initial poses")
      ->check(OneOf({"given", "odometry", "tree", "chordal"}))
      ->capture_default_str();
  AddChoice(
      command, "--robust", &arguments->robust, Named<RobustLoops>(kChoices<RobustLoops>),
      "How false loops are rejected; loops are the edges between ids that are not consecutive "
      "(default: none)");
  command
      ->add_option("--max-loop-chi2", arguments->max_loop_chi2,
                   "A loop with a larger chi-squared is false; 0: the 99.9 % quantile")
      ->check(CLI::Range(0.0, 1e12))
      ->capture_default_str();
  command
      ->add_option("--max-iterations", arguments->max_iterations,
                   "Iterations of each stage of the solution")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  command->add_flag("--json", arguments->json,
                    "One JSON object on standard output; total_seconds is initialization and "
                    "solution, without reading and writing");
  command->add_option("--plot", arguments->plot, "Draw the graph before and after: FILE.svg");
  command->footer(
      "Example:\n  highwall posegraph sphere.g2o solved.g2o --init chordal --robust gnc --plot "
      "sphere.svg");
  command->callback([arguments, &action] {
    if (arguments->plot && arguments->plot->extension() != ".svg") {
      throw CLI::ValidationError("--plot", "writes SVG: the name must end in .svg");
    }
    action = [arguments] { return RunPoseGraph(*arguments); };
  });
}

}  // namespace highwall::apps
