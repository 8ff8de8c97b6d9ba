#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <highwall/frontend/system/slam_system.h>

namespace highwall::apps {

// Every option of SlamOptions has a path of its names, such as "tracker.pose.rounds": a setting.

// setting: "path=value". Throws InvalidArgument for a path that is none, naming the one that may be
// meant, and for a value of another type; whether it is in its range is left to CheckSettings().
void Set(const std::string& setting, SlamOptions* options);

// Those that a YAML file names, a section for each group; the others stay. Throws IoError naming
// the file and the line for an unknown key and a value of another type, and as CheckSettings().
void ReadSettings(const std::filesystem::path& path, SlamOptions* options);

// Throws InvalidArgument for a value out of its range, naming its path.
void CheckSettings(const SlamOptions& options);

// A file for ReadSettings() that says all of them, with units and ranges as comments.
std::string SettingsFile(const SlamOptions& options);

// Those that differ from the default, as in the file.
std::map<std::string, std::string> ChangedSettings(const SlamOptions& options);

}  // namespace highwall::apps
