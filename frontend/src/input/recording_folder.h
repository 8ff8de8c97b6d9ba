#pragma once

#include <filesystem>

namespace highwall {

// Throws IoError if there is no such folder, or if it is empty.
void RequireRecordingFolder(const std::filesystem::path& folder);

}  // namespace highwall
