#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace highwall::internal {

// LZF, the compression of PCD files (the format of Marc Lehmann's liblzf): a byte c below 32 is
// followed by c + 1 bytes as they are; any other one says how many bytes to repeat, and with the
// next one from how far behind. Empty unless the bytes give exactly `size` bytes.
std::optional<std::string> DecompressLzf(std::string_view bytes, std::size_t size);

}  // namespace highwall::internal
