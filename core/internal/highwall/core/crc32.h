#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace [[gnu::visibility("default")]] highwall {

// CRC-32 as of Ethernet, zip and PNG (polynomial 0x04C11DB7, reflected).
inline std::uint32_t Crc32(std::span<const std::byte> bytes) {
  static constexpr std::array<std::uint32_t, 256> kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t remainder = i;
      for (int bit = 0; bit < 8; ++bit) {
        remainder = (remainder >> 1) ^ ((remainder & 1U) != 0 ? 0xEDB88320U : 0U);
      }
      table[i] = remainder;
    }
    return table;
  }();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::byte b : bytes) {
    crc = kTable[(crc ^ std::to_integer<std::uint32_t>(b)) & 0xFFU] ^ (crc >> 8);
  }
  return ~crc;
}

}  // namespace highwall
