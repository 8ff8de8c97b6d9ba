#pragma once

#include <filesystem>
#include <string>

namespace highwall {

// A text file in UTF-8 with "\n" or "\r\n" behind its lines, whatever wrote it: a byte-order mark
// is left out, UTF-16 (of PowerShell, Excel) converted, and a lone "\r" between lines replaced.
// Throws IoError if the file is missing, a folder or cannot be read.
std::string ReadTextFile(const std::filesystem::path& path);

}  // namespace highwall
