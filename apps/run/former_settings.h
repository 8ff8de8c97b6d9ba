#pragma once

#include <functional>
#include <string>

#include <highwall/frontend/input/yaml_reader.h>

namespace highwall::apps {

// Settings of version 0.2 that have another name now, or are gone. Settings files of that version
// are accepted until version 0.4: a former name as it is, and a setting that is gone if it has the
// value that it had by default.

// Returns the current path of a setting.
std::string CurrentPath(const std::string& path);

// Throws InvalidArgument that says why if the setting is gone.
void RefuseFormer(const std::string& path);

// Calls read(section, key, path) for each renamed setting that the file holds by its former name:
// path is the current one. Throws IoError with the line of a setting that is gone, unless it has
// its former default.
void ReadFormerSettings(YamlReader& file,
                        const std::function<void(YamlReader& section, const std::string& key,
                                                 const std::string& path)>& read);

}  // namespace highwall::apps
