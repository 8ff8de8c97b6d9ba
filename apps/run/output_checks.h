#pragma once

#include <filesystem>
#include <initializer_list>

#include "run/folder_content.h"

namespace highwall::apps {

// Checks before the computation that a folder is writable, or can be created if it is missing.
// Throws IoError otherwise.
void RequireFolder(const std::filesystem::path& out);
// Checks that the results may be written to `out`. Files with the names of results are removed and
// replaced, and other programs and recordings use these names as well (trajectory.txt, cloud.ply).
// Throws IoError as RequireFolder() and, without --overwrite, if the content of `out` is not among
// `allowed`.
void RequireOwnFolder(const std::filesystem::path& out,
                      std::initializer_list<FolderContent> allowed, bool overwrite);
// Does the same for the folder of a run.
void RequireRunFolder(const std::filesystem::path& out, bool overwrite);
// Help text of --overwrite.
inline constexpr const char* kOverwriteHelp =
    "Write to a folder that holds other files as well; those with names of results are replaced";

// Like RequireFolder(), for a file; a symbolic link is followed.
void RequireFile(const std::filesystem::path& file);

}  // namespace highwall::apps
