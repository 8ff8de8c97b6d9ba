#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <highwall/core/atomic_file.h>
#include <highwall/mapping/point_cloud_io.h>

#include "lzf.h"
#include "text_parser.h"

namespace highwall {
namespace {

using internal::FileCursor;
using Words = std::vector<std::string_view>;

enum class PcdData { kAscii, kBinary, kCompressed };

struct PcdHeader {
  std::size_t fields = 0;
  std::array<std::optional<std::size_t>, 4> places;  // column of x, y, z and rgb
  std::size_t points = 0;
  PcdData data = PcdData::kAscii;
};

void RequireAll(const Words& words, std::string_view value, const FileCursor& file) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] != value) file.Fail("only fields of 4 bytes and count 1 are read");
  }
}

// words: "FIELDS" and the names of the fields.
void ReadFields(const Words& words, const FileCursor& file, PcdHeader* header) {
  constexpr std::array<std::string_view, 4> kNames = {"x", "y", "z", "rgb"};
  header->fields = words.size() - 1;
  for (std::size_t i = 1; i < words.size(); ++i) {
    for (std::size_t k = 0; k < kNames.size(); ++k) {
      if (words[i] != kNames[k]) continue;
      if (header->places[k]) file.Fail("the field '" + std::string(words[i]) + "' is there twice");
      header->places[k] = i - 1;
    }
  }
}

PcdData ReadDataKind(const Words& words, const FileCursor& file) {
  if (words.size() == 2 && words[1] == "ascii") return PcdData::kAscii;
  if (words.size() == 2 && words[1] == "binary") return PcdData::kBinary;
  if (words.size() == 2 && words[1] == "binary_compressed") return PcdData::kCompressed;
  file.Fail("DATA must be ascii, binary or binary_compressed");
}

PcdHeader ReadPcdHeader(FileCursor& file) {
  PcdHeader header;
  while (true) {
    const Words words = SplitWords(file.Line(), internal::kBetweenWords);
    if (words.empty() || words[0].starts_with('#')) continue;
    if (words[0] == "FIELDS") {
      if (header.fields > 0) file.Fail("FIELDS is there twice");
      ReadFields(words, file, &header);
    } else if (words[0] == "SIZE") {
      RequireAll(words, "4", file);
    } else if (words[0] == "COUNT") {
      RequireAll(words, "1", file);
    } else if (words[0] == "POINTS") {
      if (words.size() != 2 || !ParseNumber(words[1], &header.points)) {
        file.Fail("expected the number of points");
      }
    } else if (words[0] == "DATA") {
      header.data = ReadDataKind(words, file);
      if (!header.places[0] || !header.places[1] || !header.places[2]) {
        file.Fail("the file has no fields x, y and z");
      }
      return header;
    } else if (words[0] != "VERSION" && words[0] != "TYPE" && words[0] != "WIDTH" &&
               words[0] != "HEIGHT" && words[0] != "VIEWPOINT") {
      file.Fail("unknown entry '" + std::string(words[0]) + "'");
    }
  }
}

// The data are two sizes, compressed and uncompressed, then all values of the first field, of the
// second, and so on.
std::string ReadCompressed(const PcdHeader& header, FileCursor& file) {
  std::array<std::uint32_t, 2> sizes;
  std::memcpy(sizes.data(), file.Bytes(sizeof(sizes)), sizeof(sizes));
  const auto [compressed, size] = sizes;
  const std::size_t record = 4 * header.fields;
  if (size % record != 0 || size / record != header.points) {
    file.Fail("the compressed data are not those of as many points");
  }
  const std::string_view bytes(file.Bytes(compressed), compressed);
  std::optional<std::string> data = internal::DecompressLzf(bytes, size);
  if (!data) file.Fail("the compressed data are damaged");
  return std::move(*data);
}

// Reads the values of the n-th point. compressed: the decompressed data of all points, if the file
// is compressed.
void ReadValues(const PcdHeader& header, const std::string& compressed, std::size_t n,
                FileCursor& file, std::vector<float>* values) {
  switch (header.data) {
    case PcdData::kBinary:
      std::memcpy(values->data(), file.Bytes(4 * header.fields), 4 * header.fields);
      return;
    case PcdData::kCompressed:
      for (std::size_t i = 0; i < header.fields; ++i) {
        std::memcpy(&(*values)[i], compressed.data() + 4 * (i * header.points + n), 4);
      }
      return;
    case PcdData::kAscii:
      break;
  }
  const Words words = SplitWords(file.Line(), internal::kBetweenWords);
  if (words.size() != header.fields) file.Fail("expected as many values as fields");
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!ParseNumber(words[i], &(*values)[i])) file.Fail("expected a number");
  }
}

}  // namespace

void WritePcd(const std::filesystem::path& path, std::span<const ColoredPoint> points) {
  AtomicFile file(path);
  const std::string count = std::to_string(points.size());
  file.stream() << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
                   "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH "
                << count << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << count
                << "\nDATA binary\n";
  for (const ColoredPoint& point : points) {
    const std::uint32_t rgb = std::uint32_t{point.rgb[0]} << 16 | std::uint32_t{point.rgb[1]} << 8 |
                              std::uint32_t{point.rgb[2]};
    std::array<char, 16> record;
    std::memcpy(record.data(), point.p.data(), 12);
    std::memcpy(record.data() + 12, &rgb, 4);
    file.stream().write(record.data(), record.size());
  }
  file.Commit();
}

std::vector<ColoredPoint> ReadPcd(const std::filesystem::path& path) {
  FileCursor file(path);
  const PcdHeader header = ReadPcdHeader(file);
  const std::string compressed =
      header.data == PcdData::kCompressed ? ReadCompressed(header, file) : std::string();
  std::vector<ColoredPoint> points;
  std::vector<float> values(header.fields);
  for (std::size_t n = 0; n < header.points; ++n) {
    ReadValues(header, compressed, n, file, &values);
    ColoredPoint& point = points.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      point.p[static_cast<Eigen::Index>(i)] = values[*header.places[i]];
    }
    if (header.places[3]) {
      std::uint32_t rgb;
      std::memcpy(&rgb, &values[*header.places[3]], 4);
      for (unsigned i = 0; i < 3; ++i) {
        point.rgb[i] = static_cast<std::uint8_t>(rgb >> (16 - 8 * i) & 255u);
      }
    }
  }
  return points;
}

}  // namespace highwall
