#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace highwall::fuzz {

// A reader of files under test. Whatever the bytes, it reads them or throws IoError with the file's
// name; anything else is a finding.
struct Target {
  const char* file_name;
  // Inputs to begin with, made by the writer of the format where there is one.
  std::vector<std::string> (*seeds)();
  // The file made of an input; null where it is the input.
  std::string (*file)(std::string_view input);
  void (*read)(const std::filesystem::path& path);
  bool names_file = true;  // what is refused is this file, not one that it names
};

// Each program defines one.
extern const Target kTarget;

// What `write` writes to the path it is given.
template <class Write>
std::string Written(const Write& write);

std::string ReadBytes(const std::filesystem::path& path);
// A folder of this process, in memory where the system has that; gone with the process.
const std::filesystem::path& ScratchFolder();

template <class Write>
std::string Written(const Write& write) {
  const std::filesystem::path path = ScratchFolder() / "written";
  write(path);
  return ReadBytes(path);
}

}  // namespace highwall::fuzz
