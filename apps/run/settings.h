#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <highwall/frontend/system/slam_system.h>

namespace highwall::apps {

// Every option of SlamOptions is a setting, addressed by the path of its names, such as
// "tracker.moving.enabled".

// setting: "path=value". Throws InvalidArgument for an unknown path, suggesting a similar one, and
// for a value of another type; CheckSettings() checks the range.
void Set(const std::string& setting, SlamOptions* options);

// Reads settings from a YAML file with a section for each group; the others keep their values.
// Throws IoError naming the file and the line for an unknown key or a value of another type, and as
// CheckSettings().
void ReadSettings(const std::filesystem::path& path, SlamOptions* options);

// Throws InvalidArgument for a value out of its range, naming its path.
void CheckSettings(const SlamOptions& options);

// Returns a file for ReadSettings() with all settings, and their units and ranges as comments.
std::string SettingsFile(const SlamOptions& options);

// Returns the settings that differ from the default, formatted as in the file.
std::map<std::string, std::string> ChangedSettings(const SlamOptions& options);

}  // namespace highwall::apps
