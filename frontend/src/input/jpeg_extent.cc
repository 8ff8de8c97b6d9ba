#include "input/jpeg_extent.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace highwall {
namespace {

using JpegBytes = std::span<const std::uint8_t>;

enum JpegMarker : std::uint8_t {
  kStartOfBaseline = 0xC0,
  kStartOfExtended = 0xC1,
  kStartOfProgressive = 0xC2,
  kHuffmanTables = 0xC4,
  kFirstRestart = 0xD0,
  kLastRestart = 0xD7,
  kEndOfImage = 0xD9,
  kStartOfScan = 0xDA,
  kRestartInterval = 0xDD,
};

int TwoBytes(JpegBytes bytes, std::size_t at) {
  return bytes[at] << 8 | bytes[at + 1];
}

int CeilOf(int a, int b) {
  return (a + b - 1) / b;
}

// Lengths and symbols of the codes, in the order of Annex C.
struct HuffmanTable {
  std::array<int, 16> counts{};
  std::vector<std::uint8_t> symbols;
};

struct JpegComponent {
  int id = 0, horizontal = 1, vertical = 1;  // sampling factors
};

// Bit reader of the entropy-coded data of one scan; FF 00 stands for FF.
class JpegBits {
 public:
  explicit JpegBits(JpegBytes data) : data_(data) {}

  std::optional<int> Next() {
    if (left_ == 0) {
      if (at_ == data_.size() || IsMarker()) return std::nullopt;
      byte_ = data_[at_];
      at_ += byte_ == 0xFF ? 2 : 1;
      left_ = 8;
    }
    return byte_ >> --left_ & 1;
  }
  bool Skip(int bits) {
    for (; bits > 0; --bits) {
      if (!Next()) return false;
    }
    return true;
  }
  std::optional<int> Symbol(const HuffmanTable& table) {
    int code = 0, first = 0;
    std::size_t index = 0;
    for (const int count : table.counts) {
      const std::optional<int> bit = Next();
      if (!bit) return std::nullopt;
      code = code << 1 | *bit;
      if (code - first < count)
        return table.symbols[index + static_cast<std::size_t>(code - first)];
      index += static_cast<std::size_t>(count);
      first = (first + count) << 1;
    }
    return std::nullopt;
  }
  // Skips to the data behind the next restart marker.
  bool Restart() {
    left_ = 0;
    if (at_ + 1 >= data_.size() || !IsMarker() || data_[at_ + 1] < kFirstRestart ||
        data_[at_ + 1] > kLastRestart) {
      return false;
    }
    at_ += 2;
    return true;
  }

 private:
  // A lone FF at the end is ambiguous: it is taken as half of the end marker.
  bool IsMarker() const {
    return data_[at_] == 0xFF && (at_ + 1 == data_.size() || data_[at_ + 1] != 0);
  }

  JpegBytes data_;
  std::size_t at_ = 0;
  int byte_ = 0, left_ = 0;
};

// Parser of the segments needed to count the blocks of a sequential picture.
class JpegWalk {
 public:
  explicit JpegWalk(JpegBytes bytes) : bytes_(bytes) {}

  JpegExtent Run() {
    std::size_t at = 2;
    while (at + 1 < bytes_.size()) {
      const std::uint8_t marker = bytes_[at + 1];
      if (bytes_[at] != 0xFF || marker == 0xFF) {  // between segments, where decoders skip it
        ++at;
        continue;
      }
      if (marker == kEndOfImage) return JpegExtent::kWhole;
      if (at + 4 > bytes_.size()) break;
      const auto length = static_cast<std::size_t>(TwoBytes(bytes_, at + 2));
      if (length < 2 || length > bytes_.size() - at - 2) break;
      const JpegBytes segment = bytes_.subspan(at + 4, length - 2);
      at += 2 + length;
      Read(marker, segment);
      if (marker == kStartOfScan && !segment.empty()) scanned_ += segment[0];
      if (marker == kStartOfScan) at = EndOfScan(at, segment);
    }
    return whole_scan_ ? JpegExtent::kNoEnd : JpegExtent::kTruncated;
  }

 private:
  void Read(std::uint8_t marker, JpegBytes segment) {
    if (marker == kHuffmanTables) ReadTables(segment);
    if (marker == kRestartInterval && segment.size() >= 2) restart_ = TwoBytes(segment, 0);
    const bool sequential = marker == kStartOfBaseline || marker == kStartOfExtended;
    if ((sequential || marker == kStartOfProgressive) && segment.size() >= 6) {
      progressive_ = !sequential;
      ReadFrame(segment);
    }
  }

  void ReadTables(JpegBytes segment) {
    while (segment.size() >= 17) {
      HuffmanTable table;
      std::size_t symbols = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        table.counts[i] = segment[i + 1];
        symbols += segment[i + 1];
      }
      if (segment.size() < 17 + symbols) return;
      const auto first = segment.begin() + 17;
      table.symbols.assign(first, first + static_cast<std::ptrdiff_t>(symbols));
      tables_[segment[0] >> 4 & 1][segment[0] & 3] = std::move(table);
      segment = segment.subspan(17 + symbols);
    }
  }

  void ReadFrame(JpegBytes segment) {
    height_ = TwoBytes(segment, 1);
    width_ = TwoBytes(segment, 3);
    components_.clear();
    for (std::size_t at = 6; at + 3 <= segment.size(); at += 3) {
      components_.push_back(
          {segment[at], std::max(segment[at + 1] >> 4, 1), std::max(segment[at + 1] & 15, 1)});
    }
  }

  // Returns the end of the data of a scan: the next marker that does not belong to the scan.
  std::size_t EndOfScan(std::size_t begin, JpegBytes header) {
    std::size_t at = begin;
    while (at + 1 < bytes_.size()) {
      const auto next = std::find(bytes_.begin() + static_cast<std::ptrdiff_t>(at),
                                  bytes_.end() - 1, std::uint8_t{0xFF});
      at = static_cast<std::size_t>(next - bytes_.begin());
      if (at + 1 >= bytes_.size()) break;
      const std::uint8_t code = bytes_[at + 1];
      if (code != 0 && code != 0xFF && !(code >= kFirstRestart && code <= kLastRestart)) return at;
      at += code == 0xFF ? 1 : 2;
    }
    // Only the last scan of a file without an end marker reaches this point.
    whole_scan_ = IsWhole(bytes_.subspan(begin), header);
    return bytes_.size();
  }

  bool IsWhole(JpegBytes data, JpegBytes header) const {
    if (header.empty() || header.size() < 4U + 2U * header[0]) return false;
    if (scanned_ < components_.size()) return false;
    if (progressive_) return header[3U + 2U * header[0]] >> 4 != 0;  // a refinement scan
    return CountsAllBlocks(data, header);
  }

  bool CountsAllBlocks(JpegBytes data, JpegBytes header) const {
    int most_h = 1, most_v = 1;
    for (const JpegComponent& component : components_) {
      most_h = std::max(most_h, component.horizontal);
      most_v = std::max(most_v, component.vertical);
    }
    // Blocks of an MCU, each with its DC and AC tables.
    std::vector<std::array<const HuffmanTable*, 2>> unit;
    int units = CeilOf(width_, 8 * most_h) * CeilOf(height_, 8 * most_v);
    for (std::size_t i = 0; i < header[0]; ++i) {
      const auto component =
          std::ranges::find(components_, int{header[1 + 2 * i]}, &JpegComponent::id);
      if (component == components_.end()) return false;
      const int tables = header[2 + 2 * i];
      const bool alone = header[0] == 1;  // without the blocks beyond the border
      if (alone) {
        units = CeilOf(CeilOf(width_ * component->horizontal, most_h), 8) *
                CeilOf(CeilOf(height_ * component->vertical, most_v), 8);
      }
      for (int b = alone ? 1 : component->horizontal * component->vertical; b > 0; --b) {
        unit.push_back({&tables_[0][tables >> 4 & 3], &tables_[1][tables & 3]});
      }
    }
    return CountsUnits(data, unit, units);
  }

  bool CountsUnits(JpegBytes data, const std::vector<std::array<const HuffmanTable*, 2>>& unit,
                   int units) const {
    JpegBits bits(data);
    for (int i = 0; i < units; ++i) {
      if (restart_ > 0 && i > 0 && i % restart_ == 0 && !bits.Restart()) return false;
      for (const auto& [dc, ac] : unit) {
        if (!SkipBlock(*dc, *ac, &bits)) return false;
      }
    }
    return units > 0 && !unit.empty();
  }

  static bool SkipBlock(const HuffmanTable& dc, const HuffmanTable& ac, JpegBits* bits) {
    const std::optional<int> difference = bits->Symbol(dc);
    if (!difference || !bits->Skip(*difference & 15)) return false;
    for (int k = 1; k < 64; ++k) {
      const std::optional<int> symbol = bits->Symbol(ac);
      if (!symbol) return false;
      const int zeros = *symbol >> 4, size = *symbol & 15;
      if (size == 0 && zeros != 15) return true;  // end of block
      k += zeros;
      if (!bits->Skip(size)) return false;
    }
    return true;
  }

  JpegBytes bytes_;
  std::array<std::array<HuffmanTable, 4>, 2> tables_;  // DC, AC
  std::vector<JpegComponent> components_;
  int width_ = 0, height_ = 0;
  std::size_t scanned_ = 0;  // components of all scans so far
  int restart_ = 0;          // [MCUs] between restart markers; 0: none
  bool progressive_ = false, whole_scan_ = false;
};

}  // namespace

JpegExtent ExtentOfJpeg(std::span<const std::uint8_t> bytes) {
  return JpegWalk(bytes).Run();
}

}  // namespace highwall
