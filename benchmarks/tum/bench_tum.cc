// highwall_bench_tum: accuracy and speed of the SLAM system on sequences in the TUM RGB-D layout.
// Each sequence runs with points, with lines and with both, several times; the table gives medians.
// Tracking time is quoted as a ratio to cv::ORB::detectAndCompute on the same images, measured in
// the same run between the frames.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/tum_dataset.h>

#include "config.h"
#include "progress.h"
#include "run_report.h"
#include "slam_run.h"

namespace highwall::apps {
namespace {

struct BenchArguments {
  std::string data;
  std::vector<std::string> sequences;
  std::vector<std::string> features{"points", "lines", "both"};
  int runs = 5;
  bool json = false;
  bool dense = false;
  bool deterministic = false;
};

// One run of one sequence with one choice of features.
struct RunFigures {
  double ape = 0.0, rpe_1 = 0.0, rpe_30 = 0.0;  // RMSE [m]; negative: could not be computed
  double coverage = 0.0;                        // tracked frames over usable frames
  double lost = 0.0, keyframes = 0.0, points = 0.0, lines = 0.0;
  double tracking_ms = 0.0, tracking_p99_ms = 0.0, frame_p99_ms = 0.0;
  double mapping_ms = 0.0, orb_ms = 0.0;
  double ratio = 0.0;  // median tracking over median ORB
  double seconds = 0.0;
};

constexpr std::pair<const char*, double RunFigures::*> kFigures[] = {
    {"ape_rmse_m", &RunFigures::ape},
    {"rpe_1_frame_rmse_m", &RunFigures::rpe_1},
    {"rpe_30_frames_rmse_m", &RunFigures::rpe_30},
    {"coverage", &RunFigures::coverage},
    {"lost_frames", &RunFigures::lost},
    {"keyframes", &RunFigures::keyframes},
    {"points", &RunFigures::points},
    {"lines", &RunFigures::lines},
    {"tracking_ms", &RunFigures::tracking_ms},
    {"tracking_p99_ms", &RunFigures::tracking_p99_ms},
    {"frame_p99_ms", &RunFigures::frame_p99_ms},
    {"mapping_ms", &RunFigures::mapping_ms},
    {"orb_ms", &RunFigures::orb_ms},
    {"tracking_over_orb", &RunFigures::ratio},
    {"seconds", &RunFigures::seconds},
};

// cv::ORB on the images of a run, timed between its frames.
class OrbReference {
 public:
  void Measure(const cv::Mat& bgr) {
    cv::cvtColor(bgr, gray_, cv::COLOR_BGR2GRAY);
    const auto start = std::chrono::steady_clock::now();
    orb_->detectAndCompute(gray_, cv::noArray(), keypoints_, descriptors_);
    samples_.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
  }
  double MedianMs() const { return Summarize(samples_).median; }

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

SlamRunOptions OptionsFor(const std::string& features, const BenchArguments& arguments) {
  SlamRunOptions options;
  options.slam.frame.use_points = features != "lines";
  options.slam.frame.use_lines = features != "points";
  options.dense = arguments.dense;
  if (arguments.deterministic) options.slam = Deterministic(options.slam);
  return options;
}

RunFigures RunOnce(const TumDataset& dataset, const RgbdSensor& sensor,
                   const SlamRunOptions& options, const std::string& label) {
  OrbReference orb;
  Progress progress(label);
  const SlamRun run =
      RunSlam(dataset, sensor, options,
              [&](const FrameResult&, const RgbdImage& image, std::size_t done, std::size_t total) {
                orb.Measure(image.bgr);
                progress.Update(done, total);
              });
  RunFigures figures;
  if (const Trajectory* truth = dataset.groundtruth()) {
    figures.ape = RmseOr(-1.0, [&] { return AbsolutePoseError(*truth, run.trajectory); });
    figures.rpe_1 = RmseOr(-1.0, [&] { return RelativePoseError(*truth, run.trajectory); });
    figures.rpe_30 =
        RmseOr(-1.0, [&] { return RelativePoseError(*truth, run.trajectory, {.delta = 30.0}); });
  }
  figures.coverage =
      run.frames > 0 ? static_cast<double>(run.trajectory.size()) / static_cast<double>(run.frames)
                     : 0.0;
  figures.lost = static_cast<double>(run.lost.size());
  figures.keyframes = static_cast<double>(run.keyframes.size());
  figures.points = static_cast<double>(run.points);
  figures.lines = static_cast<double>(run.lines);
  figures.tracking_ms = run.times.tracking.median;
  figures.tracking_p99_ms = run.times.tracking.p99;
  figures.frame_p99_ms = run.times.frame.p99;
  figures.mapping_ms = run.times.mapping.median;
  figures.orb_ms = orb.MedianMs();
  figures.ratio = figures.tracking_ms / figures.orb_ms;
  figures.seconds = run.seconds;
  return figures;
}

RunFigures Medians(const std::vector<RunFigures>& runs) {
  RunFigures medians;
  for (const auto& [name, member] : kFigures) {
    std::vector<double> values;
    for (const RunFigures& run : runs) values.push_back(run.*member);
    std::sort(values.begin(), values.end());
    medians.*member = values[values.size() / 2];
  }
  return medians;
}

nlohmann::json ToJson(const RunFigures& figures) {
  nlohmann::json json;
  for (const auto& [name, member] : kFigures) json[name] = figures.*member;
  return json;
}

void PrintHeader() {
  fmt::print("{:<16} {:<7} {:>8} {:>8} {:>8} {:>6} {:>5} {:>4} {:>8} {:>8} {:>8} {:>6} {:>6}\n",
             "sequence", "uses", "APE m", "RPE1 m", "RPE30 m", "cover", "lost", "kf", "track ms",
             "p99 ms", "frame 99", "ORB ms", "ratio");
}

void PrintRow(const std::string& sequence, const std::string& features, const RunFigures& f) {
  fmt::print(
      "{:<16} {:<7} {:>8.5f} {:>8.5f} {:>8.5f} {:>6.3f} {:>5.0f} {:>4.0f} {:>8.2f} {:>8.2f} "
      "{:>8.2f} {:>6.2f} {:>6.2f}\n",
      sequence, features, f.ape, f.rpe_1, f.rpe_30, f.coverage, f.lost, f.keyframes, f.tracking_ms,
      f.tracking_p99_ms, f.frame_p99_ms, f.orb_ms, f.ratio);
}

int Run(const BenchArguments& arguments) {
  nlohmann::json report;
  report["versions"] = VersionsJson();
  report["runs"] = arguments.runs;
  if (!arguments.json) PrintHeader();
  for (const std::string& sequence : arguments.sequences) {
    const std::filesystem::path directory = std::filesystem::path(arguments.data) / sequence;
    const RgbdSensor sensor = ResolveConfig("", directory).config.sensor;
    const TumDataset dataset(directory, {.depth_factor = sensor.depth_factor,
                                         .width = sensor.camera.width,
                                         .height = sensor.camera.height});
    for (const std::string& features : arguments.features) {
      const SlamRunOptions options = OptionsFor(features, arguments);
      std::vector<RunFigures> runs;
      for (int i = 0; i < arguments.runs; ++i) {
        runs.push_back(RunOnce(dataset, sensor, options,
                               fmt::format("{} {} run {}", sequence, features, i + 1)));
      }
      const RunFigures medians = Medians(runs);
      if (!arguments.json) PrintRow(sequence, features, medians);
      nlohmann::json& entry = report["sequences"][sequence][features];
      entry["median"] = ToJson(medians);
      for (const RunFigures& run : runs) entry["runs"].push_back(ToJson(run));
    }
  }
  report["peak_memory_mib"] = PeakMemoryMib();
  if (arguments.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    fmt::print("medians of {} runs; peak memory {:.0f} MiB\n", arguments.runs, PeakMemoryMib());
  }
  return 0;
}

int Main(int argc, char** argv) {
  BenchArguments arguments;
  CLI::App app("Accuracy and speed of Highwall on sequences in the TUM RGB-D layout.",
               "highwall_bench_tum");
  app.add_option("--data", arguments.data, "Folder that holds the sequences")->required();
  app.add_option("--sequences", arguments.sequences, "Folders in it, separated by commas")
      ->delimiter(',')
      ->required();
  app.add_option("--runs", arguments.runs, "Runs of each")->check(CLI::PositiveNumber);
  app.add_option("--features", arguments.features, "points, lines, both; separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember({"points", "lines", "both"}));
  app.add_flag("--dense", arguments.dense, "Build cloud, octree and grid as well");
  app.add_flag("--deterministic", arguments.deterministic,
               "Everything on one thread, in lockstep, but for the decoding of images");
  app.add_flag("--json", arguments.json, "Print one JSON object");
  app.footer("Example: highwall_bench_tum --data datasets --sequences fr1_xyz,fr3_teddy --runs 5");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  try {
    return Run(arguments);
  } catch (const IoError& error) {
    fmt::print(stderr, "highwall_bench_tum: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "highwall_bench_tum: failed: {}\n", error.what());
    return 3;
  }
}

}  // namespace
}  // namespace highwall::apps

int main(int argc, char** argv) {
  return highwall::apps::Main(argc, argv);
}
