#include "fuzz.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <highwall/core/error.h>

namespace highwall::fuzz {
namespace {

class Folder {
 public:
  Folder() {
    const std::filesystem::path memory = "/dev/shm";
    const std::filesystem::path root =
        std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
    path_ = root / ("highwall_fuzz_" + std::to_string(getpid()));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void WriteBytes(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::ssize(bytes));
}

void WriteSeeds(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const std::string& seed : kTarget.seeds()) {
    WriteBytes(folder / ("seed" + std::to_string(number++)), seed);
  }
}

// The file under test, which stays open from one input to the next, because opening and truncating
// it anew costs as much as many readers take.
class InputFile {
 public:
  explicit InputFile(const std::filesystem::path& path)
      : path_(path), file_(open(path.c_str(), O_WRONLY | O_CREAT, 0600)) {}
  ~InputFile() { close(file_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void Hold(std::string_view bytes) const {
    if (ftruncate(file_, std::ssize(bytes)) != 0 ||
        pwrite(file_, bytes.data(), bytes.size(), 0) != std::ssize(bytes)) {
      std::perror(path_.c_str());
      std::_Exit(2);
    }
  }

 private:
  std::filesystem::path path_;
  int file_;
};

}  // namespace

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

const std::filesystem::path& ScratchFolder() {
  static const Folder folder;
  return folder.path();
}

}  // namespace highwall::fuzz

// PROGRAM --seeds FOLDER writes the seeds and exits.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc == 3 && std::string_view((*argv)[1]) == "--seeds") {
    highwall::fuzz::WriteSeeds((*argv)[2]);
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace highwall::fuzz;
  static const InputFile file(ScratchFolder() / kTarget.file_name);
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (kTarget.file == nullptr) {
    file.Hold(input);
  } else {
    file.Hold(kTarget.file(input));
  }
  try {
    kTarget.read(file.path());
  } catch (const highwall::IoError& refused) {
    const std::string_view message = refused.what();
    if (kTarget.names_file && !message.starts_with(file.path().native())) {
      std::fprintf(stderr, "refused without the file's name: %s\n", refused.what());
      std::abort();
    }
  }
  return 0;
}
