#pragma once

#include <filesystem>
#include <string>

namespace [[gnu::visibility("default")]] highwall {

// Reads a text file as UTF-8 with line ends "\n" or "\r\n", whatever program wrote it: a byte-order
// mark is removed, UTF-16 (of PowerShell, Excel) converted, and a lone "\r" between lines replaced.
// Throws IoError if the file is missing, a folder or cannot be read.
std::string ReadTextFile(const std::filesystem::path& path);

}  // namespace highwall
