#include <highwall/core/error.h>

namespace highwall {

IoError::IoError(const std::filesystem::path& path, const std::string& what)
    : std::runtime_error(path.string() + ": " + what) {}

IoError::IoError(const std::filesystem::path& path, std::int64_t line, const std::string& what)
    : std::runtime_error(path.string() + ":" + std::to_string(line) + ": " + what) {}

}  // namespace highwall
