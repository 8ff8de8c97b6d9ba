#pragma once

#include <filesystem>
#include <string>

namespace highwall::bench {

// Folder for files to keep between runs; removed with the object unless it was given.
class CacheFolder {
 public:
  // given: may be empty. bench: names the temporary folder. Throws IoError.
  CacheFolder(const std::string& given, const std::string& bench);
  ~CacheFolder();
  CacheFolder(const CacheFolder&) = delete;
  CacheFolder& operator=(const CacheFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool temporary_;
};

}  // namespace highwall::bench
