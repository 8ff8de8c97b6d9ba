#include "commands/dataset_report.h"

#include <algorithm>
#include <fstream>
#include <memory>
#include <string_view>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/calibration/lens_pairs.h>
#include <highwall/frontend/input/depth_check.h>
#include <highwall/frontend/input/frame_reader.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/input/repeated_image.h>
#include <highwall/frontend/input/stamp_check.h>
#include <highwall/frontend/input/tum_dataset.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

#include "run/config.h"
#include "run/image_survey.h"
#include "run/imu_input.h"

namespace highwall::apps {
namespace {

std::vector<Stamp> Stamps(const std::vector<TumImageFile>& files) {
  std::vector<Stamp> stamps;
  for (const TumImageFile& file : files) stamps.push_back(file.stamp);
  return stamps;
}

std::vector<Stamp> Stamps(const Dataset& dataset) {
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < dataset.size(); ++i) stamps.push_back(dataset.stamp(i));
  return stamps;
}

GroundtruthReport DescribeGroundtruth(const Trajectory& trajectory, const Dataset& dataset) {
  std::vector<Stamp> stamps;
  GroundtruthReport report;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    stamps.push_back(trajectory[i].stamp);
    if (i > 0) report.path_length += (trajectory[i].pose.p() - trajectory[i - 1].pose.p()).norm();
  }
  report.stream = DescribeStamps(stamps);
  std::size_t covered = 0;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    if (dataset.stamp(i) >= stamps.front() && dataset.stamp(i) <= stamps.back()) ++covered;
  }
  report.frames_covered = static_cast<double>(covered) / static_cast<double>(dataset.size());
  return report;
}

// Appends problems to report->problems.
std::optional<ImuReport> DescribeImu(const Dataset& dataset,
                                     const std::optional<ImuCalibration>& calibration,
                                     DatasetReport* report) {
  try {
    const std::optional<ImuInput> imu = LoadImu(dataset, calibration);
    if (!imu) return std::nullopt;
    report->problems.insert(report->problems.end(), imu->warnings.begin(), imu->warnings.end());
    std::vector<Stamp> stamps;
    for (const ImuSample& sample : imu->samples) stamps.push_back(sample.stamp);
    return ImuReport{imu->file.filename().string(), DescribeStamps(stamps), imu->IsUsable()};
  } catch (const IoError& error) {  // the images can still be described
    report->problems.push_back(error.what());
    return ImuReport{dataset.imu_file()->filename().string(), {}, false};
  }
}

// Uses the stamps in the first column; lines that do not begin with a stamp are comments or
// headings.
std::optional<ImuReport> DescribeAccelerometer(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Stamp> stamps;
  for (std::string line; std::getline(file, line);) {
    const std::string_view field = std::string_view(line).substr(0, line.find_first_of(" \t\r"));
    if (const std::optional<Stamp> stamp = ParseStamp(field)) stamps.push_back(*stamp);
  }
  if (stamps.empty()) return std::nullopt;
  return ImuReport{path.filename().string(), DescribeStamps(stamps), false};
}

constexpr double kSure = 0.9, kLikely = 0.7, kContradicted = 0.02;  // probabilities

std::string Short(double value) {
  return RoundedText(value, 4);
}

std::string Describe(const DepthGuess& guess) {
  return std::string(guess.profile->name) + " with depth factor " + Short(guess.depth_factor);
}

// Without a calibration file, the images identify the depth sensor, but not the lens.
CalibrationReport CalibrationOf(const DepthReport& depth, bool vga) {
  const DepthGuess* guess = depth.guesses.empty() ? nullptr : &depth.guesses.front();
  const bool as_tum = guess == nullptr || guess->probability < kLikely ||
                      (guess->profile->name == "kinect1" && guess->depth_factor == 5000.0);
  if (vga && as_tum) {
    return {
        "tum3", "unsure",
        "640 x 480 is the size of a Kinect, whose undistorted images tum3 describes; the images "
        "do not reveal the lens"};
  }
  if (guess == nullptr || guess->probability < kLikely) {
    return {"", "none", "no preset has images of this size: write a calibration.yaml"};
  }
  return {"", "none",
          "the depth is that of another sensor: write a calibration.yaml with sensor: " +
              std::string(guess->profile->name) + ", depth_factor: " + Short(guess->depth_factor) +
              " and the lens"};
}

CalibrationReport FindCalibration(const std::filesystem::path& directory, int width, int height,
                                  const DepthReport& depth) {
  const std::filesystem::path file = CalibrationFile(directory);
  if (std::filesystem::exists(file)) {
    return {file.string(), "given", "calibration.yaml is in the folder"};
  }
  const bool vga = width == 640 && height == 480;
  const std::string preset = PresetFromName(directory);
  if (!preset.empty() && vga)
    return {preset, "certain", "the name of the dataset names the sensor"};
  return CalibrationOf(depth, vga);
}

std::string Seconds(double value) {
  std::string text = FormatStamp(FromSeconds(value));
  return text.substr(0, text.find('.') + 4) + " s";
}

void AddGapProblem(const char* what, const StreamReport& stream, DatasetReport* report) {
  if (stream.gaps == 0) return;
  report->problems.push_back(std::to_string(stream.gaps) + (stream.gaps == 1 ? " gap" : " gaps") +
                             " between " + what + ", the longest of " +
                             Seconds(stream.longest_interval) + " at " +
                             FormatStamp(stream.longest_interval_at));
}

void AddProblems(const Dataset& dataset, double max_pair_difference, DatasetReport* report) {
  const std::vector<std::string>& warnings = dataset.warnings();
  report->problems.insert(report->problems.begin(), warnings.begin(), warnings.end());
  for (const Dataset::Problem& problem : dataset.problems()) {
    report->problems.push_back(problem.what);
  }
  const std::size_t lonely_colour = report->colour.count - report->frames.count;
  const std::size_t lonely_depth = report->depth.count - report->frames.count;
  if (lonely_colour + lonely_depth > 0) {
    report->problems.push_back(
        std::to_string(lonely_colour) + " colour and " + std::to_string(lonely_depth) +
        " depth images have no partner within " + Short(1e3 * max_pair_difference) + " ms");
  }
  for (const StampFinding& finding : CheckStamps(dataset)) {
    report->problems.push_back(finding.text + ": " + finding.remedy);
  }
  AddGapProblem("frames", report->frames, report);
  if (report->repeated_colour > 0) {
    report->problems.push_back(std::to_string(report->repeated_colour) +
                               " colour images repeat the one before");
  }
  if (report->groundtruth && report->groundtruth->frames_covered < 1.0) {
    report->problems.push_back("ground truth does not span all frames");
  }
}

void AddSizeProblem(const PinholeCamera& camera, DatasetReport* report) {
  if (camera.width == report->width && camera.height == report->height) return;
  report->problems.push_back("images are " + std::to_string(report->width) + " x " +
                             std::to_string(report->height) + ", but the calibration is for " +
                             std::to_string(camera.width) + " x " + std::to_string(camera.height));
}

// Whether the images are likely of a sensor with another depth factor.
bool NamesAnotherFactor(const DepthReport& depth, double depth_factor) {
  return !depth.guesses.empty() && depth.guesses.front().probability >= kLikely &&
         ProbabilityOfFactor(depth.guesses, depth_factor) < kContradicted;
}

// Reports contradictions between the depth images and the assumed sensor.
void AddDepthProblems(const RgbdSensor& sensor, DatasetReport* report) {
  const DepthReport& depth = report->depth_images;
  if (depth.guesses.empty()) return;
  const DepthGuess& best = depth.guesses.front();
  const double factor = sensor.depth_factor;
  if (NamesAnotherFactor(depth, factor)) {
    report->problems.push_back("the depth looks like " + Describe(best) +
                               ", but the calibration says " + Short(factor));
  }
  const DepthStatistics& statistics = depth.statistics;
  const double near = statistics.quantiles[0] / factor, far = statistics.quantiles[4] / factor;
  if (near < sensor.min_depth || far > sensor.max_depth) {
    report->problems.push_back("more than 5 % of the depth readings lie outside of " +
                               Short(sensor.min_depth) + " to " + Short(sensor.max_depth) +
                               " m, the range of the sensor");
  }
  std::size_t noisy = 0;
  for (const DepthGrain& grain : statistics.grain) {
    constexpr double kNoisier = 2.0;
    const double sigma = sensor.depth_noise.Sigma(grain.depth / factor);
    noisy += grain.sigma / factor > kNoisier * sigma ? 1 : 0;
  }
  if (2 * noisy > statistics.grain.size()) {
    report->problems.push_back(
        "the depth is more than twice as noisy as depth_noise says at most depths");
  }
}

// Returns the sensor with what another one states about noise, range and time of its depth.
RgbdSensor WithStatedDepth(RgbdSensor sensor, const RgbdSensor& stated) {
  sensor.depth_noise = stated.depth_noise;
  sensor.min_depth = stated.min_depth;
  sensor.max_depth = stated.max_depth;
  sensor.timing = stated.timing;
  return sensor;
}

// Appends what CheckDepth() finds, except for a depth factor that AddDepthProblems() or a warning
// of the dataset names.
void AddFindings(const Dataset& dataset, const RgbdSensor& sensor, DatasetReport* report) {
  const bool named = NamesAnotherFactor(report->depth_images, sensor.depth_factor) ||
                     std::ranges::any_of(dataset.warnings(), [](const std::string& warning) {
                       return warning.find("depth factor") != std::string::npos;
                     });
  for (const SensorFinding& finding : CheckDepth(dataset, sensor)) {
    if (named && finding.fault == SensorFault::kDepthScale) continue;
    report->problems.push_back(Line(finding));
  }
}

// Reads all frames, and the depth of an evenly spaced subset.
void ReadFrames(const Dataset& dataset, const RgbdSensor& sensor,
                const std::function<void(std::size_t, std::size_t)>& progress,
                DatasetReport* report) {
  constexpr std::size_t kSurveyed = 60;
  const std::size_t stride = std::max<std::size_t>(1, dataset.size() / kSurveyed);
  FrameReader reader(dataset);
  RepeatedImage repeated;
  ImageSurvey images;
  DepthSurvey survey;
  cv::Size size;
  std::size_t measured = 0, pixels = 0;
  while (const std::optional<RgbdImage> image = reader.Next()) {
    if (report->usable_frames == 0) size = image->depth.size();
    if (image->depth.size() == size && report->usable_frames % stride == 0) {
      survey.Add(StoredDepth(image->depth, sensor));
    }
    ++report->usable_frames;
    report->repeated_colour += repeated.Update(image->bgr) ? 1 : 0;
    images.Add(image->bgr);
    measured += static_cast<std::size_t>(cv::countNonZero(image->depth));
    pixels += image->depth.total();
    progress(reader.position(), reader.count());
  }
  report->dark_colour = images.dark();
  report->plain_colour = images.plain();
  report->problems = images.Problems();
  report->width = size.width;
  report->height = size.height;
  report->measured_share = static_cast<double>(measured) / static_cast<double>(pixels);
  report->depth_images.statistics = survey.Describe();
  report->depth_images.guesses =
      IdentifyDepthSensor(report->depth_images.statistics, sensor.depth_factor);
}

// Returns the reader of the recording. Throws IoError for a format whose depth is computed, before
// anything in it is read: the report is of the images that a camera gave.
const DatasetReader* ReaderOf(const std::filesystem::path& directory) {
  const DatasetReader* const reader = FindDatasetReader(directory);
  if (reader == nullptr || !reader->fixed_camera) return reader;
  throw IoError(directory, "is of " + std::string(reader->format) +
                               "'s layout, which info does not read; highwall slam does");
}

// Describes colour and depth images: as they are listed, or those of the frames.
void DescribeStreams(const Dataset& dataset, DatasetReport* report) {
  report->frames = DescribeStamps(Stamps(dataset));
  if (const auto* const listed = dynamic_cast<const TumDataset*>(&dataset)) {
    report->colour = DescribeStamps(Stamps(listed->colour_files()));
    report->depth = DescribeStamps(Stamps(listed->depth_files()));
  } else {
    std::vector<Stamp> colour = Stamps(dataset);
    const std::vector<Stamp> alone = dataset.stamps_without_depth();
    colour.insert(colour.end(), alone.begin(), alone.end());
    std::ranges::sort(colour);
    report->colour = DescribeStamps(colour);
    report->depth = report->frames;
  }
  report->association_rate =
      static_cast<double>(report->frames.count) / static_cast<double>(report->colour.count);
}

}  // namespace

std::string DepthReport::Confidence() const {
  if (guesses.empty()) return "none";
  const double probability = guesses.front().probability;
  return probability >= kSure ? "sure" : probability >= kLikely ? "likely" : "unsure";
}

void DepthReport::Believe(double depth_factor) {
  const double probability = ProbabilityOfFactor(guesses, depth_factor);
  if (probability < kContradicted) return;
  std::erase_if(guesses, [&](const DepthGuess& guess) {
    return ProbabilityOfFactor({guess}, depth_factor) == 0.0;
  });
  for (DepthGuess& guess : guesses) guess.probability /= probability;
}

StreamReport DescribeStamps(const std::vector<Stamp>& stamps) {
  StreamReport report{.count = stamps.size()};
  if (stamps.size() < 2) return report;
  std::vector<Stamp> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i) intervals.push_back(stamps[i] - stamps[i - 1]);
  const auto longest = std::max_element(intervals.begin(), intervals.end());
  report.longest_interval = ToSeconds(*longest);
  report.longest_interval_at = stamps[static_cast<std::size_t>(longest - intervals.begin())];
  report.duration = ToSeconds(stamps.back() - stamps.front());
  const Stamp median = UpperMedian(intervals);
  report.rate = median > 0 ? 1.0 / ToSeconds(median) : 0.0;
  report.gaps = static_cast<std::size_t>(
      std::count_if(intervals.begin(), intervals.end(),
                    [median](Stamp interval) { return interval > 3 * median; }));
  return report;
}

DatasetReport InspectDataset(const std::filesystem::path& directory, DatasetOptions options,
                             const std::function<void(std::size_t, std::size_t)>& progress) {
  const DatasetReader* const reader = ReaderOf(directory);
  options.any_size = true;
  const bool states_camera = reader != nullptr && !reader->calibration.empty();
  std::optional<RunConfig> config;  // whose camera is checked, and whose depth factor is used
  std::string note;
  if (!states_camera || std::filesystem::exists(CalibrationFile(directory))) {
    if (std::optional<ResolvedConfig> own = OwnConfig(directory, options)) {
      config = std::move(own->config);
      note = std::move(own->note);
    }
  }
  // The statistics are those of the stored depth, so nothing but its unit is taken from the sensor.
  RgbdSensor sensor;
  if (config) sensor.depth_factor = config->sensor.depth_factor;
  const bool is_given = config.has_value();
  const std::unique_ptr<const Dataset> opened = OpenDataset(
      directory, states_camera && !is_given ? std::nullopt : std::optional(sensor), options);
  if (!is_given && opened->calibration() != nullptr) {
    config = *opened->calibration();
    sensor.depth_factor = config->sensor.depth_factor;
  }
  const Dataset& dataset = *opened;

  DatasetReport report;
  report.directory = directory;
  report.format = reader->format;
  report.topics = ToText(dataset.topics());
  DescribeStreams(dataset, &report);
  report.depth_factor = sensor.depth_factor;

  ReadFrames(dataset, sensor, progress, &report);
  AddFindings(dataset, config ? WithStatedDepth(sensor, config->sensor) : sensor, &report);
  const DepthReport& depth = report.depth_images;
  const auto* const listed = dynamic_cast<const TumDataset*>(&dataset);
  report.median_depth = listed != nullptr ? listed->median_depth()
                                          : depth.statistics.quantiles[2] / sensor.depth_factor;
  if (config) {
    report.depth_images.Believe(sensor.depth_factor);
  } else if (!depth.guesses.empty()) {
    const double factor = depth.guesses.front().depth_factor;
    if (ProbabilityOfFactor(depth.guesses, factor) >= kSure) {
      report.median_depth *= report.depth_factor / factor;
      report.depth_factor = factor;
    }
  }

  if (dataset.groundtruth() != nullptr) {
    report.groundtruth = DescribeGroundtruth(*dataset.groundtruth(), dataset);
  }
  report.accelerometer = DescribeAccelerometer(directory / "accelerometer.txt");
  report.calibration = !is_given && config
                           ? CalibrationReport{std::string(reader->calibration), "stated",
                                               "the recording states its camera"}
                           : FindCalibration(directory, report.width, report.height, depth);
  if (!note.empty()) report.calibration.reason = note;
  AddProblems(dataset, options.max_stamp_difference, &report);
  if (config) {
    AddSizeProblem(config->sensor.camera, &report);
    AddDepthProblems(config->sensor, &report);
    if (const auto finding = CheckPairs(dataset, config->sensor))
      report.problems.push_back(Line(*finding));
  }
  report.imu = DescribeImu(dataset, config ? config->imu : std::nullopt, &report);
  return report;
}

}  // namespace highwall::apps
