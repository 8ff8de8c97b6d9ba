#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace highwall {

enum class Compression { kNone, kBzip2, kLz4, kZstd };

// Returns the compression of this name in a bag: "", "none", "bz2", "lz4" or "zstd".
std::optional<Compression> CompressionNamed(std::string_view name);

// Returns the content of compressed bytes: of a file of bzip2, or of one or more frames of LZ4 or
// zstd. size: of the content as the file states it, which is not trusted: memory is taken as the
// content appears. path, name: for messages. Throws IoError if the bytes are damaged or their
// content has another size.
std::vector<std::uint8_t> Decompress(const std::filesystem::path& path, std::string_view name,
                                     Compression compression, std::span<const std::uint8_t> bytes,
                                     std::uint64_t size);

// Whether the bytes begin as a frame of zstd.
bool IsZstd(std::span<const std::uint8_t> bytes);

// Returns the content of a frame of zstd of at most `most` bytes, whose size need not be known.
// Throws IoError as Decompress().
std::vector<std::uint8_t> DecompressZstd(const std::filesystem::path& path, std::string_view name,
                                         std::span<const std::uint8_t> bytes, std::uint64_t most);

}  // namespace highwall
