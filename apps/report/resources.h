#pragma once

#include <span>
#include <string_view>

namespace highwall::apps {

// File embedded in the program.
struct Resource {
  std::string_view name;  // without its folder
  std::span<const unsigned char> bytes;
};

// Returns the sources of the page and, if available when Highwall was configured, three.js.
std::span<const Resource> Resources();

}  // namespace highwall::apps
