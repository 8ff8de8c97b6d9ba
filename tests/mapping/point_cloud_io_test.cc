#include <highwall/mapping/point_cloud_io.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "support/file_size_limit.h"
#include "support/temporary_directory.h"

namespace highwall::point_cloud_io_test {
namespace {

using testing::FileSizeLimit;
using testing::ReadText;
using testing::TemporaryDirectory;
using testing::WriteText;

std::vector<ColoredPoint> RandomCloud(int count) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> u(-10.0f, 10.0f);
  std::uniform_int_distribution<int> byte(0, 255);
  std::vector<ColoredPoint> points;
  for (int i = 0; i < count; ++i) {
    const auto channel = [&] { return static_cast<std::uint8_t>(byte(rng)); };
    points.push_back({.p = {u(rng), u(rng), u(rng)}, .rgb = {channel(), channel(), channel()}});
  }
  return points;
}

const std::vector<ColoredPoint> kOnePoint = {{.p = {1.0f, -2.5f, 0.1f}, .rgb = {1, 2, 255}}};

TEST(Ply, BothFormatsReadBackToTheLastBit) {
  const TemporaryDirectory folder;
  for (const PlyFormat format : {PlyFormat::kBinaryLittleEndian, PlyFormat::kAscii}) {
    for (const int count : {0, 1, 500}) {
      const auto points = RandomCloud(count);
      WritePly(folder / "cloud.ply", points, format);
      const auto read = ReadPly(folder / "cloud.ply");
      ASSERT_EQ(read.size(), points.size());
      for (std::size_t i = 0; i < read.size(); ++i) {
        EXPECT_EQ(read[i].p, points[i].p);
        EXPECT_EQ(read[i].rgb, points[i].rgb);
      }
    }
  }
}

TEST(Ply, BytesFollowTheFormat) {
  const TemporaryDirectory folder;
  const std::string properties =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  WritePly(folder / "a.ply", kOnePoint, PlyFormat::kAscii);
  EXPECT_EQ(ReadText(folder / "a.ply"),
            "ply\nformat ascii 1.0\n" + properties + "1 -2.5 0.1 1 2 255\n");
  WritePly(folder / "b.ply", kOnePoint);
  EXPECT_EQ(ReadText(folder / "b.ply"),
            "ply\nformat binary_little_endian 1.0\n" + properties +
                std::string("\x00\x00\x80\x3f\x00\x00\x20\xc0\xcd\xcc\xcc\x3d\x01\x02\xff", 15));
}

TEST(Pcd, BytesFollowTheFormat) {
  const TemporaryDirectory folder;
  WritePcd(folder / "cloud.pcd", kOnePoint);
  EXPECT_EQ(
      ReadText(folder / "cloud.pcd"),
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
      "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 1\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA binary\n" +
          std::string("\x00\x00\x80\x3f\x00\x00\x20\xc0\xcd\xcc\xcc\x3d\xff\x02\x01\x00", 16));
}

TEST(Ply, EveryTruncationIsAnIoError) {
  const TemporaryDirectory folder;
  for (const PlyFormat format : {PlyFormat::kBinaryLittleEndian, PlyFormat::kAscii}) {
    WritePly(folder / "cloud.ply", RandomCloud(3), format);
    const std::string bytes = ReadText(folder / "cloud.ply");
    // In a text file the last number may lose digits and stay a number, so the cut is before it.
    for (std::size_t size = 0; size + 5 < bytes.size(); ++size) {
      WriteText(folder / "cut.ply", bytes.substr(0, size));
      EXPECT_THROW(ReadPly(folder / "cut.ply"), IoError) << size;
    }
  }
}

TEST(Ply, MalformedFilesAreIoErrors) {
  const TemporaryDirectory folder;
  WritePly(folder / "good.ply", kOnePoint, PlyFormat::kAscii);
  const std::string good = ReadText(folder / "good.ply");
  const auto refuses = [&](const std::string& what, const std::string& by) {
    std::string bad = good;
    bad.replace(bad.find(what), what.size(), by);
    WriteText(folder / "bad.ply", bad);
    EXPECT_THROW(ReadPly(folder / "bad.ply"), IoError) << bad;
  };
  refuses("ply", "obj");
  refuses("format ascii", "format binary_big_endian");
  refuses("vertex 1", "vertex -1");
  refuses("vertex 1", "vertex 99999999999999999999999");
  refuses("vertex 1", "vertex ");
  refuses("float x", "word x");
  refuses("float x", "float w");
  refuses("255", "256");
  refuses("-2.5", "two");
  refuses("255\n", "255 7\n");
  EXPECT_THROW(ReadPly(folder / "missing.ply"), IoError);
}

TEST(Ply, NormalsAreWrittenWhereAnyPointHasOne) {
  const TemporaryDirectory folder;
  auto points = RandomCloud(5);
  points[3].normal = {0.6f, 0.0f, -0.8f};
  for (const PlyFormat format : {PlyFormat::kBinaryLittleEndian, PlyFormat::kAscii}) {
    WritePly(folder / "cloud.ply", points, format);
    const auto read = ReadPly(folder / "cloud.ply");
    ASSERT_EQ(read.size(), points.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_EQ(read[i].p, points[i].p);
      EXPECT_EQ(read[i].normal, points[i].normal);
      EXPECT_EQ(read[i].rgb, points[i].rgb);
    }
  }
}

TEST(Ply, MeshesOfOtherProgramsAreRead) {
  const TemporaryDirectory folder;
  const std::string mesh =
      "ply\r\nformat ascii 1.0\r\ncomment made elsewhere\r\nelement vertex 4\r\n"
      "property double x\r\nproperty double y\r\nproperty double z\r\n"
      "property float32 quality\r\nelement face 1\r\n"
      "property list uint8 int32 vertex_indices\r\nend_header\r\n"
      "0 0 0 0.5\r\n1 0 0 0.5\r\n1 1 0 0.5\r\n0 1 0.25 0.5\r\n4 0 1 2 3\r\n";
  WriteText(folder / "mesh.ply", mesh);
  const TriangleMesh read = ReadPlyMesh(folder / "mesh.ply");
  ASSERT_EQ(read.vertices.size(), 4u);
  EXPECT_EQ(read.vertices[3].p, Eigen::Vector3f(0, 1, 0.25f));
  ASSERT_EQ(read.triangles.size(), 2u);
  EXPECT_EQ(read.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  std::string bad = mesh;
  bad.replace(bad.find("4 0 1 2 3"), 9, "4 0 1 2 4");
  WriteText(folder / "mesh.ply", bad);
  EXPECT_THROW(ReadPlyMesh(folder / "mesh.ply"), IoError);
}

TEST(Pcd, ReadsBackToTheLastBit) {
  const TemporaryDirectory folder;
  const auto points = RandomCloud(200);
  WritePcd(folder / "cloud.pcd", points);
  const auto read = ReadPcd(folder / "cloud.pcd");
  ASSERT_EQ(read.size(), points.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].p, points[i].p);
    EXPECT_EQ(read[i].rgb, points[i].rgb);
  }
}

TEST(Pcd, ReadsTextWithOtherFields) {
  const TemporaryDirectory folder;
  const std::string text =
      "VERSION 0.7\nFIELDS intensity x y z\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
      "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n9 1 2 3\n9 4 5 6\n";
  WriteText(folder / "cloud.pcd", text);
  const auto read = ReadPcd(folder / "cloud.pcd");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[1].p, Eigen::Vector3f(4, 5, 6));
  for (const std::string what : {"POINTS 2", "DATA ascii", "FIELDS intensity x y z", "9 4 5 6"}) {
    std::string bad = text;
    bad.replace(bad.find(what), what.size(), "POINTS many");
    WriteText(folder / "bad.pcd", bad);
    EXPECT_THROW(ReadPcd(folder / "bad.pcd"), IoError) << what;
  }
}

TEST(Pcd, RefusesFieldsOfOtherSizesAndCounts) {
  const TemporaryDirectory folder;
  const std::string text =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 1\nDATA ascii\n1 2 3\n";
  WriteText(folder / "cloud.pcd", text);
  ASSERT_EQ(ReadPcd(folder / "cloud.pcd").size(), 1u);
  for (const auto& [what, by] : {std::pair("SIZE 4 4 4", "SIZE 4 4 8"), {"COUNT 1", "COUNT 2"}}) {
    std::string bad = text;
    bad.replace(bad.find(what), std::string(what).size(), by);
    WriteText(folder / "bad.pcd", bad);
    try {
      ReadPcd(folder / "bad.pcd");
      ADD_FAILURE() << by;
    } catch (const IoError& e) {
      EXPECT_NE(std::string(e.what()).find("only fields of 4 bytes and count 1"), std::string::npos)
          << e.what();
    }
  }
}

// Positions found in one list of fields do not apply to records described by another one.
TEST(Pcd, FieldsAreNamedOnce) {
  const TemporaryDirectory folder;
  std::string many = "FIELDS";
  for (int i = 0; i < 1000000; ++i) many += " w";
  many += " x y z rgb\n";
  for (const std::string& fields :
       {std::string("FIELDS a b c d x y z rgb\nFIELDS x\n"), many + "FIELDS x\n",
        std::string("FIELDS x y z rgb\nFIELDS x y z rgb\n"), std::string("FIELDS x y z x\n")}) {
    WriteText(folder / "cloud.pcd", fields + "POINTS 1\nDATA ascii\n1\n");
    try {
      ReadPcd(folder / "cloud.pcd");
      FAIL() << "read";
    } catch (const IoError& e) {
      EXPECT_NE(std::string(e.what()).find("is there twice"), std::string::npos) << e.what();
    }
  }
}

TEST(Pcd, EveryTruncationIsAnIoError) {
  const TemporaryDirectory folder;
  WritePcd(folder / "cloud.pcd", RandomCloud(3));
  const std::string bytes = ReadText(folder / "cloud.pcd");
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    WriteText(folder / "cut.pcd", bytes.substr(0, size));
    EXPECT_THROW(ReadPcd(folder / "cut.pcd"), IoError) << size;
  }
  EXPECT_THROW(ReadPcd(folder / "missing.pcd"), IoError);
}

// Greedy, with all runs allowed by the format: at a distance of at most 8,191 bytes, 3 to 264 bytes
// long.
std::string Compressed(const std::string& bytes) {
  std::string out, literals;
  const auto flush = [&] {
    if (!literals.empty()) out += static_cast<char>(literals.size() - 1) + literals;
    literals.clear();
  };
  for (std::size_t at = 0; at < bytes.size();) {
    std::size_t length = 0, back = 0;
    for (std::size_t b = 1; b <= std::min<std::size_t>(at, 8191); ++b) {
      std::size_t n = 0;
      while (n < 264 && at + n < bytes.size() && bytes[at + n] == bytes[at + n - b]) ++n;
      if (n > length) length = n, back = b;
    }
    if (length < 3) {
      literals += bytes[at++];
      if (literals.size() == 32) flush();
      continue;
    }
    flush();
    const std::size_t run = std::min<std::size_t>(length - 2, 7);
    out += static_cast<char>(run << 5 | (back - 1) >> 8);
    if (run == 7) out += static_cast<char>(length - 9);
    out += static_cast<char>((back - 1) & 255);
    at += length;
  }
  flush();
  return out;
}

template <class T>
std::string BytesOf(const T& value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string CompressedPcd(const std::vector<ColoredPoint>& points, const std::string& compressed,
                          std::uint32_t size) {
  const std::string count = std::to_string(points.size());
  return "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " + count +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary_compressed\n" +
         BytesOf(static_cast<std::uint32_t>(compressed.size())) + BytesOf(size) + compressed;
}

std::string FieldByField(const std::vector<ColoredPoint>& points) {
  std::string fields;
  for (int i = 0; i < 3; ++i) {
    for (const ColoredPoint& point : points) fields += BytesOf(point.p[i]);
  }
  for (const ColoredPoint& point : points) {
    fields += BytesOf(std::uint32_t{point.rgb[0]} << 16 | std::uint32_t{point.rgb[1]} << 8 |
                      std::uint32_t{point.rgb[2]});
  }
  return fields;
}

TEST(Pcd, CompressedFilesAreRead) {
  const TemporaryDirectory folder;
  for (const int count : {0, 1, 3, 500}) {
    for (const bool flat : {false, true}) {
      auto points = RandomCloud(count);
      for (ColoredPoint& point : points) {
        if (flat) point = {.p = {1.0f, 2.0f, -0.5f}, .rgb = {9, 9, 9}};
      }
      const std::string fields = FieldByField(points);
      const std::string compressed = Compressed(fields);
      if (flat && count == 500) {
        EXPECT_LT(compressed.size(), 200u) << "long runs";
      }
      WriteText(folder / "cloud.pcd",
                CompressedPcd(points, compressed, static_cast<std::uint32_t>(fields.size())));
      const auto read = ReadPcd(folder / "cloud.pcd");
      ASSERT_EQ(read.size(), points.size());
      for (std::size_t i = 0; i < read.size(); ++i) {
        EXPECT_EQ(read[i].p, points[i].p);
        EXPECT_EQ(read[i].rgb, points[i].rgb);
      }
    }
  }
}

TEST(Pcd, DamagedCompressedFilesAreIoErrors) {
  const TemporaryDirectory folder;
  const std::vector<ColoredPoint> points(4, ColoredPoint{.p = {1.0f, 1.0f, 2.0f}});
  const std::string compressed = Compressed(FieldByField(points));
  const auto expect_refused = [&](const std::string& text) {
    WriteText(folder / "bad.pcd", text);
    EXPECT_THROW(ReadPcd(folder / "bad.pcd"), IoError);
  };
  const std::string good = CompressedPcd(points, compressed, 64);
  WriteText(folder / "good.pcd", good);
  ASSERT_EQ(ReadPcd(folder / "good.pcd").size(), 4u);
  for (std::size_t size = 0; size < good.size(); ++size) expect_refused(good.substr(0, size));
  for (const std::uint32_t size : {0u, 63u, 65u, 80u, 0xffffffffu}) {
    expect_refused(CompressedPcd(points, compressed, size));
  }
  using namespace std::string_literals;
  // A run from before the beginning, a truncated run, truncated literals, and too few and too many
  // bytes.
  for (const std::string& bytes :
       {"\x20\x00"s, "\x00\x01\x20\x01"s, "\x00\x01\x20"s, "\x00\x01\xe0\x05"s, "\x1f\x01"s, ""s,
        compressed.substr(0, 3), compressed + "\x00\x01"s, compressed + "\xe0\xff\x00"s}) {
    expect_refused(CompressedPcd(points, bytes, 64));
  }
}

TEST(Ply, ColoursMayBeCalledDiffuse) {
  const TemporaryDirectory folder;
  WriteText(folder / "cloud.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar diffuse_red\nproperty uchar diffuse_green\n"
            "property uchar diffuse_blue\nend_header\n1 2 3 10 20 30\n");
  EXPECT_EQ(ReadPly(folder / "cloud.ply")[0].rgb, (std::array<std::uint8_t, 3>{10, 20, 30}));
}

TEST(PointCloudIo, FailedWriteLeavesTheOldFile) {
  const TemporaryDirectory folder;
  const auto points = RandomCloud(5000);
  EXPECT_THROW(WritePly(folder / "nowhere/cloud.ply", points), IoError);
  EXPECT_THROW(WritePcd(folder / "nowhere/cloud.pcd", points), IoError);
  WriteText(folder / "cloud.ply", "old");
  WriteText(folder / "cloud.pcd", "old");
  {
    const FileSizeLimit full(4096);
    EXPECT_THROW(WritePly(folder / "cloud.ply", points), IoError);
    EXPECT_THROW(WritePly(folder / "cloud.ply", points, PlyFormat::kAscii), IoError);
    EXPECT_THROW(WritePcd(folder / "cloud.pcd", points), IoError);
  }
  EXPECT_EQ(ReadText(folder / "cloud.ply"), "old");
  EXPECT_EQ(ReadText(folder / "cloud.pcd"), "old");
  EXPECT_EQ(folder.FileCount(), 2u) << "a temporary stayed behind";
}

}  // namespace
}  // namespace highwall::point_cloud_io_test
