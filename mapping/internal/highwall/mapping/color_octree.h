#pragma once

#include <filesystem>
#include <span>

#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

// Writes the octree as a ColorOcTree (.ot), which octovis shows in colour: each occupied voxel has
// the mean colour of the points [m] in W inside of it, white where there are none. The occupancy
// equals that of the map, including its log-odds. Throws IoError; the old file is then kept.
void WriteColorOctree(const std::filesystem::path& path, const OctomapBuilder& map,
                      std::span<const ColoredPoint> points_W);

}  // namespace highwall
