#pragma once

#include <optional>
#include <string>
#include <vector>

#include "opened_dataset.h"
#include "slam_run.h"

namespace CLI {
class App;
}

namespace highwall::apps {

enum class Features { kPoints, kLines, kBoth };

// The switches of `highwall slam`.
struct SlamArguments {
  std::string dataset, config, out, load_map, save_map;
  std::string settings;          // a file
  std::vector<std::string> set;  // "path=value"
  // What the settings say, unless given.
  std::optional<Features> features;
  std::optional<PointDetector> point_detector;
  std::optional<LineDetector> detector;
  std::optional<Weighting> weighting;
  std::optional<MadRule> mad_rule;
  std::optional<bool> moving_objects;
  std::optional<FrameTimingMode> frame_timing;
  std::optional<InertialCoupling> coupling;
  double resolution = OctomapBuilderOptions().resolution;
  double max_pair_difference = kMaxPairDifference;  // [s]
  std::string imu;                                  // --imu as given
  bool gps = true;
  bool deterministic = false;
  bool live = false;
  bool no_map = false;
  bool no_loops = false;
  bool adjust_all = false;
  bool localize = false;
  bool json = false;
  bool report = false;
  bool overwrite = false;
  bool print_settings = false;  // and nothing else
};

// Adds them to the command; `arguments` must outlive the parsing. Contradictions between them are
// left to CheckArguments().
void AddSlamOptions(CLI::App* command, SlamArguments* arguments);
// Throws CLI::ValidationError.
void CheckArguments(const SlamArguments& arguments);

// What the run is told to do by them: all of it but the readings of the IMU. The file of settings
// comes first, then the switches, then --set. Throws IoError for the file, InvalidArgument for a
// setting that cannot be.
SlamRunOptions MakeOptions(const SlamArguments& arguments);
// Whether the readings of the dataset's IMU are wanted, where it has one.
bool WantsImu(const SlamArguments& arguments);
// These readings; empty where there are none or they cannot be used. Adds what is wrong with them
// to `warnings`, a line each. Throws IoError as LoadImu() and for a dataset without an IMU, both
// where --imu asks for one.
std::optional<ImuFeed> ReadImuFeed(const SlamArguments& arguments, const OpenedDataset& dataset,
                                   std::vector<std::string>* warnings);
// What the dataset's GPS measured; empty where there is none, or none is wanted: nothing moves a
// map that a run is only localized in. with_imu: LoadGps(), whose errors it throws.
std::optional<GpsFeed> ReadGpsFeed(const SlamArguments& arguments, const OpenedDataset& dataset,
                                   bool with_imu);

}  // namespace highwall::apps
