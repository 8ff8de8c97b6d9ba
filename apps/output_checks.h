#pragma once

#include <filesystem>

namespace highwall::apps {

// Before the work, not after it: a folder that can be written, or made where it is absent. Throws
// IoError otherwise.
void RequireFolder(const std::filesystem::path& out);
// The same for a file; that of a link is where it leads to.
void RequireFile(const std::filesystem::path& file);

}  // namespace highwall::apps
