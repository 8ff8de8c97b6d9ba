#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <Eigen/Core>

// Point-cloud files. All writers use a temporary file: a reader sees either the complete new file
// or the complete old one. They throw IoError if the folder is missing or the disk is full.

namespace [[gnu::visibility("default")]] highwall {

// Surface point with colour and normal.
struct ColoredPoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();       // [m]
  std::array<std::uint8_t, 3> rgb{255, 255, 255};    // white where there is no colour image
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, towards the sensor; 0 where unknown
};

// Encoding of a PLY file.
enum class PlyFormat { kBinaryLittleEndian, kAscii };

// Triangle mesh.
struct TriangleMesh {
  std::vector<ColoredPoint> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of vertices
};

// Writes PLY 1.0, one element `vertex`: float x y z [m], float nx ny nz if any point has a normal,
// uchar red green blue.
void WritePly(const std::filesystem::path& path, std::span<const ColoredPoint> points,
              PlyFormat format = PlyFormat::kBinaryLittleEndian);
// Reads the vertices of any PLY file, ASCII or binary little-endian: x y z, nx ny nz and red green
// blue (8 bits each, also as diffuse_red ...) are read where present, everything else is skipped.
// Throws IoError if the file is missing, truncated, malformed or has no x, y and z.
std::vector<ColoredPoint> ReadPly(const std::filesystem::path& path);
// Reads also the element `face`; polygons are split into triangles. A file without faces has no
// triangles. Throws IoError as above and if a face refers to a vertex that does not exist.
TriangleMesh ReadPlyMesh(const std::filesystem::path& path);

// Writes PCD 0.7, binary: fields x y z rgb, the colour packed as 0x00RRGGBB into the bits of a
// float as in the Point Cloud Library; unorganised (height 1).
void WritePcd(const std::filesystem::path& path, std::span<const ColoredPoint> points);
// Reads x y z and, if present, rgb of a PCD file, ASCII, binary or compressed (binary_compressed),
// with fields of 4 bytes and count 1. Throws IoError if the file is missing, truncated, damaged or
// of another form.
std::vector<ColoredPoint> ReadPcd(const std::filesystem::path& path);

}  // namespace highwall
