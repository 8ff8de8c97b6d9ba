// highwall eval: errors of estimated trajectories against a reference.
#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "commands/eval_output.h"
#include "commands/explanation_report.h"
#include "files/evo_result.h"
#include "files/json_text.h"
#include "files/trajectory_file.h"
#include "plots/error_plot.h"
#include "plots/overlay_plot.h"

namespace highwall::apps {
namespace {

struct EvalArguments {
  std::string metric;
  std::filesystem::path reference;
  std::vector<std::filesystem::path> estimates;
  std::string alignment;  // empty: se3 for ape, none for rpe
  std::string relation = "trans_part";
  double t_max_diff = 0.02;  // [s]
  double delta = 1.0;
  std::string delta_unit = "f";
  bool all_pairs = false;
  bool json = false;
  bool csv = false;
  bool explain = false;
  std::optional<std::filesystem::path> plot, evo_results;
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
      {"scale", TrajectoryAlignment::kScale},
      {"origin", TrajectoryAlignment::kOrigin}};
  return alignments.at(name);
}

TrajectoryFile ReadPoses(const std::filesystem::path& path) {
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.poses.empty()) throw IoError(path, "holds no pose");
  RequireDistinctStamps(path, &file);
  if (!file.assumed.empty()) PrintWarning("eval", path.string() + ": " + file.assumed);
  return file;
}

// Poses without stamps are matched by their index in the file: both must have the same number.
void RequireSameClock(const TrajectoryFile& reference, const std::filesystem::path& path,
                      const TrajectoryFile& estimate) {
  const bool stamps = HasStamps(reference.format);
  if (stamps != HasStamps(estimate.format)) {
    throw IoError(path, fmt::format("is in the format {}, the reference in {}: one has no stamps",
                                    ToString(estimate.format), ToString(reference.format)));
  }
  if (!stamps && estimate.poses.size() != reference.poses.size()) {
    throw IoError(path, fmt::format("holds {} poses without stamps, the reference {}",
                                    estimate.poses.size(), reference.poses.size()));
  }
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

// Returns the equivalent evo command, if its command line reads both formats; empty otherwise.
std::string EvoCommand(const EvalArguments& arguments, TrajectoryFormat reference,
                       TrajectoryFormat estimate) {
  const bool same = reference == estimate ||
                    (reference == TrajectoryFormat::kEuroc && estimate == TrajectoryFormat::kTum);
  const bool known = reference == TrajectoryFormat::kTum || reference == TrajectoryFormat::kKitti ||
                     reference == TrajectoryFormat::kEuroc;
  if (!same || !known || arguments.estimates.size() > 1) return "";
  static const std::map<std::string, std::string> alignments = {{"none", ""},
                                                                {"se3", " -a"},
                                                                {"sim3", " -as"},
                                                                {"scale", " -s"},
                                                                {"origin", " --align_origin"}};
  std::string command =
      fmt::format("evo_{} {} {} {} -r {}{}", arguments.metric, ToString(reference),
                  arguments.reference.string(), arguments.estimates.front().string(),
                  arguments.relation, alignments.at(arguments.alignment));
  if (reference != TrajectoryFormat::kKitti) {
    command += fmt::format(" --t_max_diff {}", arguments.t_max_diff);
  }
  if (arguments.metric == "rpe") {
    command += fmt::format(" -d {} -u {}{}", arguments.delta, arguments.delta_unit,
                           arguments.all_pairs ? " --all_pairs" : "");
  }
  return command;
}

void PrintTable(const EvalArguments& arguments, const TrajectoryFile& reference,
                const TrajectoryFile& estimate, const TrajectoryError& result) {
  const ErrorStatistics& s = result.statistics;
  fmt::print("{}\n", Describe(arguments));
  fmt::print("  reference  {:>6} poses  {}\n", reference.poses.size(),
             arguments.reference.string());
  fmt::print("  estimate   {:>6} poses  {}\n", estimate.poses.size(),
             arguments.estimates.front().string());
  fmt::print("  matched    {:>6} poses  over {:.1f} % of the time, scale {:.6f}\n",
             result.estimate.size(), 100.0 * result.time_covered, result.scale);
  if (const std::string evo = EvoCommand(arguments, reference.format, estimate.format);
      !evo.empty() && result.open_rotation == OpenRotation::kNone) {
    fmt::print("  the same by evo  {}\n", evo);
  }
  fmt::print("\n  {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>14}\n", "rmse", "mean", "median",
             "std", "min", "max", "sse");
  fmt::print("  {:12.6f} {:12.6f} {:12.6f} {:12.6f} {:12.6f} {:12.6f} {:14.6f}\n", s.rmse, s.mean,
             s.median, s.std, s.min, s.max, s.sse);
}

void Plot(const EvalArguments& arguments, const Trajectory& reference,
          const std::vector<NamedError>& errors,
          const std::optional<ErrorExplanation>& explanation) {
  const Quantity& quantity = FindQuantity(arguments.relation);
  const std::string against = " against " + arguments.reference.filename().string();
  if (errors.size() == 1) {
    WriteErrorPlot(*arguments.plot,
                   {.title = arguments.estimates.front().filename().string() + against,
                    .subtitle = Describe(arguments),
                    .quantity = quantity.name,
                    .unit = quantity.unit,
                    .left = explanation ? explanation->left : std::vector<double>()},
                   reference, errors.front().error);
    return;
  }
  const std::string unit = quantity.unit.empty() ? "" : " [" + quantity.unit + "]";
  WriteOverlayPlot(*arguments.plot,
                   {.title = fmt::format("{} estimates{}", errors.size(), against),
                    .subtitle = Describe(arguments),
                    .quantity = quantity.name + unit},
                   reference, errors);
}

// Writes one file, or for several estimates a folder with one file each.
void WriteEvoResults(const EvalArguments& arguments, const std::vector<NamedError>& errors) {
  const Quantity& quantity = FindQuantity(arguments.relation);
  const std::string metric = arguments.metric == "ape" ? "APE" : "RPE";
  const std::filesystem::path& out = *arguments.evo_results;
  if (errors.size() > 1) std::filesystem::create_directories(out);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const std::string name =
        fmt::format("{}_{}.zip", i + 1, arguments.estimates[i].stem().string());
    WriteEvoResult(
        errors.size() > 1 ? out / name : out,
        {.title = Describe(arguments),
         .label = fmt::format("{} ({})", metric, quantity.unit.empty() ? "1" : quantity.unit),
         .reference = arguments.reference.string(),
         .estimate = errors[i].name},
        errors[i].error);
  }
}

NamedError ErrorOf(const EvalArguments& arguments, const TrajectoryFile& reference,
                   const std::filesystem::path& path, const TrajectoryFile& estimate) {
  RequireSameClock(reference, path, estimate);
  TrajectoryError error;
  try {
    error = Evaluate(arguments, reference.poses, estimate.poses);
  } catch (const InvalidArgument& what) {
    throw IoError(path, what.what());
  }
  if (!std::isfinite(error.statistics.sse)) {
    throw IoError(path, "holds positions too large to be compared");
  }
  if (const std::string open = OpenRotationText(error.open_rotation); !open.empty()) {
    PrintWarning("eval", path.string() + ": " + open);
  }
  return {path.string(), std::move(error)};
}

ErrorExplanation ExplanationOf(const Trajectory& reference, const std::filesystem::path& path,
                               const TrajectoryError& error) {
  try {
    return ExplainError(reference, error);
  } catch (const InvalidArgument& what) {
    throw IoError(path, std::string(what.what()) + " (leave --explain out)");
  }
}

void PrintJson(const EvalArguments& arguments, const std::vector<NamedError>& errors,
               const std::optional<ErrorExplanation>& explanation) {
  nlohmann::ordered_json json;
  if (errors.size() == 1) {
    json = ErrorJson(errors.front().error);
    if (explanation) json["explanation"] = ToJson(*explanation);
  } else {
    json["reference"] = arguments.reference.string();
    for (const NamedError& named : errors) {
      nlohmann::ordered_json estimate = {{"estimate", named.name}};
      estimate.update(ErrorJson(named.error));
      json["estimates"].push_back(std::move(estimate));
    }
  }
  fmt::print("{}\n", JsonText(json));
}

int RunEval(const EvalArguments& arguments) {
  const TrajectoryFile reference = ReadPoses(arguments.reference);
  std::vector<TrajectoryFile> estimates;
  std::vector<NamedError> errors;
  for (const std::filesystem::path& path : arguments.estimates) {
    estimates.push_back(ReadPoses(path));
    errors.push_back(ErrorOf(arguments, reference, path, estimates.back()));
  }
  std::optional<ErrorExplanation> explanation;
  if (arguments.explain) {
    explanation = ExplanationOf(reference.poses, arguments.estimates.front(), errors.front().error);
  }
  if (arguments.plot) Plot(arguments, reference.poses, errors, explanation);
  if (arguments.evo_results) WriteEvoResults(arguments, errors);
  if (arguments.json) {
    PrintJson(arguments, errors, explanation);
  } else if (arguments.csv) {
    fmt::print("{}", ErrorsCsv(errors));
  } else if (errors.size() > 1) {
    fmt::print("{}\n  reference  {:>6} poses  {}\n\n{}", Describe(arguments),
               reference.poses.size(), arguments.reference.string(), ErrorsTable(errors));
  } else {
    PrintTable(arguments, reference, estimates.front(), errors.front().error);
    if (explanation) fmt::print("{}", ExplanationTable(*explanation));
  }
  return kExitOk;
}

// Checks that involve more than one option, which the parser cannot do.
void CheckTogether(const CLI::App& command, EvalArguments* arguments) {
  const bool relative = arguments->metric == "rpe";
  for (const char* option : {"--delta", "--delta-unit", "--all-pairs"}) {
    if (!relative && command.count(option) > 0) {
      throw CLI::ValidationError(option, "works with rpe only");
    }
  }
  const bool several = arguments->estimates.size() > 1;
  if (arguments->plot && arguments->plot->extension() != ".svg" &&
      arguments->plot->extension() != ".png") {
    throw CLI::ValidationError("--plot", "the name must end in .svg or .png");
  }
  if (arguments->evo_results && !several && arguments->evo_results->extension() != ".zip") {
    throw CLI::ValidationError("--evo-results", "the name must end in .zip");
  }
  if (arguments->delta_unit == "f" && arguments->delta != std::floor(arguments->delta)) {
    throw CLI::ValidationError("--delta", "must be a whole number of frames");
  }
  if (arguments->alignment.empty()) arguments->alignment = relative ? "none" : "se3";
  if (arguments->explain && several) {
    throw CLI::ValidationError("--explain", "works with one estimate only");
  }
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
  command
      ->add_option("reference", arguments->reference,
                   "Poses in the format of TUM, KITTI or EuRoC, as ROS prints them, or a table")
      ->required();
  command
      ->add_option("estimate", arguments->estimates,
                   "One or several estimates in any of these formats")
      ->required();
  command
      ->add_option("--align", arguments->alignment,
                   "How the estimate is laid on the reference [ape: se3, rpe: none]")
      ->check(OneOf({"none", "se3", "sim3", "scale", "origin"}));
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
  CLI::Option* json =
      command->add_flag("--json", arguments->json, "One JSON object on standard output");
  command->add_flag("--csv", arguments->csv, "A row for each estimate on standard output")
      ->excludes(json);
  command->add_flag("--explain", arguments->explain,
                    "ape: what a shift of the clock, a scale, a lever arm and a turn between the "
                    "bodies would take away, and how much of the error is slow");
  command->add_option("--plot", arguments->plot,
                      "Draw the trajectories and the errors: FILE.svg or FILE.png");
  command->add_option("--evo-results", arguments->evo_results,
                      "Write what evo_res opens: FILE.zip, of several estimates a folder of them");
  command->footer(
      "Example:\n  highwall eval ape groundtruth.txt estimate.txt --align se3 --plot error.svg\n"
      "  highwall eval ape groundtruth.txt run_a/trajectory.txt run_b/trajectory.txt --plot "
      "all.png\n"
      "  highwall eval rpe groundtruth.txt estimate.txt --delta 0.5 --delta-unit m --json");
  command->callback([command, arguments, &action] {
    CheckTogether(*command, arguments.get());
    action = [arguments] { return RunEval(*arguments); };
  });
}

}  // namespace highwall::apps
