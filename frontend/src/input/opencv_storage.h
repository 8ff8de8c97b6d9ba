#pragma once

#include <filesystem>
#include <string>

#include "input/foreign_map.h"

namespace highwall {

// Whether a text is that of OpenCV's FileStorage in XML.
bool IsOpencvXml(const std::string& text);

// Reads the text of a file as OpenCV's FileStorage writes it: YAML under the directive %YAML:1.0,
// which is not that of YAML itself, or XML. Members of an element of XML have its line. Throws
// IoError naming the line if it is neither.
ForeignMap ParseOpencvStorage(const std::filesystem::path& path, const std::string& text);

}  // namespace highwall
