#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include <highwall/mapping/dense_cloud.h>

// Point-cloud files. All writers go through a temporary file: a reader sees the whole new file or
// the whole old one. They throw IoError where the folder is missing or the disk is full.
namespace highwall {

enum class PlyFormat { kBinaryLittleEndian, kAscii };

// PLY 1.0, one element `vertex`: float x y z [m], uchar red green blue.
void WritePly(const std::filesystem::path& path, std::span<const ColoredPoint> points,
              PlyFormat format = PlyFormat::kBinaryLittleEndian);
// Reads what WritePly wrote, either format. Throws IoError if the file is missing, truncated or has
// other elements or properties.
std::vector<ColoredPoint> ReadPly(const std::filesystem::path& path);

// PCD 0.7, binary: fields x y z rgb, the colour packed as 0x00RRGGBB into the bits of a float as
// the Point Cloud Library does; unorganised (height 1).
void WritePcd(const std::filesystem::path& path, std::span<const ColoredPoint> points);

}  // namespace highwall
