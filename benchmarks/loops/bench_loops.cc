// highwall_bench_loops: what place recognition and loop closing find, and what they take.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <exception>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench_loops.h"

int main(int argc, char** argv) {
  const std::vector<std::string> all{"room",  "mine",       "road",     "kidnapped",
                                     "index", "correction", "endurance"};
  std::vector<std::string> parts = all;
  int seeds = 20, index_keyframes = 2000, corrected_keyframes = 500;
  double seconds = 40.0, minutes = 30.0;
  bool json = false;
  CLI::App app("Loops, relocalization and place recognition in generated scenes.",
               "highwall_bench_loops");
  app.add_option("--parts", parts, fmt::format("{}; separated by commas", fmt::join(all, ", ")))
      ->delimiter(',')
      ->check(CLI::IsMember(all));
  app.add_option("--seeds", seeds, "Scenes of each kind")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seconds", seconds, "Of each walk in a room; it has laps of at most 20 s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--minutes", minutes, "Of the walk of endurance")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--index-keyframes", index_keyframes, "Keyframes that a query is made among")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--corrected-keyframes", corrected_keyframes, "Keyframes that a loop goes over")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--json", json, "Print one JSON object");
  app.footer("Example: highwall_bench_loops --parts room --seeds 20");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  try {
    using namespace highwall::bench;
    const std::set<std::string> wanted(parts.begin(), parts.end());
    nlohmann::json report;
    if (wanted.contains("index")) report["index"] = BenchIndex(index_keyframes);
    if (wanted.contains("correction")) report["correction"] = BenchCorrection(corrected_keyframes);
    if (wanted.contains("kidnapped")) report["kidnapped"] = BenchKidnapped(seeds);
    for (const char* scene : {"room", "mine", "road"}) {
      if (wanted.contains(scene)) report[scene] = BenchReturns(scene, seeds, seconds);
    }
    if (wanted.contains("endurance")) report["endurance"] = BenchEndurance(minutes);
    if (json) {
      fmt::print("{}\n", report.dump(2));
    } else {
      for (auto& [part, figures] : report.items()) {
        figures.erase("runs");
        fmt::print("{}: {}\n", part, figures.dump());
      }
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "highwall_bench_loops: failed: {}\n", error.what());
    return 3;
  }
}
