#include "cache_folder.h"

#include <unistd.h>

#include <fmt/core.h>

#include <highwall/core/error.h>

namespace highwall::bench {

CacheFolder::CacheFolder(const std::string& given, const std::string& bench)
    : path_(given), temporary_(given.empty()) {
  if (temporary_) {
    path_ = std::filesystem::temp_directory_path() / fmt::format("{}_{}", bench, ::getpid());
  }
  std::error_code error;
  std::filesystem::create_directories(path_, error);
  if (error) throw IoError(path_, "cannot be made: " + error.message());
}

CacheFolder::~CacheFolder() {
  std::error_code ignored;
  if (temporary_) std::filesystem::remove_all(path_, ignored);
}

}  // namespace highwall::bench
