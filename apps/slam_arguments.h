#pragma once

#include <string>

#include "slam_run.h"

namespace CLI {
class App;
}

namespace highwall::apps {

enum class Features { kPoints, kLines, kBoth };

// The switches of `highwall slam`.
struct SlamArguments {
  std::string dataset, config, out, load_map, save_map;
  Features features = Features::kBoth;
  LineDetector detector = LineExtractorOptions().detector;
  Weighting weighting = MeasurementOptions().weighting;
  MadRule mad_rule = LineMatcherOptions().mad_rule;
  double resolution = OctomapBuilderOptions().resolution;
  std::string imu;  // --imu as given
  bool moving_objects = true;
  bool deterministic = false;
  bool live = false;
  bool no_map = false;
  bool no_loops = false;
  bool adjust_all = false;
  bool localize = false;
  bool json = false;
};

// Adds them to the command; `arguments` must outlive the parsing. Contradictions between them are
// left to CheckArguments().
void AddSlamOptions(CLI::App* command, SlamArguments* arguments);
// Throws CLI::ValidationError.
void CheckArguments(const SlamArguments& arguments);

// What the run is told to do by them: all of it but the readings of the IMU.
SlamRunOptions MakeOptions(const SlamArguments& arguments);
// Whether the readings of the dataset's IMU are wanted, where it has one.
bool WantsImu(const SlamArguments& arguments);

}  // namespace highwall::apps
