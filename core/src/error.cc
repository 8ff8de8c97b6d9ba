#include <highwall/core/error.h>

namespace highwall {

IoError::IoError(const std::filesystem::path& path, const std::string& what)
    : std::runtime_error(path.string() + ": " + what) {}

IoError::IoError(const std::filesystem::path& path, std::int64_t line, const std::string& what)
    : std::runtime_error(path.string() + ":" + std::to_string(line) + ": " + what) {}

namespace internal {

void ThrowInvalidArgument(const char* file, int line, const char* condition,
                          const std::string& message) {
  const std::string name = std::filesystem::path(file).filename().string();
  throw InvalidArgument(message + " (" + name + ":" + std::to_string(line) + ": " + condition +
                        ")");
}

}  // namespace internal

}  // namespace highwall
