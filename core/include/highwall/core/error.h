#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace [[gnu::visibility("default")]] highwall {

// Thrown for an argument, an option or a block that violates a documented precondition. The message
// names it, the requirement and, where useful, its value.
class InvalidArgument : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

// Thrown for a file that is missing, unreadable or malformed. The message is "path: what", or
// "path:line: what" where the error is in one line. Never thrown for a result that is merely empty.
class IoError : public std::runtime_error {
 public:
  IoError(const std::filesystem::path& path, const std::string& what);
  // line: counted from 1.
  IoError(const std::filesystem::path& path, std::int64_t line, const std::string& what);
};

}  // namespace highwall

// Throws highwall::InvalidArgument with the message unless `condition` holds.
#define HIGHWALL_REQUIRE(condition, message)                        \
  do {                                                              \
    if (!(condition)) throw ::highwall::InvalidArgument((message)); \
  } while (false)
