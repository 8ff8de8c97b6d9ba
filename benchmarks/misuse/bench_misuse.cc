// highwall_bench_misuse: recordings with a wrong configuration: whether a run says so and rightly
// names the fault, and what it costs; and right recordings, in which nothing must be found.
#include <CLI/App.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "bench_main.h"
#include "cli/option_checks.h"
#include "files/json_text.h"
#include "misuse_table.h"
#include "misuses.h"
#include "trial.h"
#include "true_recording.h"

namespace highwall::bench {
namespace {

constexpr const char* kRight = "right";  // as a name of --faults: the right recordings

struct Arguments {
  std::vector<std::string> scenes{"room", "road", "mine"}, faults, data;
  int seeds = 3, first_seed = 1;
  double duration = 10.0;
  bool json = false;
};

std::vector<std::string> Choices() {
  std::vector<std::string> choices = AllFaults();
  choices.emplace_back(kRight);
  return choices;
}

bool Wants(const Arguments& arguments, const std::string& fault) {
  return arguments.faults.empty() ||
         std::ranges::find(arguments.faults, fault) != arguments.faults.end();
}

// Runs the right recordings that the IMU of the recording allows.
void RunRight(const TrueRecording& recording, const std::string& prefix, MisuseTable* table,
              const std::vector<Misuse>& kinds) {
  for (const Misuse& kind : kinds) {
    if (kind.inertial && !recording.imu) continue;
    table->AddRight(prefix + kind.fault, recording.name, RunStated(Misstate(recording, kind)));
  }
}

void RunRecording(const TrueRecording& recording, const Arguments& arguments, MisuseTable* table) {
  std::vector<Misuse> kinds = RightRecordings();
  RightTrials right{RunStated(Misstate(recording, kinds.at(0))), {}};
  if (recording.imu) right.both = RunStated(Misstate(recording, kinds.at(1)));
  if (Wants(arguments, kRight)) {
    table->AddRight(kinds[0].fault, recording.name, right.images);
    if (right.both) table->AddRight(kinds[1].fault, recording.name, *right.both);
    kinds.erase(kinds.begin(), kinds.begin() + 2);
    RunRight(recording, "", table, kinds);
  }
  for (const Misuse& misuse : AllMisuses()) {
    if (!Wants(arguments, misuse.fault) || (misuse.inertial && !recording.imu)) continue;
    table->Add(misuse, recording.name, RunStated(Misstate(recording, misuse)), right);
  }
}

void RunGenerated(const std::string& scene, int seed, const Arguments& arguments,
                  MisuseTable* table) {
  const GeneratedRecording options{.scene = scene, .seed = seed, .seconds = arguments.duration};
  RunRecording(Generate(options), arguments, table);
  if (!Wants(arguments, kRight)) return;
  GeneratedRecording late = options;
  late.depth_delay = 0.02;
  std::vector<Misuse> untouched = RightRecordings();
  untouched.resize(2);
  RunRight(Generate(late), "depth 20 ms late: ", table, untouched);
}

void Bench(const Arguments& arguments) {
  MisuseTable table;
  for (const std::string& scene : arguments.scenes) {
    if (scene == "none") continue;
    for (int i = 0; i < arguments.seeds; ++i) {
      RunGenerated(scene, arguments.first_seed + i, arguments, &table);
    }
  }
  for (const std::string& folder : arguments.data) {
    RunRecording(OpenRecording(folder, arguments.duration), arguments, &table);
  }
  if (arguments.json) {
    fmt::print("{}\n", apps::JsonText(table.ToJson(), 2));
  } else {
    table.Print();
  }
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  AddList(app, "--scenes", arguments.scenes, {"room", "road", "mine", "none"},
          "; none: --data alone");
  app.add_option("--seeds", arguments.seeds, "Recordings of each scene")
      ->check(apps::Between(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--first-seed", arguments.first_seed, "Of the first of them")
      ->check(apps::Between(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--duration", arguments.duration, "Of a recording [s]; of --data, its beginning")
      ->check(apps::Between(0.5, 3600.0))
      ->capture_default_str();
  AddList(app, "--faults", arguments.faults, Choices(), "; all unless given");
  app.add_option("--data", arguments.data,
                 "Folder of a recording with groundtruth.txt and a known calibration; may be given "
                 "again")
      ->check(apps::NotEmpty());
  app.add_flag("--json", arguments.json, "Print one JSON object, with every run");
  app.footer(
      "Example: highwall_bench_misuse --scenes room --seeds 1 --faults 'depth factor,right'");
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  const BenchName name{"highwall_bench_misuse",
                       "Recordings with a wrong configuration, and whether a run says so."};
  return RunBench<Arguments>(name, argc, argv, AddOptions, Bench);
}
