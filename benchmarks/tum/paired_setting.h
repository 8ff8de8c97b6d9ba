#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>

#include "opened_dataset.h"
#include "slam_run.h"

// A setting is what one would write behind `highwall slam`: "--features points --no-loops".
namespace highwall::bench {

// What one run came to.
struct SettingRun {
  Trajectory trajectory;  // of the largest map, after the adjustment of everything where asked for
  std::size_t lost = 0;   // frames without a pose in any map
  double frame_ms = 0.0;  // all that a frame waits for, median
  std::string failure;    // why there is no trajectory, where that is known
};

// The dense map of a run: none, that of `highwall slam`, or one of the depths that the paper uses.
enum class MapChoice { kNone, kDefault, kPaper };
std::string ToString(MapChoice map);

// What is the same for all settings that are compared.
struct SettingMode {
  bool lockstep = true;  // one thread, the same result on every run
  MapChoice map = MapChoice::kNone;
};

// A sequence that can be run with a setting: one thread, in lockstep, no dense map.
class Setting {
 public:
  Setting() = default;
  virtual ~Setting() = default;
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

  // From frame `begin` to the end; the same result each time. label: of the progress. Throws what
  // the run throws.
  virtual SettingRun Run(std::size_t begin, const std::string& label) const = 0;
};

// Run by this build.
class OwnSetting final : public Setting {
 public:
  // directory: of a dataset that `highwall slam` takes. The setting is
  // one that RequireSetting() takes. Throws IoError for a dataset that cannot be used.
  OwnSetting(const std::string& setting, const std::filesystem::path& directory,
             const SettingMode& mode = {});

  const Dataset& images() const { return *dataset_.images; }
  // All that a run tells, in the mode of the constructor. on_image: called after each frame. Throws
  // what the run throws, and std::runtime_error where a part of it failed. stop: as
  // SlamRunOptions::stop.
  apps::SlamRun RunWhole(std::size_t begin, const std::string& label,
                         const std::function<void(const RgbdImage&)>& on_image = {},
                         const std::function<bool()>& stop = {}) const;
  SettingRun Run(std::size_t begin, const std::string& label) const override;

 private:
  apps::OpenedDataset dataset_;
  apps::SlamRunOptions options_;
};

// Run by the program `highwall` of any build, on a dataset that begins later: its first frames are
// left out of rgb.txt and depth.txt.
class ProgramSetting final : public Setting {
 public:
  // program: a path, or a name to look for in PATH. directory: in the layout of TUM RGB-D. Throws
  // IoError where the program cannot be run or does not know the setting, or rgb.txt or depth.txt
  // cannot be read.
  ProgramSetting(std::string program, const std::string& setting, std::filesystem::path directory);

  // What the program finds no poses in, or no usable data, is a run without a trajectory; throws
  // std::runtime_error where it fails.
  SettingRun Run(std::size_t begin, const std::string& label) const override;

 private:
  void RequireKnown() const;
  // The dataset from frame `begin` on.
  void WriteRest(std::size_t begin, const std::filesystem::path& folder) const;

  std::string program_;
  std::vector<std::string> switches_;
  std::filesystem::path directory_;
  std::vector<std::size_t> colour_, depth_;  // of each frame: its entry in the list
};

// Throws CLI::ValidationError, with the setting's name and itself, unless this build knows it.
void RequireSetting(const std::string& name, const std::string& setting,
                    const SettingMode& mode = {});

}  // namespace highwall::bench
