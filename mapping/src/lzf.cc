#include "lzf.h"

namespace highwall::internal {
namespace {

constexpr std::size_t kMostOfAByte = 88;  // three bytes repeat at most 264 bytes
constexpr unsigned kLongRun = 7;          // the length continues in the next byte

}  // namespace

std::optional<std::string> DecompressLzf(std::string_view bytes, std::size_t size) {
  if (size / kMostOfAByte > bytes.size()) return std::nullopt;
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&] { return static_cast<unsigned char>(bytes[at++]); };
  while (at < bytes.size()) {
    const unsigned control = next();
    if (control < 32) {
      const std::size_t count = control + 1;
      if (bytes.size() - at < count || size - out.size() < count) return std::nullopt;
      out.append(bytes.substr(at, count));
      at += count;
      continue;
    }
    std::size_t count = (control >> 5) + 2;
    if (bytes.size() - at < (control >> 5 == kLongRun ? 2u : 1u)) return std::nullopt;
    if (control >> 5 == kLongRun) count += next();
    const std::size_t back = ((control & 31u) << 8) + next() + 1;
    if (back > out.size() || size - out.size() < count) return std::nullopt;
    // Copied byte by byte: the source may overlap the bytes being written.
    for (std::size_t i = 0; i < count; ++i) out += out[out.size() - back];
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

}  // namespace highwall::internal
