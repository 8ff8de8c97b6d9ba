// highwall eval: the error of an estimated trajectory against a reference.
#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

#include "commands.h"
#include "error_plot.h"
#include "explanation_report.h"
#include "option_checks.h"

namespace highwall::apps {
namespace {

struct EvalArguments {
  std::string metric;
  std::filesystem::path reference;
  std::filesystem::path estimate;
  std::string alignment;  // empty: se3 for ape, none for rpe
  std::string relation = "trans_part";
  double t_max_diff = 0.02;  // [s]
  double delta = 1.0;
  std::string delta_unit = "f";
  bool all_pairs = false;
  bool json = false;
  bool explain = false;
  std::optional<std::filesystem::path> plot;
};

struct Quantity {
  PoseRelation relation;
  std::string name;
  std::string unit;  // empty: none
};

const Quantity& FindQuantity(const std::string& relation) {
  static const std::map<std::string, Quantity> quantities = {
      {"trans_part", {PoseRelation::kTranslation, "translation error", "m"}},
      {"angle_deg", {PoseRelation::kAngleDegrees, "rotation error", "deg"}},
      {"full", {PoseRelation::kFull, "full pose error", ""}}};
  return quantities.at(relation);
}

TrajectoryAlignment FindAlignment(const std::string& name) {
  static const std::map<std::string, TrajectoryAlignment> alignments = {
      {"none", TrajectoryAlignment::kNone},
      {"se3", TrajectoryAlignment::kSe3},
      {"sim3", TrajectoryAlignment::kSim3},
      {"origin", TrajectoryAlignment::kOrigin}};
  return alignments.at(name);
}

Trajectory ReadPoses(const std::filesystem::path& path) {
  Trajectory trajectory = ReadTumTrajectory(path);
  if (trajectory.empty()) throw IoError(path, "holds no pose");
  return trajectory;
}

TrajectoryError Evaluate(const EvalArguments& arguments, const Trajectory& reference,
                         const Trajectory& estimate) {
  const TrajectoryAlignment alignment = FindAlignment(arguments.alignment);
  const PoseRelation relation = FindQuantity(arguments.relation).relation;
  if (arguments.metric == "ape") {
    return AbsolutePoseError(
        reference, estimate,
        {.t_max_diff = arguments.t_max_diff, .alignment = alignment, .relation = relation});
  }
  return RelativePoseError(
      reference, estimate,
      {.t_max_diff = arguments.t_max_diff,
       .alignment = alignment,
       .relation = relation,
       .delta = arguments.delta,
       .delta_unit = arguments.delta_unit == "f" ? DeltaUnit::kFrames : DeltaUnit::kMetres,
       .all_pairs = arguments.all_pairs});
}

// "APE, translation error [m], alignment se3"
std::string Describe(const EvalArguments& arguments) {
  const Quantity& quantity = FindQuantity(arguments.relation);
  std::string text = (arguments.metric == "ape" ? "APE, " : "RPE, ") + quantity.name;
  if (!quantity.unit.empty()) text += " [" + quantity.unit + "]";
  if (arguments.metric == "rpe") {
    text += fmt::format(" over {} {}{}", arguments.delta,
                        arguments.delta_unit == "m" ? "m"
                        : arguments.delta == 1.0    ? "frame"
                                                    : "frames",
                        arguments.all_pairs ? ", all pairs" : "");
  }
  return text + ", alignment " + arguments.alignment;
}

void PrintJson(const TrajectoryError& result, const std::optional<ErrorExplanation>& explanation) {
  const ErrorStatistics& s = result.statistics;
  nlohmann::ordered_json json = {{"stats",
                                  {{"max", s.max},
                                   {"mean", s.mean},
                                   {"median", s.median},
                                   {"min", s.min},
                                   {"rmse", s.rmse},
                                   {"sse", s.sse},
                                   {"std", s.std}}},
                                 {"associated", result.estimate.size()},
                                 {"time_covered", result.time_covered},
                                 {"scale", result.scale}};
  if (explanation) json["explanation"] = ToJson(*explanation);
  fmt::print("{}\n", json.dump());
}

void PrintTable(const EvalArguments& arguments, const TrajectoryError& result,
                std::size_t reference_poses, std::size_t estimate_poses) {
  const ErrorStatistics& s = result.statistics;
  fmt::print("{}\n", Describe(arguments));
  fmt::print("  reference  {:>6} poses  {}\n", reference_poses, arguments.reference.string());
  fmt::print("  estimate   {:>6} poses  {}\n", estimate_poses, arguments.estimate.string());
  fmt::print("  matched    {:>6} poses  over {:.1f} % of the time, scale {:.6f}\n\n",
             result.estimate.size(), 100.0 * result.time_covered, result.scale);
  fmt::print("  {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>14}\n", "rmse", "mean", "median",
             "std", "min", "max", "sse");
  fmt::print("  {:12.6f} {:12.6f} {:12.6f} {:12.6f} {:12.6f} {:12.6f} {:14.6f}\n", s.rmse, s.mean,
             s.median, s.std, s.min, s.max, s.sse);
}

int RunEval(const EvalArguments& arguments) {
  const Trajectory reference = ReadPoses(arguments.reference);
  const Trajectory estimate = ReadPoses(arguments.estimate);
  const TrajectoryError result = Evaluate(arguments, reference, estimate);
  if (!std::isfinite(result.statistics.sse)) {
    throw IoError(arguments.estimate, "holds positions too large to be compared");
  }
  std::optional<ErrorExplanation> explanation;
  if (arguments.explain) explanation = ExplainError(reference, result);
  if (arguments.plot) {
    const Quantity& quantity = FindQuantity(arguments.relation);
    WriteErrorPlot(*arguments.plot,
                   {.title = arguments.estimate.filename().string() + " against " +
                             arguments.reference.filename().string(),
                    .subtitle = Describe(arguments),
                    .quantity = quantity.name,
                    .unit = quantity.unit,
                    .left = explanation ? explanation->left : std::vector<double>()},
                   reference, result);
  }
  if (arguments.json) {
    PrintJson(result, explanation);
  } else {
    PrintTable(arguments, result, reference.size(), estimate.size());
    if (explanation) fmt::print("{}", ExplanationTable(*explanation));
  }
  return kExitOk;
}

// What the parser cannot see in one option alone.
void CheckTogether(const CLI::App& command, EvalArguments* arguments) {
  const bool relative = arguments->metric == "rpe";
  for (const char* option : {"--delta", "--delta-unit", "--all-pairs"}) {
    if (!relative && command.count(option) > 0) {
      throw CLI::ValidationError(option, "works with rpe only");
    }
  }
  if (arguments->plot && arguments->plot->extension() != ".svg") {
    throw CLI::ValidationError("--plot", "writes SVG: the name must end in .svg");
  }
  if (arguments->delta_unit == "f" && arguments->delta != std::floor(arguments->delta)) {
    throw CLI::ValidationError("--delta", "must be a whole number of frames");
  }
  if (arguments->alignment.empty()) arguments->alignment = relative ? "none" : "se3";
  if (arguments->explain &&
      (relative || arguments->alignment != "se3" || arguments->relation != "trans_part")) {
    throw CLI::ValidationError("--explain", "works with ape, --align se3 and trans_part only");
  }
}

}  // namespace

void AddEvalCommand(CLI::App& app, CommandAction& action) {
  CLI::App* command = app.add_subcommand(
      "eval", "Error of an estimated trajectory against a reference (absolute or relative).");
  const auto arguments = std::make_shared<EvalArguments>();
  command->add_option("metric", arguments->metric, "ape: absolute, rpe: relative pose error")
      ->required()
      ->check(OneOf({"ape", "rpe"}));
  command->add_option("reference", arguments->reference, "TUM file: stamp tx ty tz qx qy qz qw")
      ->required();
  command->add_option("estimate", arguments->estimate, "TUM file of the estimate")->required();
  command
      ->add_option("--align", arguments->alignment,
                   "How the estimate is laid on the reference [ape: se3, rpe: none]")
      ->check(OneOf({"none", "se3", "sim3", "origin"}));
  command->add_option("--relation", arguments->relation, "What is measured")
      ->check(OneOf({"trans_part", "angle_deg", "full"}))
      ->capture_default_str();
  command
      ->add_option("--t-max-diff", arguments->t_max_diff,
                   "Largest difference of matching stamps [s]")
      ->check(Between(0.0, 1e6))
      ->capture_default_str();
  command->add_option("--delta", arguments->delta, "rpe: distance of the two poses of a pair")
      ->check(Between(1e-9, 1e9))
      ->capture_default_str();
  command->add_option("--delta-unit", arguments->delta_unit, "rpe: f frames, m metres of path")
      ->check(OneOf({"f", "m"}))
      ->capture_default_str();
  command->add_flag("--all-pairs", arguments->all_pairs,
                    "rpe: a pair from every pose on instead of one after the other");
  command->add_flag("--json", arguments->json, "One JSON object on standard output");
  command->add_flag("--explain", arguments->explain,
                    "ape: what a shift of the clock, a scale, a lever arm and a turn between the "
                    "bodies would take away, and how much of the error is slow");
  command->add_option("--plot", arguments->plot, "Draw the trajectories and the error: FILE.svg");
  command->footer(
      "Example:\n  highwall eval ape groundtruth.txt estimate.txt --align se3 --plot error.svg\n"
      "  highwall eval rpe groundtruth.txt estimate.txt --delta 0.5 --delta-unit m --json");
  command->callback([command, arguments, &action] {
    CheckTogether(*command, arguments.get());
    action = [arguments] { return RunEval(*arguments); };
  });
}

}  // namespace highwall::apps
