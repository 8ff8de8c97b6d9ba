// highwall_bench_conditions: trajectory error with dynamic objects, with low texture, and with
// depth that is too long, on generated sequences with exact ground truth.
#include "bench_conditions.h"

#include <CLI/App.hpp>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench_main.h"
#include "cli/option_checks.h"
#include "files/json_text.h"

namespace highwall::bench {
namespace {

struct Arguments {
  std::vector<std::string> parts{"moving", "texture", "dark", "depth"};
  ConditionOptions conditions;
  bool json = false;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  ConditionOptions& conditions = arguments.conditions;
  AddList(app, "--parts", arguments.parts, {"moving", "texture", "dark", "depth"});
  AddList(app, "--scenes", conditions.scenes, {"mine", "road", "room"},
          "; depth: road and room, texture: the road, dark: the mine");
  app.add_option("--seeds", conditions.seeds, "Sequences of each scene")
      ->check(apps::Between(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--duration", conditions.seconds,
                 "Of a sequence [s] [default: moving 24, texture 33, dark 45, depth 30]")
      ->check(apps::Between(0.5, 3600.0));
  app.add_option("--starts", conditions.starts,
                 "Frames where each sequence of moving begins; medians over them")
      ->check(apps::Between(1.0, 100.0))
      ->capture_default_str();
  app.add_option("--contrast", conditions.contrast, "That the stretch of low texture keeps")
      ->check(apps::Between(0.01, 1.0))
      ->capture_default_str();
  app.add_option("--too-long", conditions.too_long, "Measured over true depth")
      ->check(apps::Between(0.5, 2.0))
      ->capture_default_str();
  app.add_flag("--json", arguments.json, "Print one JSON object");
  app.footer("Example: highwall_bench_conditions --parts moving --scenes room --seeds 5");
}

nlohmann::json Run(const Arguments& arguments) {
  const std::set<std::string> wanted(arguments.parts.begin(), arguments.parts.end());
  nlohmann::json report;
  if (wanted.contains("moving")) report["moving"] = BenchMoving(arguments.conditions);
  if (wanted.contains("texture")) report["texture"] = BenchTexture(arguments.conditions);
  if (wanted.contains("dark")) report["dark"] = BenchDark(arguments.conditions);
  if (wanted.contains("depth")) report["depth"] = BenchDepth(arguments.conditions);
  return report;
}

void Print(const nlohmann::json& report, bool json) {
  if (json) {
    fmt::print("{}\n", apps::JsonText(report, 2));
    return;
  }
  for (const auto& [part, rows] : report.items()) {
    for (const auto& [name, row] : rows.items()) {
      fmt::print("{:<8} {:<30}", part, name);
      for (const auto& [figure, value] : row["median"].items()) {
        fmt::print(" {} {:.4g}", figure, value.get<double>());
      }
      fmt::print("\n");
    }
  }
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  const BenchName name{
      "highwall_bench_conditions",
      "Moving objects, little texture, a wrong depth: generated scenes, medians of seeds."};
  return RunBench<Arguments>(name, argc, argv, AddOptions, [](const Arguments& arguments) {
    Print(Run(arguments), arguments.json);
  });
}
