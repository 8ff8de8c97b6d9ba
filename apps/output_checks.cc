#include "output_checks.h"

#include <unistd.h>

#include <system_error>

#include <highwall/core/error.h>

namespace highwall::apps {

void RequireFolder(const std::filesystem::path& out) {
  std::error_code error;
  if (std::filesystem::is_directory(out, error)) {
    if (::access(out.c_str(), W_OK | X_OK) != 0) throw IoError(out, "cannot be written to");
    return;
  }
  if (std::filesystem::exists(std::filesystem::symlink_status(out, error))) {
    throw IoError(out, "is a file, but --out needs a folder");
  }
  std::filesystem::path above = std::filesystem::absolute(out, error).parent_path();
  while (above.has_relative_path() && !std::filesystem::exists(above, error)) {
    above = above.parent_path();
  }
  if (!std::filesystem::is_directory(above, error) || ::access(above.c_str(), W_OK | X_OK) != 0) {
    throw IoError(out, "cannot be made: no folder can be made in " + above.string());
  }
}

void RequireFile(const std::filesystem::path& file) {
  RequireFolder(std::filesystem::weakly_canonical(std::filesystem::absolute(file)).parent_path());
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    throw IoError(file, "is not a file");
  }
}

}  // namespace highwall::apps
