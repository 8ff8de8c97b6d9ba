#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <string>

#include <highwall/core/atomic_file.h>
#include <highwall/mapping/point_cloud_io.h>

namespace highwall {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies memory as it lies");

template <typename T>
void AppendBinary(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

// Appends the shortest text that is parsed to the same number, whatever the locale.
template <typename T>
void AppendText(T value, std::string& text) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  text.append(buffer.data(), end);
  text += ' ';
}

void AppendRecord(const ColoredPoint& point, bool normals, bool binary, std::string& record) {
  const auto append = [&](auto value) {
    binary ? AppendBinary(value, record) : AppendText(value, record);
  };
  for (int i = 0; i < 3; ++i) append(point.p[i]);
  for (int i = 0; normals && i < 3; ++i) append(point.normal[i]);
  for (const std::uint8_t channel : point.rgb) append(channel);
  if (!binary) record.back() = '\n';
}

}  // namespace

void WritePly(const std::filesystem::path& path, std::span<const ColoredPoint> points,
              PlyFormat format) {
  const bool binary = format == PlyFormat::kBinaryLittleEndian;
  const bool normals =
      std::ranges::any_of(points, [](const ColoredPoint& point) { return !point.normal.isZero(); });
  AtomicFile file(path);
  std::ostream& out = file.stream();
  out << "ply\nformat " << (binary ? "binary_little_endian" : "ascii") << " 1.0\nelement vertex "
      << std::to_string(points.size()) << "\nproperty float x\nproperty float y\nproperty float z\n"
      << (normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "")
      << "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  std::string record;
  for (const ColoredPoint& point : points) {
    record.clear();
    AppendRecord(point, normals, binary, record);
    out << record;
  }
  file.Commit();
}

}  // namespace highwall
