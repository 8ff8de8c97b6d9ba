#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace highwall::internal {

// Decompresses LZF, the compression of PCD files (the format of Marc Lehmann's liblzf): a byte c
// below 32 is followed by c + 1 literal bytes; any other one gives the number of bytes to repeat
// and, with the next one, their distance. Empty unless the output has exactly `size` bytes.
std::optional<std::string> DecompressLzf(std::string_view bytes, std::size_t size);

}  // namespace highwall::internal
