#include "input/decompression.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <highwall/core/error.h>

namespace highwall {
namespace {

using Content = std::vector<std::uint8_t>;

constexpr std::size_t kPiece = 1 << 20;  // [byte] of content at a time

// Where a decoder puts its content: grows by pieces up to a limit.
class ContentBuffer {
 public:
  explicit ContentBuffer(std::uint64_t most) : most_(most) {}

  // Returns free room for at least one byte more than the limit permits, so that excess is noticed.
  std::span<std::uint8_t> Room() {
    const std::uint64_t left = most_ - std::min<std::uint64_t>(most_, used_) + 1;
    const std::size_t wanted =
        used_ + static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, left));
    if (content_.size() < wanted) content_.resize(wanted);
    return std::span(content_).subspan(used_);
  }
  // Returns false if the content exceeds the limit.
  bool Use(std::size_t count) {
    used_ += count;
    return used_ <= most_;
  }
  Content Finish() {
    content_.resize(used_);
    return std::move(content_);
  }

 private:
  Content content_;
  std::uint64_t most_;
  std::size_t used_ = 0;
};

// Each decoder returns nothing if the bytes are damaged, end early or hold more than `most`.
std::optional<Content> FromBzip2(std::span<const std::uint8_t> bytes, std::uint64_t most) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return std::nullopt;
  const auto end = [](bz_stream* s) { BZ2_bzDecompressEnd(s); };
  const std::unique_ptr<bz_stream, decltype(end)> guard(&stream, end);
  // The decoder does not write to its input.
  stream.next_in = reinterpret_cast<char*>(const_cast<std::uint8_t*>(bytes.data()));
  stream.avail_in = static_cast<unsigned>(bytes.size());
  ContentBuffer content(most);
  while (true) {
    const std::span<std::uint8_t> room = content.Room();
    stream.next_out = reinterpret_cast<char*>(room.data());
    stream.avail_out = static_cast<unsigned>(room.size());
    const int result = BZ2_bzDecompress(&stream);
    if (!content.Use(room.size() - stream.avail_out)) return std::nullopt;
    if (result == BZ_STREAM_END) return content.Finish();
    if (result != BZ_OK || stream.avail_out == room.size()) return std::nullopt;
  }
}

std::optional<Content> FromLz4(std::span<const std::uint8_t> bytes, std::uint64_t most) {
  LZ4F_dctx* created = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&created, LZ4F_VERSION))) return std::nullopt;
  const auto end = [](LZ4F_dctx* s) { LZ4F_freeDecompressionContext(s); };
  const std::unique_ptr<LZ4F_dctx, decltype(end)> decoder(created, end);
  ContentBuffer content(most);
  std::size_t hint = 1;
  while (hint != 0 || !bytes.empty()) {
    const std::span<std::uint8_t> room = content.Room();
    std::size_t used = bytes.size(), made = room.size();
    hint = LZ4F_decompress(decoder.get(), room.data(), &made, bytes.data(), &used, nullptr);
    if (LZ4F_isError(hint) || !content.Use(made)) return std::nullopt;
    if (used == 0 && made == 0) return std::nullopt;
    bytes = bytes.subspan(used);
  }
  return content.Finish();
}

std::optional<Content> FromZstd(std::span<const std::uint8_t> bytes, std::uint64_t most) {
  const auto end = [](ZSTD_DStream* s) { ZSTD_freeDStream(s); };
  const std::unique_ptr<ZSTD_DStream, decltype(end)> decoder(ZSTD_createDStream(), end);
  if (!decoder || ZSTD_isError(ZSTD_initDStream(decoder.get()))) return std::nullopt;
  ContentBuffer content(most);
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  std::size_t hint = 1;
  while (hint != 0 || in.pos < in.size) {
    const std::span<std::uint8_t> room = content.Room();
    ZSTD_outBuffer out{room.data(), room.size(), 0};
    const std::size_t before = in.pos;
    hint = ZSTD_decompressStream(decoder.get(), &out, &in);
    if (ZSTD_isError(hint) || !content.Use(out.pos)) return std::nullopt;
    if (in.pos == before && out.pos == 0) return std::nullopt;
  }
  return content.Finish();
}

[[noreturn]] void RefuseDamaged(const std::filesystem::path& path, std::string_view name) {
  throw IoError(path, std::string(name) + " cannot be decompressed: the file is damaged");
}

}  // namespace

std::optional<Compression> CompressionNamed(std::string_view name) {
  if (name.empty() || name == "none") return Compression::kNone;
  if (name == "bz2") return Compression::kBzip2;
  if (name == "lz4") return Compression::kLz4;
  if (name == "zstd") return Compression::kZstd;
  return std::nullopt;
}

Content Decompress(const std::filesystem::path& path, std::string_view name,
                   Compression compression, std::span<const std::uint8_t> bytes,
                   std::uint64_t size) {
  std::optional<Content> content;
  switch (compression) {
    case Compression::kNone:
      content.emplace(bytes.begin(), bytes.end());
      break;
    case Compression::kBzip2:
      content = FromBzip2(bytes, size);
      break;
    case Compression::kLz4:
      content = FromLz4(bytes, size);
      break;
    case Compression::kZstd:
      content = FromZstd(bytes, size);
      break;
  }
  if (!content || content->size() != size) RefuseDamaged(path, name);
  return *std::move(content);
}

bool IsZstd(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 4> kMagic{0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

Content DecompressZstd(const std::filesystem::path& path, std::string_view name,
                       std::span<const std::uint8_t> bytes, std::uint64_t most) {
  std::optional<Content> content = FromZstd(bytes, most);
  if (!content) RefuseDamaged(path, name);
  return *std::move(content);
}

}  // namespace highwall
