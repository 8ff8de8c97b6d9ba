#include "run/output_checks.h"

#include <unistd.h>

#include <algorithm>
#include <string>
#include <system_error>

#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

void RequireNoLinkToNowhere(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error) || fs::exists(path, error)) return;
  throw IoError(path, "is a link to " + fs::read_symlink(path, error).string() +
                          ", which is not there: make that folder, or remove the link");
}

}  // namespace

void RequireOwnFolder(const fs::path& out, std::initializer_list<FolderContent> allowed,
                      bool overwrite) {
  RequireFolder(out);
  if (overwrite) return;
  const FolderContent content = ContentOf(out);
  if (std::ranges::find(allowed, content) != allowed.end()) return;
  const char* const what =
      content == FolderContent::kRun    ? "holds a run, whose maps are of another world"
      : content == FolderContent::kMaps ? "holds the maps of highwall map"
                                        : "holds files that are not of a run of Highwall";
  throw IoError(out, std::string(what) +
                         ": choose another folder, or give --overwrite to replace those that have "
                         "the names of results");
}

void RequireRunFolder(const fs::path& out, bool overwrite) {
  using Content = FolderContent;
  RequireOwnFolder(out, {Content::kNothing, Content::kRun, Content::kUnfinished}, overwrite);
}

void RequireFolder(const fs::path& out) {
  std::error_code error;
  if (fs::is_directory(out, error)) {
    if (::access(out.c_str(), W_OK | X_OK) != 0) throw IoError(out, "cannot be written to");
    return;
  }
  fs::path above = fs::absolute(out, error);
  if (!above.has_filename()) above = above.parent_path();  // "out/" -> "out"
  RequireNoLinkToNowhere(above);
  if (fs::exists(above, error)) throw IoError(out, "is a file, but --out needs a folder");
  do {
    above = above.parent_path();
    RequireNoLinkToNowhere(above);
  } while (above.has_relative_path() && !fs::exists(above, error));
  if (!fs::is_directory(above, error) || ::access(above.c_str(), W_OK | X_OK) != 0) {
    throw IoError(out, "cannot be made: no folder can be made in " + above.string());
  }
}

void RequireFile(const fs::path& file) {
  RequireFolder(fs::weakly_canonical(fs::absolute(file)).parent_path());
  std::error_code error;
  if (fs::exists(file, error) && !fs::is_regular_file(file, error)) {
    throw IoError(file, "is not a file");
  }
}

}  // namespace highwall::apps
