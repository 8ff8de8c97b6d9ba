#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "scan_octree.h"

namespace highwall::internal {

// An OctoMap file whose every byte has been accounted for: OctoMap itself reads past the end of a
// truncated stream, builds nodes from what it finds in memory and may recurse without bound.
struct OctreeFile {
  bool binary = false;  // .bt, else .ot
  std::size_t size = 0;
  double resolution = 0.0;  // [m]
  std::string payload;
};

// Throws IoError if the file is missing, truncated, too long or of another tree type.
OctreeFile LoadOctreeFile(const std::filesystem::path& path);
// Builds the nodes. tree: empty, with clamping thresholds set.
void ReadPayload(const OctreeFile& file, ScanOctree& tree);

// Both throw IoError; the old file then stays. The header is written here, since OctoMap's own
// writer prints to standard error and cuts the resolution to six digits.
void WriteTree(const std::filesystem::path& path, const ScanOctree& tree);
void WriteBinaryTree(const std::filesystem::path& path, const ScanOctree& tree);

}  // namespace highwall::internal
