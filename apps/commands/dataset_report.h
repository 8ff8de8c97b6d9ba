#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/depth_identification.h>

namespace highwall::apps {

// Timing of one stream of a dataset. A gap is an interval of more than three times the median.
struct StreamReport {
  std::size_t count = 0;
  double duration = 0.0;  // [s] first to last
  double rate = 0.0;      // [1/s] of the median interval; 0 with fewer than two
  std::size_t gaps = 0;
  double longest_interval = 0.0;  // [s]
  Stamp longest_interval_at = 0;  // start of that interval
};

// Computes the report of stamps in ascending order.
StreamReport DescribeStamps(const std::vector<Stamp>& stamps);

struct GroundtruthReport {
  StreamReport stream;
  double path_length = 0.0;     // [m]
  double frames_covered = 0.0;  // share of the frames between its first and last stamp
};

struct ImuReport {
  std::string file;  // file name
  StreamReport stream;
  bool usable = true;  // false: the problems give the reason
};

// Calibration that fits the dataset. confidence: "given" (calibration.yaml), "stated" (by the
// recording itself, name: its file), "certain" (from the
// dataset's name), "unsure" (only the image size matches) or "none".
struct CalibrationReport {
  std::string name;  // argument for --config; empty if none fits
  std::string confidence;
  std::string reason;
};

// Depth sensor inferred from the depth images.
struct DepthReport {
  DepthStatistics statistics{};       // in stored units
  std::vector<DepthGuess> guesses{};  // most probable first; empty if inconclusive

  // "sure", "likely", "unsure" or, without a guess, "none".
  std::string Confidence() const;
  // Keeps only the guesses with this known factor [1/m], unless the images contradict it.
  void Believe(double depth_factor);
};

struct DatasetReport {
  std::filesystem::path directory;
  std::string format;  // DatasetReader::format
  std::string topics;  // of a bag, as --topics takes them; else empty
  StreamReport colour, depth, frames;
  double association_rate = 0.0;  // frames per colour image
  std::size_t usable_frames = 0;
  int width = 0, height = 0;    // [px] of the first usable frame
  double depth_factor = 0.0;    // [1/m] the one used
  double median_depth = 0.0;    // [m]
  double measured_share = 0.0;  // of all depth pixels
  DepthReport depth_images;
  std::size_t repeated_colour = 0;                // colour images identical to the previous one
  std::size_t dark_colour = 0, plain_colour = 0;  // as ImageSurvey
  std::optional<GroundtruthReport> groundtruth;
  std::optional<ImuReport> imu;            // gyroscope and accelerometer
  std::optional<ImuReport> accelerometer;  // accelerometer.txt, unusable without a gyroscope
  CalibrationReport calibration;
  std::vector<std::string> problems;  // most important first
};

// Reads and decodes every frame of a recording, in any format but those whose depth is computed
// (DatasetReader::fixed_camera). options: any_size is set. progress: called with the number of
// processed frames and the total. Throws IoError if the dataset cannot be used at all.
DatasetReport InspectDataset(const std::filesystem::path& directory, DatasetOptions options,
                             const std::function<void(std::size_t, std::size_t)>& progress);

// Returns one JSON object with the fields of DatasetReport by name.
std::string ToJson(const DatasetReport& report);
// Returns a human-readable summary of about a dozen lines.
std::string ToText(const DatasetReport& report);

}  // namespace highwall::apps
