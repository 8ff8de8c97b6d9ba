// highwall_bench_loops: quality and cost of place recognition and loop closing.
#include "bench_loops.h"

#include <CLI/App.hpp>
#include <set>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "bench_main.h"
#include "files/json_text.h"

namespace highwall::bench {
namespace {

std::vector<std::string> AllParts() {
  return {"room",       "mine",       "road",  "kidnapped", "index",
          "correction", "acceptance", "edges", "endurance", "endurance-imu"};
}

struct Arguments {
  std::vector<std::string> parts = AllParts();
  int seeds = 20, index_keyframes = 2000, corrected_keyframes = 500;
  std::vector<int> map_keyframes = {50, 200, 1000};
  double seconds = 40.0, minutes = 30.0;
  bool json = false;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  AddList(app, "--parts", arguments.parts, AllParts());
  app.add_option("--seeds", arguments.seeds, "Scenes of each kind")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seconds", arguments.seconds,
                 "Of each walk in a room; it has laps of at most 20 s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--minutes", arguments.minutes, "Of the walk of endurance")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--index-keyframes", arguments.index_keyframes,
                 "Keyframes that a query is made among")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--corrected-keyframes", arguments.corrected_keyframes,
                 "Keyframes that a loop goes over")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--map-keyframes", arguments.map_keyframes,
                 "Sizes of the maps that loops are put to")
      ->delimiter(',')
      ->check(CLI::Range(20, 100000))
      ->capture_default_str();
  app.add_flag("--json", arguments.json, "Print one JSON object");
  app.footer("Example: highwall_bench_loops --parts room --seeds 20");
}

nlohmann::json Run(const Arguments& arguments) {
  const std::set<std::string> wanted(arguments.parts.begin(), arguments.parts.end());
  nlohmann::json report;
  if (wanted.contains("index")) report["index"] = BenchIndex(arguments.index_keyframes);
  if (wanted.contains("correction")) {
    report["correction"] = BenchCorrection(arguments.corrected_keyframes, arguments.seeds);
  }
  if (wanted.contains("acceptance")) {
    report["acceptance"] = BenchAcceptance(arguments.map_keyframes, arguments.seeds);
  }
  if (wanted.contains("kidnapped")) report["kidnapped"] = BenchKidnapped(arguments.seeds);
  for (const char* scene : {"room", "mine", "road"}) {
    if (!wanted.contains(scene)) continue;
    report[scene] = BenchReturns(scene, arguments.seeds, arguments.seconds);
  }
  if (wanted.contains("edges")) {
    for (const char* scene : {"room", "road"}) {
      report["edges"][scene] = BenchEdges(scene, arguments.seeds);
    }
  }
  for (const char* part : {"endurance", "endurance-imu"}) {
    if (!wanted.contains(part)) continue;
    report[part] = BenchEndurance(arguments.minutes, part == std::string("endurance-imu"));
  }
  return report;
}

void Print(nlohmann::json report, bool json) {
  if (json) {
    fmt::print("{}\n", apps::JsonText(report, 2));
    return;
  }
  for (auto& [part, figures] : report.items()) {
    figures.erase("runs");  // one line per part
    fmt::print("{}: {}\n", part, apps::JsonText(figures));
  }
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  const BenchName name{"highwall_bench_loops",
                       "Loops, relocalization and place recognition in generated scenes."};
  return RunBench<Arguments>(name, argc, argv, AddOptions, [](const Arguments& arguments) {
    Print(Run(arguments), arguments.json);
  });
}
