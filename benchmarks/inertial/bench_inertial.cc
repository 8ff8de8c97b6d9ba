// highwall_bench_inertial: benefit of an IMU. Generated sequences with exact ground truth are run
// with RGB-D only and with each weighting and coupling of the IMU, once per seed; the table
// contains medians.
#include <CLI/App.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/open_dataset.h>

#include "bench_main.h"
#include "cache_folder.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "consistency.h"
#include "covered_lens.h"
#include "files/json_text.h"
#include "generated_sequence.h"
#include "run/config.h"
#include "run/imu_choice.h"
#include "run/imu_input.h"
#include "run/run_report.h"
#include "run/settings.h"
#include "run/slam_run.h"
#include "scores.h"

namespace highwall::bench {
namespace {

struct Arguments {
  std::vector<std::string> scenes{"mine", "road", "room"};
  std::vector<std::string> policies{"off", "paper", "consistent", "fixed:1"};
  std::vector<std::string> couplings{"tight"};
  int seeds = 5;
  std::optional<double> duration;  // [s]; default: that of the scene
  double fps = 30.0;               // [Hz]
  double scale = 1.0;              // of the images, 1: 640 x 480
  double time_offset = 0.0;        // [s]
  double noise_ratio = simulate::kUsualNoiseRatio;
  bool hard = false;
  double blackout = -1.0;        // [s] since the first frame; none if negative
  std::vector<std::string> set;  // "path=value", as for highwall slam
  std::string cache;
  bool json = false;
};

constexpr double kBlackout = 2.0;  // [s]

// Returns the readings as in a user's run, with a clock offset.
apps::ImuFeed MakeFeed(const Dataset& dataset, const std::optional<ImuCalibration>& calibration,
                       double time_offset) {
  std::optional<apps::ImuInput> input = apps::LoadImu(dataset, calibration);
  if (!input || !input->IsUsable()) throw IoError(*dataset.imu_file(), "cannot be used");
  for (ImuSample& sample : input->samples) sample.stamp += FromSeconds(time_offset);
  return {input->calibration, std::move(input->samples)};
}

// The policy that highwall slam has by default, where it has no name.
constexpr char kDefaultPolicy[] = "consistent";

// Returns the weighting of a policy; empty for "off".
std::optional<ImuWeightingOptions> WeightingOf(const std::string& policy) {
  return apps::ReadImuChoice(policy == kDefaultPolicy ? "" : policy);
}

// Returns the error message; empty if the policy is valid.
std::string ProblemOf(const std::string& policy) {
  return policy == kDefaultPolicy ? "" : apps::ImuChoice()(policy);
}

// A weighting and coupling of the IMU.
struct Setting {
  std::string policy, coupling;

  // Returns the name of its row in the table.
  std::string Name() const { return coupling == "loose" ? policy + "/loose" : policy; }
};

// Without an IMU, the coupling is irrelevant.
std::vector<Setting> Settings(const Arguments& arguments) {
  std::vector<Setting> settings;
  for (const std::string& policy : arguments.policies) {
    if (!WeightingOf(policy)) {
      settings.push_back({policy, ""});
      continue;
    }
    for (const std::string& coupling : arguments.couplings) settings.push_back({policy, coupling});
  }
  return settings;
}

Scores RunOnce(const Sequence& sequence, const Setting& setting, const Arguments& arguments,
               const std::string& label) {
  const apps::RunConfig config = apps::ResolveConfig("", sequence.folder).config;
  const std::unique_ptr<const Dataset> recorded = OpenDataset(sequence.folder, config.sensor);
  std::optional<CoveredLens> covered;
  if (arguments.blackout >= 0.0) {
    const Stamp begin = recorded->stamp(0) + FromSeconds(arguments.blackout);
    covered.emplace(*recorded, begin, begin + FromSeconds(kBlackout));
  }
  const Dataset& dataset = covered ? static_cast<const Dataset&>(*covered) : *recorded;

  apps::SlamRunOptions options;
  options.dense = false;
  options.slam = Deterministic(options.slam);  // reproducible figures
  if (const auto weighting = WeightingOf(setting.policy)) {
    options.imu = MakeFeed(dataset, config.imu, arguments.time_offset);
    options.slam.inertial.weighting = *weighting;
    options.slam.inertial.coupling =
        setting.coupling == "loose" ? InertialCoupling::kLoose : InertialCoupling::kTight;
  }
  for (const std::string& value : arguments.set) apps::Set(value, &options.slam);
  Judge judge(sequence, arguments.time_offset);
  apps::Progress progress(label);
  const apps::SlamRun run =
      apps::RunSlam(dataset, config.sensor, options,
                    {.on_frame = [&](const FrameResult& result, const RgbdImage&, std::size_t done,
                                     std::size_t total) {
                      judge.Watch(result);
                      progress.Update(done, total);
                    }});
  apps::RequireWhole(run);
  return judge.Score(run);
}

void PrintHeader() {
  fmt::print("{:<8} {:<16} {:>8} {:>7} {:>9} {:>5} {:>6} {:>6} {:>7} {:>7} {:>7} {:>6} {:>5}\n",
             "scene", "imu", "APE m", "APE %", "RPE 1s m", "lost", "cover", "init s", "tilt",
             "t_d ms", "chi2", "weight", "<1");
}

void PrintRow(const std::string& scene, const std::string& policy, const Scores& scores) {
  const auto figure = [&scores](const char* name, const char* format) {
    const auto found = scores.find(name);
    return found == scores.end() ? std::string("-")
                                 : fmt::format(fmt::runtime(format), found->second);
  };
  fmt::print("{:<8} {:<16} {:>8} {:>7} {:>9} {:>5} {:>6} {:>6} {:>7} {:>7} {:>7} {:>6} {:>5}\n",
             scene, policy, figure("ape_rmse_m", "{:.4f}"), figure("ape_percent", "{:.3f}"),
             figure("rpe_1s_rmse_m", "{:.4f}"), figure("lost_frames", "{:.0f}"),
             figure("coverage", "{:.2f}"), figure("initialized_s", "{:.1f}"),
             figure("tilt_at_5s_deg", "{:.2f}"), figure("time_offset_error_ms", "{:.2f}"),
             figure("innovation_chi2_per_dof", "{:.2f}"), figure("mean_weight", "{:.3f}"),
             figure("reduced_share", "{:.3f}"));
  for (const auto& [name, value] : scores) {  // of marked spans
    if (name.ends_with("_rpe_1s_rmse_m") || name.ends_with("_drift_percent") ||
        name.ends_with("_start_percent")) {
      fmt::print("{:<8} {:<16} {} {:.4f}\n", "", "", name, value);
    }
  }
}

void Run(const Arguments& arguments) {
  const CacheFolder cache(arguments.cache, "highwall_bench_inertial");
  nlohmann::json report;
  report["versions"] = apps::VersionsJson();
  report["time_offset_s"] = arguments.time_offset;
  report["noise_ratio"] = arguments.noise_ratio;
  report["hard"] = arguments.hard;
  if (!arguments.json) PrintHeader();
  const std::vector<Setting> settings = Settings(arguments);
  for (const std::string& scene : arguments.scenes) {
    const double duration = arguments.duration.value_or(DefaultDuration(scene));
    std::vector<std::vector<Scores>> runs(settings.size());
    for (int seed = 1; seed <= arguments.seeds; ++seed) {
      apps::Progress progress(fmt::format("{} seed {}: rendering", scene, seed));
      Sequence sequence = MakeSequence(
          {scene, static_cast<std::uint64_t>(seed), duration, arguments.fps, arguments.scale,
           arguments.noise_ratio, arguments.hard},
          cache.path(), [&progress](int done, int total) {
            progress.Update(static_cast<std::size_t>(done), static_cast<std::size_t>(total));
          });
      if (arguments.blackout >= 0.0) {
        sequence.spans.push_back(
            {kBlackoutSpan, arguments.blackout, arguments.blackout + kBlackout});
      }
      for (std::size_t i = 0; i < settings.size(); ++i) {
        const std::string name = settings[i].Name();
        runs[i].push_back(RunOnce(sequence, settings[i], arguments,
                                  fmt::format("{} seed {}: {}", scene, seed, name)));
        report["sequences"][scene][name]["runs"].push_back(runs[i].back());
        report["sequences"][scene][name]["runs"].back()["seed"] = seed;
      }
    }
    for (std::size_t i = 0; i < settings.size(); ++i) {
      const Scores medians = Medians(runs[i]);
      report["sequences"][scene][settings[i].Name()]["median"] = medians;
      if (arguments.json) continue;
      PrintRow(scene, settings[i].Name(), medians);
      if (const std::string line = ConsistencyLine(runs[i]); !line.empty()) {
        fmt::print("{:<25} squared errors at the end by their covariance: {}\n", "", line);
      }
    }
  }
  if (arguments.json) fmt::print("{}\n", apps::JsonText(report, 2));
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  AddList(app, "--scenes", arguments.scenes, SceneNames());
  app.add_option("--imu", arguments.policies,
                 "off, paper, consistent, fixed:W; separated by commas")
      ->delimiter(',')
      ->check(CLI::Validator(ProblemOf, ""));
  AddList(app, "--inertial", arguments.couplings, {"tight", "loose"});
  app.add_option("--seeds", arguments.seeds, "Sequences of each scene")
      ->check(apps::Between(1.0, 1000.0));
  app.add_option("--duration", arguments.duration, "Of a sequence [s], else a lap")
      ->check(apps::Between(1.0, 3600.0));
  app.add_option("--fps", arguments.fps, "Frames per second")
      ->check(apps::Between(1.0, 240.0))
      ->capture_default_str();
  app.add_option("--scale", arguments.scale, "Of the image, 1 = 640 x 480")
      ->check(apps::Between(0.1, 2.0))
      ->capture_default_str();
  app.add_option("--time-offset", arguments.time_offset,
                 "How far the IMU's clock is ahead, unknown to the system [s]")
      ->check(apps::Between(-0.2, 0.2));
  app.add_option(
         "--noise-ratio", arguments.noise_ratio,
         "True noise of depth and IMU over that of the data sheets, which the system is given")
      ->check(apps::Between(0.01, 100.0))
      ->capture_default_str();
  app.add_flag("--hard", arguments.hard,
               "The IMU has the faults of a cheap sensor on a bad day (highwall simulate "
               "--imu-faults hard)");
  app.add_option("--blackout", arguments.blackout, "Cover the lens for 2 s from this time on [s]")
      ->check(apps::Between(0.0, 3600.0));
  app.add_option("--set", arguments.set,
                 "One setting, as highwall slam --print-settings names it; may be repeated")
      ->type_name("NAME=VALUE");
  app.add_option("--cache", arguments.cache,
                 "Keep the sequences in this folder and use those that are there; empty it when "
                 "the simulator has changed");
  app.add_flag("--json", arguments.json, "Print one JSON object");
  app.footer("Example: highwall_bench_inertial --scenes room --seeds 5 --cache sequences");
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  const BenchName name{"highwall_bench_inertial",
                       "What an IMU is worth, on generated sequences with exact truth."};
  return RunBench<Arguments>(name, argc, argv, AddOptions, Run);
}
