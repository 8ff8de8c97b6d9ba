// highwall_bench_tum: accuracy and speed of the SLAM system on sequences in the TUM RGB-D layout.
// "track" is features, matching and pose of a frame, "frame" all that the frame waits for,
// keyframes and loops included. Each sequence runs with points, with lines and with both, several
// times; the table gives medians. Tracking time is quoted as a ratio to cv::ORB::detectAndCompute
// on the same images, measured in the same run between the frames. With --paired two settings run
// against each other instead (paired.h).
#include <CLI/App.hpp>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "bench_main.h"
#include "config.h"
#include "medians.h"
#include "option_checks.h"
#include "paired.h"
#include "progress.h"
#include "run_report.h"
#include "slam_run.h"
#include "timing.h"

namespace highwall::bench {
namespace {

struct BenchArguments {
  std::string data;
  std::vector<std::string> sequences;
  std::vector<std::string> features{"points", "lines", "both"};
  int runs = 5;
  bool json = false;
  bool dense = false;
  bool deterministic = false;
  bool paired = false;
  std::pair<std::string, std::string> settings;  // of --paired
  std::string program;
  std::size_t step = PairedArguments().step;
};

// cv::ORB on the images of a run, timed between its frames.
class OrbReference {
 public:
  void Measure(const cv::Mat& bgr) {
    cv::cvtColor(bgr, gray_, cv::COLOR_BGR2GRAY);
    samples_.push_back(1e3 * WallSeconds([&] {
                         orb_->detectAndCompute(gray_, cv::noArray(), keypoints_, descriptors_);
                       }));
  }
  double MedianMs() const { return apps::Summarize(samples_).median; }

 private:
  cv::Ptr<cv::ORB> orb_ = cv::ORB::create(1000, 1.2F, 8);
  cv::Mat gray_, descriptors_;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<double> samples_;
};

template <class Compute>
double RmseOr(double fallback, const Compute& compute) {
  try {
    return compute().statistics.rmse;
  } catch (const InvalidArgument&) {  // too few poses
    return fallback;
  }
}

apps::SlamRunOptions OptionsFor(const std::string& features, const BenchArguments& arguments) {
  apps::SlamRunOptions options;
  options.slam.frame.use_points = features != "lines";
  options.slam.frame.use_lines = features != "points";
  options.dense = arguments.dense;
  if (arguments.deterministic) options.slam = Deterministic(options.slam);
  return options;
}

// The figures of one run of one sequence with one choice of features.
Scores RunOnce(const TumDataset& dataset, const RgbdSensor& sensor,
               const apps::SlamRunOptions& options, const std::string& label) {
  OrbReference orb;
  apps::Progress progress(label);
  const apps::SlamRun run = apps::RunSlam(
      dataset, sensor, options,
      [&](const FrameResult&, const RgbdImage& image, std::size_t done, std::size_t total) {
        orb.Measure(image.bgr);
        progress.Update(done, total);
      });
  apps::RequireWhole(run);
  // RMSE [m]: 0 without a ground truth, negative where it could not be computed.
  Scores figures{{"ape_rmse_m", 0.0}, {"rpe_1_frame_rmse_m", 0.0}, {"rpe_30_frames_rmse_m", 0.0}};
  if (const Trajectory* truth = dataset.groundtruth()) {
    figures["ape_rmse_m"] =
        RmseOr(-1.0, [&] { return AbsolutePoseError(*truth, run.largest.trajectory); });
    figures["rpe_1_frame_rmse_m"] =
        RmseOr(-1.0, [&] { return RelativePoseError(*truth, run.largest.trajectory); });
    figures["rpe_30_frames_rmse_m"] = RmseOr(
        -1.0, [&] { return RelativePoseError(*truth, run.largest.trajectory, {.delta = 30.0}); });
  }
  figures["coverage"] = apps::Coverage(run);
  figures["lost_frames"] = static_cast<double>(run.lost.size());
  figures["keyframes"] = static_cast<double>(run.keyframes.size());
  figures["points"] = static_cast<double>(run.points);
  figures["lines"] = static_cast<double>(run.lines);
  figures["tracking_ms"] = run.times.tracking.median;
  figures["tracking_p99_ms"] = run.times.tracking.p99;
  figures["frame_ms"] = run.times.frame.median;
  figures["frame_mean_ms"] = run.times.frame.mean;
  figures["frame_p99_ms"] = run.times.frame.p99;
  figures["mapping_ms"] = run.times.mapping.median;
  figures["orb_ms"] = orb.MedianMs();
  figures["tracking_over_orb"] = figures["tracking_ms"] / figures["orb_ms"];
  figures["seconds"] = run.seconds;
  return figures;
}

void PrintHeader() {
  fmt::print(
      "{:<16} {:<7} {:>8} {:>8} {:>8} {:>6} {:>5} {:>4} {:>8} {:>8} {:>8} {:>8} {:>8} {:>6} "
      "{:>6}\n",
      "sequence", "uses", "APE m", "RPE1 m", "RPE30 m", "cover", "lost", "kf", "track ms",
      "track 99", "frame ms", "mean", "frame 99", "ORB ms", "ratio");
}

void PrintRow(const std::string& sequence, const std::string& features, const Scores& f) {
  fmt::print(
      "{:<16} {:<7} {:>8.5f} {:>8.5f} {:>8.5f} {:>6.3f} {:>5.0f} {:>4.0f} {:>8.2f} {:>8.2f} "
      "{:>8.2f} {:>8.2f} {:>8.2f} {:>6.2f} {:>6.2f}\n",
      sequence, features, f.at("ape_rmse_m"), f.at("rpe_1_frame_rmse_m"),
      f.at("rpe_30_frames_rmse_m"), f.at("coverage"), f.at("lost_frames"), f.at("keyframes"),
      f.at("tracking_ms"), f.at("tracking_p99_ms"), f.at("frame_ms"), f.at("frame_mean_ms"),
      f.at("frame_p99_ms"), f.at("orb_ms"), f.at("tracking_over_orb"));
}

void Run(const BenchArguments& arguments) {
  nlohmann::json report;
  report["versions"] = apps::VersionsJson();
  report["runs"] = arguments.runs;
  if (!arguments.json) PrintHeader();
  for (const std::string& sequence : arguments.sequences) {
    const std::filesystem::path directory = std::filesystem::path(arguments.data) / sequence;
    const RgbdSensor sensor = apps::ResolveConfig("", directory).config.sensor;
    const TumDataset dataset(directory, {.depth_factor = sensor.depth_factor,
                                         .width = sensor.camera.width,
                                         .height = sensor.camera.height});
    for (const std::string& features : arguments.features) {
      const apps::SlamRunOptions options = OptionsFor(features, arguments);
      std::vector<Scores> runs;
      for (int i = 0; i < arguments.runs; ++i) {
        runs.push_back(RunOnce(dataset, sensor, options,
                               fmt::format("{} {} run {}", sequence, features, i + 1)));
      }
      const Scores medians = Medians(runs);
      if (!arguments.json) PrintRow(sequence, features, medians);
      nlohmann::json& entry = report["sequences"][sequence][features];
      entry["median"] = medians;
      entry["runs"] = runs;
    }
  }
  report["peak_memory_mib"] = apps::PeakMemoryMib();
  if (arguments.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    fmt::print("medians of {} runs; peak memory {:.0f} MiB\n", arguments.runs,
               apps::PeakMemoryMib());
  }
}

// Two settings instead of the table of features. They are checked with the command line.
void AddPairedOptions(CLI::App& app, BenchArguments& arguments, CLI::Option* features,
                      CLI::Option* dense) {
  CLI::Option* paired =
      app.add_option("--paired", arguments.settings,
                     "Run two settings against each other, --runs times from beginnings --step "
                     "frames apart, in lockstep: each what one would write behind highwall slam, "
                     "\"\" for nothing")
          ->type_name("A B")
          ->excludes(features)
          ->excludes(dense);
  app.add_option("--paired-program", arguments.program,
                 "The highwall of another build, which runs B")
      ->check(apps::NotEmpty())
      ->needs(paired);
  app.add_option("--step", arguments.step, "Frames from one beginning of --paired to the next")
      ->check(apps::Between(1.0, 1e6))
      ->needs(paired)
      ->capture_default_str();
  app.callback([&arguments, paired] {
    arguments.paired = paired->count() > 0;
    if (!arguments.paired) return;
    RequireSetting("A", arguments.settings.first);
    if (arguments.program.empty()) RequireSetting("B", arguments.settings.second);
  });
}

void AddOptions(CLI::App& app, BenchArguments& arguments) {
  app.add_option("--data", arguments.data, "Folder that holds the sequences")->required();
  app.add_option("--sequences", arguments.sequences, "Folders in it, separated by commas")
      ->delimiter(',')
      ->required();
  app.add_option("--runs", arguments.runs, "Runs of each")->check(CLI::PositiveNumber);
  CLI::Option* features =
      AddList(app, "--features", arguments.features, {"points", "lines", "both"});
  CLI::Option* dense =
      app.add_flag("--dense", arguments.dense, "Build cloud, octree and grid as well");
  app.add_flag("--deterministic", arguments.deterministic,
               "Everything on one thread, in lockstep, but for the decoding of images");
  app.add_flag("--json", arguments.json, "Print one JSON object");
  AddPairedOptions(app, arguments, features, dense);
  app.footer(
      "Examples:\n"
      "  highwall_bench_tum --data datasets --sequences fr1_xyz,fr3_teddy --runs 5\n"
      "  highwall_bench_tum --data datasets --sequences fr1_xyz --paired \"\" \"--no-loops\"");
}

void RunEither(const BenchArguments& arguments) {
  if (!arguments.paired) return Run(arguments);
  RunPaired({.data = arguments.data,
             .sequences = arguments.sequences,
             .settings = arguments.settings,
             .program = arguments.program,
             .pairs = arguments.runs,
             .step = arguments.step,
             .json = arguments.json});
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  const BenchName name{"highwall_bench_tum",
                       "Accuracy and speed of Highwall on sequences in the TUM RGB-D layout."};
  return RunBench<BenchArguments>(name, argc, argv, AddOptions, RunEither);
}
