#include "simulate/output/atomic_folder.h"

#include <cstdint>
#include <fstream>
#include <system_error>
#include <vector>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>

#include "images/encode.h"

namespace highwall::simulate {

AtomicFolder::AtomicFolder(const std::filesystem::path& path)
    : path_(std::filesystem::absolute(path).lexically_normal()) {
  if (!path_.has_filename()) path_ = path_.parent_path();  // "out/" -> "out"
  std::error_code error;
  if (std::filesystem::exists(path_, error) &&
      !(std::filesystem::is_directory(path_, error) && std::filesystem::is_empty(path_, error))) {
    throw IoError(path, "exists and is not empty: choose another folder or remove it");
  }
  std::filesystem::create_directories(path_.parent_path(), error);
  do {  // an existing one belongs to another process
    temporary_ = TemporaryBeside(path_);
  } while (!std::filesystem::create_directory(temporary_, error) && !error);
  if (error) throw IoError(temporary_, "cannot be created: " + error.message());
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(temporary_, ignored);  // already moved after Commit()
}

void AtomicFolder::Commit() {
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) throw IoError(path_, "could not be put in place: " + error.message());
}

void WriteBytes(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw IoError(path, "could not be written whole");
}

void WritePng(const std::filesystem::path& path, const cv::Mat& image) {
  const std::vector<std::uint8_t> bytes = EncodePng(image);
  WriteBytes(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace highwall::simulate
