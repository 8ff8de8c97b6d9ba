#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "scan_octree.h"

namespace highwall::internal {

// OctoMap file whose bytes have all been checked: OctoMap itself reads past the end of a truncated
// stream, builds nodes from arbitrary memory and may recurse without bound.
struct OctreeFile {
  bool binary = false;  // .bt if true, otherwise .ot
  std::size_t size = 0;
  double resolution = 0.0;  // [m]
  std::string payload;
};

// Throws IoError if the file is missing, truncated, too long or of another tree type.
OctreeFile LoadOctreeFile(const std::filesystem::path& path);
// Builds the nodes of the tree. tree: empty, with clamping thresholds set.
void ReadPayload(const OctreeFile& file, ScanOctree& tree);

// Both throw IoError; the old file is then kept. The header is written here, since OctoMap's own
// writer prints to standard error and truncates the resolution to six digits.
void WriteTree(const std::filesystem::path& path, const ScanOctree& tree);
void WriteBinaryTree(const std::filesystem::path& path, const ScanOctree& tree);

}  // namespace highwall::internal
