#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace highwall::apps {

// Encodes as in RFC 4648, with padding.
std::string Base64(std::span<const std::byte> bytes);

// Encodes the bytes of an array as in memory: little-endian, as pages read them.
template <class T>
std::string Base64Of(std::span<const T> values) {
  return Base64(std::as_bytes(values));
}

}  // namespace highwall::apps
