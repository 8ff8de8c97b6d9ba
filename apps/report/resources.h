#pragma once

#include <span>
#include <string_view>

namespace highwall::apps {

// A file that is embedded in the program.
struct Resource {
  std::string_view name;  // without its folder
  std::span<const unsigned char> bytes;
};

// The sources of the page and, where it was there when Highwall was configured, three.js.
std::span<const Resource> Resources();

}  // namespace highwall::apps
