#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include "support/temporary_directory.h"
#include "support/test_paths.h"

// The messages that docs/troubleshooting.md quotes, and how they match lines of output.
namespace highwall::apps::troubleshooting_test {

inline std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Returns the text between backticks in the first column of the tables.
inline std::vector<std::string> QuotedMessages() {
  std::vector<std::string> messages;
  for (const std::string& line :
       Lines(testing::ReadText(std::string(testing::kSourceFolder) + "/docs/troubleshooting.md"))) {
    if (!line.starts_with("| `")) continue;
    messages.push_back(line.substr(3, line.find("` |") - 3));
  }
  return messages;
}

// Checks that a line contains the parts of a message between its "…" in order.
inline bool Says(const std::string& line, std::string message) {
  const std::string any = "…";
  std::size_t at = 0;
  for (;;) {
    const std::size_t end = message.find(any);
    const std::string part = message.substr(0, end);
    at = line.find(part, at);
    if (at == std::string::npos) return false;
    if (end == std::string::npos) return true;
    at += part.size();
    message.erase(0, end + any.size());
  }
}

}  // namespace highwall::apps::troubleshooting_test
