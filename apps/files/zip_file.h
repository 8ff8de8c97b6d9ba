#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace highwall::apps {

// A zip archive of a few files, stored without compression (APPNOTE.TXT 6.3, sections 4.3.7,
// 4.3.12, 4.3.16); less than 4 GB.
class ZipFile {
 public:
  void Add(std::string name, std::string content);
  // Writes the file atomically. Throws IoError.
  void Write(const std::filesystem::path& path) const;

 private:
  struct Entry {
    std::string name, content;
  };
  std::vector<Entry> entries_;
};

}  // namespace highwall::apps
