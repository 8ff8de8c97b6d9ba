#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/calibration/imu_noise_estimation.h>
#include <highwall/frontend/input/bag_imu.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/imu_check.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/json_text.h"
#include "plots/allan_plot.h"
#include "run/output_checks.h"

namespace highwall::apps {
namespace {

struct ImuNoiseArguments {
  std::filesystem::path input;
  BagTopics topics;
  double from = 0.0;
  double to = std::numeric_limits<double>::infinity();
  bool assume_rest = false;
  bool json = false;
  std::optional<std::filesystem::path> plot;
};

constexpr double kLongestRecording = 1e9;  // [s]

// Without a video, readings of any time are accepted.
constexpr VideoSpan kAnyTime{std::numeric_limits<Stamp>::min(), std::numeric_limits<Stamp>::max()};

// Findings that concern readings at rest; the others concern a video.
bool Matters(ImuFindingKind kind) {
  return kind == ImuFindingKind::kNotFinite || kind == ImuFindingKind::kImpossible ||
         kind == ImuFindingKind::kOutOfOrder || kind == ImuFindingKind::kDuplicates ||
         kind == ImuFindingKind::kAccelerometerInG;
}

// Returns the file of the readings; a bag is it itself.
std::filesystem::path FileOf(const std::filesystem::path& input) {
  if (!std::filesystem::is_directory(input) || IsBag(input)) return input;
  const auto found = FindImuFile(input);
  if (!found) throw IoError(input, "holds no imu.csv, imu.txt, imu0/data.csv, mav0/imu0/data.csv");
  return *found;
}

// Returns the readings between --from and --to, in order, repaired.
std::vector<ImuSample> LoadSamples(const ImuNoiseArguments& arguments) {
  const std::filesystem::path file = FileOf(arguments.input);
  const ImuRecording recording =
      IsBag(file) ? ReadBagImu(file, arguments.topics) : ReadImu(file, kAnyTime);
  if (!recording.warning.empty()) PrintWarning("imu-noise", recording.warning);
  const auto [first, last] = std::ranges::minmax(recording.samples, {}, &ImuSample::stamp);
  const auto findings = CheckImu(recording.samples, {first.stamp, last.stamp});
  for (const ImuFinding& finding : findings) {
    if (finding.severity == ImuSeverity::kFatal) throw IoError(file, finding.text);
    if (Matters(finding.kind)) PrintWarning("imu-noise", file.string() + ": " + finding.text);
  }
  std::vector<ImuSample> samples = RepairImu(recording.samples, findings);
  if (samples.size() < 2) throw IoError(file, "has fewer than two readings that can be used");
  const Stamp start = samples.front().stamp;
  std::erase_if(samples, [&](const ImuSample& sample) {
    const double t = ToSeconds(sample.stamp - start);
    return t < arguments.from || t >= arguments.to;
  });
  if (samples.size() < 2) throw IoError(file, "has no readings between --from and --to");
  return samples;
}

struct Findings {
  std::vector<ImuSample> samples;
  std::vector<ReadingRange> rest;
  ImuNoiseEstimate estimate;

  double Seconds(const ReadingRange& range) const {
    return estimate.step * static_cast<double>(range.end - range.begin);
  }
  double Longest() const {
    double longest = 0.0;
    for (const ReadingRange& range : rest) longest = std::max(longest, Seconds(range));
    return longest;
  }
  double Sum() const {
    double sum = 0.0;
    for (const ReadingRange& range : rest) sum += Seconds(range);
    return sum;
  }
};

Findings Find(const ImuNoiseArguments& arguments) {
  Findings found;
  found.samples = LoadSamples(arguments);
  found.rest = arguments.assume_rest ? std::vector<ReadingRange>{{0, found.samples.size()}}
                                     : FindRest(found.samples);
  if (found.rest.empty()) {
    throw IoError(
        arguments.input,
        "the sensor is never at rest for three seconds (motion, vibration, missing readings, "
        "a rate below 20 Hz and a bias above 0.1 rad/s are no rest): record it lying "
        "still, or use all readings with --assume-rest");
  }
  const Progress progress("fitting");
  const std::optional<ImuNoiseEstimate> estimate = EstimateImuNoise(found.samples, found.rest);
  if (!estimate) {
    throw IoError(arguments.input,
                  "has too few readings at rest that change: 48 without a gap are the least");
  }
  found.estimate = *estimate;
  return found;
}

// Report values with the keys of calibration.yaml.
struct ReportLine {
  const char* key;
  const char* unit;
  const NoiseDensity NoiseDensities::*part;
  const SensorNoise ImuNoiseEstimate::*sensor;
};
constexpr ReportLine kLines[] = {
    {"gyroscope_noise", "rad/s/sqrt(Hz)", &NoiseDensities::white, &ImuNoiseEstimate::gyroscope},
    {"accelerometer_noise", "m/s^2/sqrt(Hz)", &NoiseDensities::white,
     &ImuNoiseEstimate::accelerometer},
    {"gyroscope_walk", "rad/s^2/sqrt(Hz)", &NoiseDensities::walk, &ImuNoiseEstimate::gyroscope},
    {"accelerometer_walk", "m/s^3/sqrt(Hz)", &NoiseDensities::walk,
     &ImuNoiseEstimate::accelerometer},
    {"gyroscope_instability", "rad/s", &NoiseDensities::instability, &ImuNoiseEstimate::gyroscope},
    {"accelerometer_instability", "m/s^2", &NoiseDensities::instability,
     &ImuNoiseEstimate::accelerometer},
};
constexpr std::size_t kOfCalibration = 4;  // the first of kLines

// Prints the observable values in the format of calibration.yaml, and the missing ones.
void PrintCalibration(const ImuNoiseEstimate& estimate) {
  std::string yaml, missing;
  for (const ReportLine& line : std::span(kLines).first(kOfCalibration)) {
    const NoiseDensity& density = (estimate.*line.sensor).all.*line.part;
    if (density.IsSeen()) {
      yaml += fmt::format("{}{}: {:.3g}", yaml.empty() ? "" : ", ", line.key, density.value);
    } else {
      missing += fmt::format("{}{}", missing.empty() ? "" : ", ", line.key);
    }
  }
  if (!yaml.empty()) fmt::print("for calibration.yaml, below imu:\n  {{{}}}\n", yaml);
  if (missing.empty()) return;
  fmt::print(
      "not observed: {}: white noise needs seconds of rest, a random walk minutes to hours; until "
      "then use the values of the data sheet\n",
      missing);
}

void PrintText(const ImuNoiseArguments& arguments, const Findings& found) {
  fmt::print("{}: {} readings, {:.1f} Hz; at rest for {:.1f} s, {:.1f} s at a time\n",
             arguments.input.string(), found.samples.size(), 1.0 / found.estimate.step, found.Sum(),
             found.Longest());
  fmt::print("  {:26} {:>9}  {:21} {:>9} {:>9} {:>9}\n", "", "all axes", "95 %", "x", "y", "z");
  for (const ReportLine& line : kLines) {
    const SensorNoise& noise = found.estimate.*line.sensor;
    const NoiseDensity& all = noise.all.*line.part;
    fmt::print("  {:26} {:>9}  {:21}", line.key,
               all.IsSeen() ? fmt::format("{:.2e}", all.value) : "unobserved",
               all.IsSeen() ? fmt::format("{:.2e} to {:.2e}", all.low, all.high)
                            : fmt::format("below {:.2e}", all.high));
    for (const NoiseDensities& axis : noise.axes) {
      fmt::print(" {:>9}",
                 (axis.*line.part).IsSeen() ? fmt::format("{:.2e}", (axis.*line.part).value) : "-");
    }
    fmt::print("  {}\n", line.unit);
  }
  PrintCalibration(found.estimate);
}

nlohmann::ordered_json NoiseJson(const NoiseDensity& density) {
  return {{"value", density.value}, {"low", density.low}, {"high", density.high}};
}

nlohmann::ordered_json NoiseJson(const SensorNoise& noise) {
  const auto densities = [](const NoiseDensities& d) {
    return nlohmann::ordered_json{{"white", NoiseJson(d.white)},
                                  {"instability", NoiseJson(d.instability)},
                                  {"walk", NoiseJson(d.walk)}};
  };
  nlohmann::ordered_json json = densities(noise.all);
  for (std::size_t i = 0; i < 3; ++i) json["axes"].push_back(densities(noise.axes[i]));
  for (const AllanPoint& point : noise.curve) {
    json["curve"].push_back(
        {{"tau_s", point.tau}, {"deviation", point.deviation}, {"freedom", point.freedom}});
  }
  return json;
}

void PrintJson(const Findings& found) {
  nlohmann::ordered_json rest = nlohmann::ordered_json::array();
  const Stamp start = found.samples.front().stamp;
  for (const ReadingRange& range : found.rest) {
    const double begin = ToSeconds(found.samples[range.begin].stamp - start);
    rest.push_back({begin, begin + found.Seconds(range)});
  }
  const nlohmann::ordered_json json = {{"readings", found.samples.size()},
                                       {"rate_hz", 1.0 / found.estimate.step},
                                       {"rest_s", rest},
                                       {"gyroscope", NoiseJson(found.estimate.gyroscope)},
                                       {"accelerometer", NoiseJson(found.estimate.accelerometer)}};
  fmt::print("{}\n", JsonText(json));
}

int RunImuNoise(const ImuNoiseArguments& arguments) {
  if (arguments.plot) RequireFile(*arguments.plot);
  const Findings found = Find(arguments);
  if (arguments.json) {
    PrintJson(found);
  } else {
    PrintText(arguments, found);
  }
  if (arguments.plot) {
    WriteAllanPlot(*arguments.plot, FileOf(arguments.input).filename().string(), found.estimate);
  }
  return kExitOk;
}

}  // namespace

void AddImuNoiseCommand(CLI::App& app, CommandAction& action) {
  CLI::App* command = app.add_subcommand(
      "imu-noise", "Noise densities of an IMU from readings at rest, by their Allan deviation.");
  const auto arguments = std::make_shared<ImuNoiseArguments>();
  command->add_option("input", arguments->input, "imu.csv, the folder of a dataset, or a bag")
      ->required();
  AddTopics(command, &arguments->topics);
  command->add_option("--from", arguments->from, "Only readings from here on [s], from the first")
      ->check(Between(0.0, kLongestRecording));
  command->add_option("--to", arguments->to, "Only readings before [s]")
      ->check(Between(0.0, kLongestRecording));
  command->add_flag("--assume-rest", arguments->assume_rest,
                    "All of them are at rest: do not look where");
  command->add_flag("--json", arguments->json, "One JSON object on standard output");
  command->add_option("--plot", arguments->plot, "Draw the Allan deviations: FILE.svg");
  command->footer(
      "Example: let the sensor lie still for an hour, away from fans and motors, then\n  highwall "
      "imu-noise imu.csv --plot noise.svg");
  command->callback([arguments, &action] {
    if (arguments->plot && arguments->plot->extension() != ".svg") {
      throw CLI::ValidationError("--plot", "writes SVG: the name must end in .svg");
    }
    if (arguments->to <= arguments->from) {
      throw CLI::ValidationError("--to", "must be above --from");
    }
    action = [arguments] { return RunImuNoise(*arguments); };
  });
}

}  // namespace highwall::apps
