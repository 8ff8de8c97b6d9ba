#pragma once

#include <filesystem>
#include <string_view>

#include <opencv2/core/mat.hpp>

namespace highwall::simulate {

// A folder that is written atomically: everything goes to a temporary folder next to it, and
// Commit() renames that. Without Commit() the temporary is removed.
class AtomicFolder {
 public:
  // Throws IoError if `path` exists and is not an empty folder, or cannot be created.
  explicit AtomicFolder(const std::filesystem::path& path);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const std::filesystem::path& temporary() const { return temporary_; }

  // Throws IoError if the folder cannot be renamed.
  void Commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
};

// Both throw IoError if the file cannot be written whole.
void WriteBytes(const std::filesystem::path& path, std::string_view bytes);
void WritePng(const std::filesystem::path& path, const cv::Mat& image);

}  // namespace highwall::simulate
