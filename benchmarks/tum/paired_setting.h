#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>

#include "run/opened_dataset.h"
#include "run/slam_run.h"

// A setting is a list of arguments of `highwall slam`: "--features points --no-loops".
namespace highwall::bench {

// Result of one run.
struct SettingRun {
  Trajectory trajectory;  // of the largest map, after the final adjustment if enabled
  std::size_t lost = 0;   // frames without a pose in any map
  double frame_ms = 0.0;  // total latency of a frame, median
  std::string failure;    // why there is no trajectory, if known
};

// Dense map of a run: none, that of `highwall slam`, or one with the depth range of the paper.
enum class MapChoice { kNone, kDefault, kPaper };
std::string ToString(MapChoice map);

// Mode common to all compared settings.
struct SettingMode {
  bool synchronous = true;  // one thread, the same result on every run
  MapChoice map = MapChoice::kNone;
  double live_rate = 0.0;  // > 0: frames come at so many times the pace of their stamps
};

// A sequence that can be run with a setting: one thread, in synchronous mode, no dense map.
class Setting {
 public:
  Setting() = default;
  virtual ~Setting() = default;
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

  // Runs from frame `begin` to the end; the same result each time. label: of the progress. Throws
  // the errors of the run.
  virtual SettingRun Run(std::size_t begin, const std::string& label) const = 0;
};

// Run by this build.
class OwnSetting final : public Setting {
 public:
  // directory: of a dataset that `highwall slam` accepts. The setting must satisfy
  // RequireSetting(). Throws IoError for an unusable dataset.
  OwnSetting(const std::string& setting, const std::filesystem::path& directory,
             const SettingMode& mode = {});

  const Dataset& images() const { return *dataset_.images; }
  // Whether frames arrive at the pace of their stamps.
  bool is_live() const { return options_.live; }
  // Returns the complete result of a run in the mode of the constructor. stop: as
  // SlamRunOptions::stop. Throws the errors of the run, and std::runtime_error if a part of it
  // failed.
  apps::SlamRun RunWhole(std::size_t begin, const std::string& label,
                         const std::function<bool()>& stop = {}) const;
  SettingRun Run(std::size_t begin, const std::string& label) const override;

 private:
  apps::OpenedDataset dataset_;
  apps::SlamRunOptions options_;
};

// Run by the program `highwall` of any build, on a dataset that begins later: its first frames are
// omitted from rgb.txt and depth.txt.
class ProgramSetting final : public Setting {
 public:
  // program: a path, or a name to look up in PATH. directory: in the layout of TUM RGB-D. Throws
  // IoError if the program cannot be run or does not know the setting, or if rgb.txt or depth.txt
  // cannot be read.
  ProgramSetting(std::string program, const std::string& setting, std::filesystem::path directory);

  // If the program finds no poses, or no usable data, the run has no trajectory; throws
  // std::runtime_error if it fails.
  SettingRun Run(std::size_t begin, const std::string& label) const override;

 private:
  void RequireKnown() const;
  // Writes the dataset from frame `begin` on.
  void WriteRest(std::size_t begin, const std::filesystem::path& folder) const;

  std::string program_;
  std::vector<std::string> switches_;
  std::filesystem::path directory_;
  std::vector<std::size_t> colour_, depth_;  // of each frame: its index in the list
};

// Throws CLI::ValidationError with the setting and its name unless this build supports it.
void RequireSetting(const std::string& name, const std::string& setting,
                    const SettingMode& mode = {});

}  // namespace highwall::bench
