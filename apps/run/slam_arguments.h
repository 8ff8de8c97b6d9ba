#pragma once

#include <optional>
#include <string>
#include <vector>

#include "run/opened_dataset.h"
#include "run/slam_run.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace highwall::apps {

enum class Features { kPoints, kLines, kBoth };

// Command-line arguments of `highwall slam`, and those that `highwall live` shares.
struct SlamArguments {
  std::string dataset, config, out, load_map, save_map, trace;
  std::string settings;          // a file
  std::vector<std::string> set;  // "path=value"
  // Override the settings if given.
  std::optional<Features> features;
  std::optional<PointDetector> point_detector;
  std::optional<LineDetector> detector;
  std::optional<Weighting> weighting;
  std::optional<MadRule> mad_rule;
  std::optional<bool> moving_objects;
  std::optional<FrameTimingMode> frame_timing;
  double resolution = OctomapBuilderOptions().resolution;
  double max_pair_difference = kMaxPairDifference;  // [s]
  double frame_rate = kFrameRate;                   // [Hz]
  BagTopics topics;
  std::string imu;  // --imu as given
  bool gps = true;
  bool deterministic = false;
  bool live = false;
  bool no_map = false;
  bool no_loops = false;
  bool adjust_all = false;
  bool localize = false;
  bool covariances = false;
  bool memory_report = false;
  bool json = false;
  bool report = false;
  std::string view;  // port of the live view; empty: none
  std::string view_address = "127.0.0.1";
  bool overwrite = false;
  bool strict = false;
  bool print_settings = false;  // and exit
};

// Adds the options to the command; `arguments` must outlive the parsing. CheckArguments() detects
// contradictions between them.
void AddSlamOptions(CLI::App* command, SlamArguments* arguments);
// Adds those that do not depend on where the images come from. unneeded: options that are not
// required for --print-settings.
void AddRunOptions(CLI::App* command, SlamArguments* arguments, std::vector<CLI::Option*> unneeded);
// Throws CLI::ValidationError.
void CheckArguments(const SlamArguments& arguments);

// Returns the options of the run, except for the IMU readings. The settings file is applied first,
// then the switches, then --set. Throws IoError for the file, InvalidArgument for an invalid
// setting.
SlamRunOptions MakeOptions(const SlamArguments& arguments);
// Whether to use the IMU readings of the dataset, if it has any.
bool WantsImu(const SlamArguments& arguments);
// Returns these readings; empty if there are none or they are unusable. Appends problems with them
// to `warnings`, one per line, and adds a finding to `verdict` if the IMU cannot be used. With
// --imu, throws IoError as LoadImu() and for a dataset without an IMU.
std::optional<ImuFeed> ReadImuFeed(const SlamArguments& arguments, const OpenedDataset& dataset,
                                   std::vector<std::string>* warnings, SensorVerdict* verdict);
// Returns the GPS data of the dataset; empty if there is none or it is disabled. It is not used in
// localization-only mode, where the map is fixed. with_imu: see LoadGps(), whose errors are thrown.
std::optional<GpsFeed> ReadGpsFeed(const SlamArguments& arguments, const OpenedDataset& dataset,
                                   bool with_imu);

}  // namespace highwall::apps
