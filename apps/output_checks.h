#pragma once

#include <filesystem>
#include <initializer_list>

#include "folder_content.h"

namespace highwall::apps {

// Before the work, not after it: a folder that can be written, or made where it is absent. Throws
// IoError otherwise.
void RequireFolder(const std::filesystem::path& out);
// Files of a run are removed and replaced by their names, which other programs and recordings use
// as well (trajectory.txt, cloud.ply). Throws IoError as RequireFolder and, without --overwrite,
// where `out` holds what is not among `allowed`.
void RequireOwnFolder(const std::filesystem::path& out,
                      std::initializer_list<FolderContent> allowed, bool overwrite);
// The same for the folder of a run.
void RequireRunFolder(const std::filesystem::path& out, bool overwrite);
// Of the commands that take it.
inline constexpr const char* kOverwriteHelp =
    "Write to a folder that holds other files as well; those with names of results are replaced";

// As RequireFolder, for a file; that of a link is where it leads to.
void RequireFile(const std::filesystem::path& file);

}  // namespace highwall::apps
