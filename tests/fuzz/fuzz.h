#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace highwall::fuzz {

// A file reader under test. For any bytes it must read them or throw IoError with the name of the
// file. Anything else is a finding.
struct Target {
  const char* file_name;
  // Initial inputs, made by the writer of the format if there is one.
  std::vector<std::string> (*seeds)();
  // Makes the file from an input; null if the file is the input.
  std::string (*file)(std::string_view input);
  void (*read)(const std::filesystem::path& path);
  bool names_file = true;  // false if an error may name another file than this one
};

// Each program defines one.
extern const Target kTarget;

// Returns the content that `write` writes to the given path.
template <class Write>
std::string Written(const Write& write);

std::string ReadBytes(const std::filesystem::path& path);
// A folder of this process, in memory if the system has a memory file system. It is removed when
// the process exits.
const std::filesystem::path& ScratchFolder();

template <class Write>
std::string Written(const Write& write) {
  const std::filesystem::path path = ScratchFolder() / "written";
  write(path);
  return ReadBytes(path);
}

}  // namespace highwall::fuzz
