#pragma once

#include <filesystem>
#include <span>

#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

// Writes the octree as a ColorOcTree (.ot), as octovis shows in colour: each occupied voxel has the
// mean colour of the points [m] in W inside of it, white where there are none. Space is that of the
// map, to its log-odds. Throws IoError; the old file then stays.
void WriteColorOctree(const std::filesystem::path& path, const OctomapBuilder& map,
                      std::span<const ColoredPoint> points_W);

}  // namespace highwall
