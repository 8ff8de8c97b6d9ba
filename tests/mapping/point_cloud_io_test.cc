#include <highwall/mapping/point_cloud_io.h>

#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "temporary_folder.h"

namespace highwall {
namespace {

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
  const TemporaryFolder folder;
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
  const TemporaryFolder folder;
  const std::string properties =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  WritePly(folder / "a.ply", kOnePoint, PlyFormat::kAscii);
  EXPECT_EQ(ReadBytes(folder / "a.ply"),
            "ply\nformat ascii 1.0\n" + properties + "1 -2.5 0.1 1 2 255\n");
  WritePly(folder / "b.ply", kOnePoint);
  EXPECT_EQ(ReadBytes(folder / "b.ply"),
            "ply\nformat binary_little_endian 1.0\n" + properties +
                std::string("\x00\x00\x80\x3f\x00\x00\x20\xc0\xcd\xcc\xcc\x3d\x01\x02\xff", 15));
}

TEST(Pcd, BytesFollowTheFormat) {
  const TemporaryFolder folder;
  WritePcd(folder / "cloud.pcd", kOnePoint);
  EXPECT_EQ(
      ReadBytes(folder / "cloud.pcd"),
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
      "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 1\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA binary\n" +
          std::string("\x00\x00\x80\x3f\x00\x00\x20\xc0\xcd\xcc\xcc\x3d\xff\x02\x01\x00", 16));
}

TEST(Ply, EveryTruncationIsAnIoError) {
  const TemporaryFolder folder;
  for (const PlyFormat format : {PlyFormat::kBinaryLittleEndian, PlyFormat::kAscii}) {
    WritePly(folder / "cloud.ply", RandomCloud(3), format);
    const std::string bytes = ReadBytes(folder / "cloud.ply");
    // In text the last number may lose digits and stay a number: cut before it.
    for (std::size_t size = 0; size + 5 < bytes.size(); ++size) {
      WriteBytes(folder / "cut.ply", bytes.substr(0, size));
      EXPECT_THROW(ReadPly(folder / "cut.ply"), IoError) << size;
    }
  }
}

TEST(Ply, MalformedFilesAreIoErrors) {
  const TemporaryFolder folder;
  WritePly(folder / "good.ply", kOnePoint, PlyFormat::kAscii);
  const std::string good = ReadBytes(folder / "good.ply");
  const auto refuses = [&](const std::string& what, const std::string& by) {
    std::string bad = good;
    bad.replace(bad.find(what), what.size(), by);
    WriteBytes(folder / "bad.ply", bad);
    EXPECT_THROW(ReadPly(folder / "bad.ply"), IoError) << bad;
  };
  refuses("ply", "obj");
  refuses("format ascii", "format binary_big_endian");
  refuses("vertex 1", "vertex -1");
  refuses("vertex 1", "vertex 99999999999999999999999");
  refuses("vertex 1", "vertex ");
  refuses("float x", "double x");
  refuses("255", "256");
  refuses("-2.5", "two");
  refuses("255\n", "255 7\n");
  EXPECT_THROW(ReadPly(folder / "missing.ply"), IoError);
}

TEST(PointCloudIo, FailedWriteLeavesTheOldFile) {
  const TemporaryFolder folder;
  const auto points = RandomCloud(5000);
  EXPECT_THROW(WritePly(folder / "nowhere/cloud.ply", points), IoError);
  EXPECT_THROW(WritePcd(folder / "nowhere/cloud.pcd", points), IoError);
  WriteBytes(folder / "cloud.ply", "old");
  WriteBytes(folder / "cloud.pcd", "old");
  {
    const FileSizeLimit full(4096);
    EXPECT_THROW(WritePly(folder / "cloud.ply", points), IoError);
    EXPECT_THROW(WritePly(folder / "cloud.ply", points, PlyFormat::kAscii), IoError);
    EXPECT_THROW(WritePcd(folder / "cloud.pcd", points), IoError);
  }
  EXPECT_EQ(ReadBytes(folder / "cloud.ply"), "old");
  EXPECT_EQ(ReadBytes(folder / "cloud.pcd"), "old");
  EXPECT_EQ(folder.FileCount(), 2u) << "a temporary stayed behind";
}

}  // namespace
}  // namespace highwall
