#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace highwall::apps {

// RFC 4648, with padding.
std::string Base64(std::span<const std::byte> bytes);

// Of an array's bytes as they lie in memory: little-endian, as pages read them.
template <class T>
std::string Base64Of(std::span<const T> values) {
  return Base64(std::as_bytes(values));
}

}  // namespace highwall::apps
