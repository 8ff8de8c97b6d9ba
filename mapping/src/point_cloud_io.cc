#include <highwall/mapping/point_cloud_io.h>

#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>

namespace highwall {
namespace {

static_assert(std::endian::native == std::endian::little, "the writers copy memory as it lies");

constexpr std::size_t kPlyPointSize = 15;  // 3 floats, 3 bytes
constexpr std::array<std::string_view, 6> kPlyProperties = {
    "property float x",   "property float y",     "property float z",
    "property uchar red", "property uchar green", "property uchar blue"};

void AppendBinary(const ColoredPoint& point, std::string& bytes) {
  std::array<char, kPlyPointSize> record;
  std::memcpy(record.data(), point.p.data(), 12);
  std::memcpy(record.data() + 12, point.rgb.data(), 3);
  bytes.append(record.data(), record.size());
}

// The shortest text that reads back to the same float, whatever the locale.
void AppendText(const ColoredPoint& point, std::string& text) {
  std::array<char, 32> buffer;
  const auto append = [&](auto value, char separator) {
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    text.append(buffer.data(), end);
    text += separator;
  };
  for (int i = 0; i < 3; ++i) append(point.p[i], ' ');
  append(int{point.rgb[0]}, ' ');
  append(int{point.rgb[1]}, ' ');
  append(int{point.rgb[2]}, '\n');
}

// A text file line by line, knowing where it is.
class LineReader {
 public:
  explicit LineReader(const std::filesystem::path& path)
      : path_(path), stream_(path, std::ios::binary) {
    if (!stream_) throw IoError(path, "cannot be read");
  }

  std::string Next() {
    std::string line;
    ++line_;
    if (!std::getline(stream_, line)) Fail("the file ends here");
    if (line.ends_with('\r')) line.pop_back();
    return line;
  }
  void Expect(std::string_view wanted) {
    if (Next() != wanted) Fail("expected '" + std::string(wanted) + "'");
  }
  [[noreturn]] void Fail(const std::string& what) const { throw IoError(path_, line_, what); }
  std::istream& stream() { return stream_; }

 private:
  std::filesystem::path path_;
  std::ifstream stream_;
  std::int64_t line_ = 0;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::size_t count = 0;
};

PlyHeader ReadPlyHeader(LineReader& lines) {
  PlyHeader header;
  lines.Expect("ply");
  const std::string format = lines.Next();
  if (format == "format binary_little_endian 1.0") {
    header.format = PlyFormat::kBinaryLittleEndian;
  } else if (format != "format ascii 1.0") {
    lines.Fail("expected 'format binary_little_endian 1.0' or 'format ascii 1.0'");
  }
  constexpr std::string_view kElement = "element vertex ";
  const std::string element = lines.Next();
  const char* const end = element.data() + element.size();
  if (!element.starts_with(kElement)) lines.Fail("expected 'element vertex'");
  const auto count = std::from_chars(element.data() + kElement.size(), end, header.count);
  if (count.ec != std::errc{} || count.ptr != end) lines.Fail("expected the number of points");
  for (const std::string_view property : kPlyProperties) lines.Expect(property);
  lines.Expect("end_header");
  return header;
}

ColoredPoint ReadBinaryPoint(LineReader& lines) {
  std::array<char, kPlyPointSize> record;
  if (!lines.stream().read(record.data(), record.size())) lines.Fail("points are missing after it");
  ColoredPoint point;
  std::memcpy(point.p.data(), record.data(), 12);
  std::memcpy(point.rgb.data(), record.data() + 12, 3);
  return point;
}

ColoredPoint ReadTextPoint(LineReader& lines) {
  const std::string line = lines.Next();
  const char* at = line.data();
  const char* const end = at + line.size();
  const auto parse = [&](auto& value) {
    while (at != end && *at == ' ') ++at;
    const auto result = std::from_chars(at, end, value);
    if (result.ec != std::errc{}) lines.Fail("expected 'x y z red green blue'");
    at = result.ptr;
  };
  ColoredPoint point;
  for (int i = 0; i < 3; ++i) parse(point.p[i]);
  for (std::uint8_t& channel : point.rgb) parse(channel);
  if (at != end) lines.Fail("more than six values");
  return point;
}

}  // namespace

void WritePly(const std::filesystem::path& path, std::span<const ColoredPoint> points,
              PlyFormat format) {
  const bool binary = format == PlyFormat::kBinaryLittleEndian;
  AtomicFile file(path);
  std::ostream& out = file.stream();
  out << "ply\nformat " << (binary ? "binary_little_endian" : "ascii") << " 1.0\nelement vertex "
      << std::to_string(points.size()) << '\n';
  for (const std::string_view property : kPlyProperties) out << property << '\n';
  out << "end_header\n";
  std::string record;
  for (const ColoredPoint& point : points) {
    record.clear();
    if (binary) {
      AppendBinary(point, record);
    } else {
      AppendText(point, record);
    }
    out << record;
  }
  file.Commit();
}

std::vector<ColoredPoint> ReadPly(const std::filesystem::path& path) {
  LineReader lines(path);
  const PlyHeader header = ReadPlyHeader(lines);
  std::vector<ColoredPoint> points;
  for (std::size_t i = 0; i < header.count; ++i) {
    points.push_back(header.format == PlyFormat::kAscii ? ReadTextPoint(lines)
                                                        : ReadBinaryPoint(lines));
  }
  return points;
}

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

}  // namespace highwall
