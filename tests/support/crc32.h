#pragma once

#include <cstdint>
#include <string_view>

namespace highwall::testing {

// CRC-32 as of zip (polynomial 0x04C11DB7, reflected): tests and fuzzers that change the content of
// a file make its checksum right again.
inline std::uint32_t Crc32(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? 0xEDB88320U ^ (crc >> 1) : crc >> 1;
  }
  return ~crc;
}

}  // namespace highwall::testing
