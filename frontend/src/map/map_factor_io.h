#pragma once

#include <cstdint>
#include <map>
#include <unordered_map>

#include <highwall/frontend/map/map.h>

#include "map/map_archive.h"

// User factors in map files: positions with their reference frames, and motions between two poses.
namespace highwall {

// Returns whether it is a PositionFactor or a RelativePose without a loss or with ceres::HuberLoss:
// the file cannot contain the code of any other.
bool CanWrite(const MapFactor& factor);

// Returns whether the map has motions for which CanWrite() holds; files without them have no part
// for motions.
bool HasMotions(const Map& map);

// Writes the factors for which CanWrite() holds. submaps, keyframes: their indices in the file.
void WriteFactors(MapWriter& writer, const Map& map,
                  const std::map<SubmapId, std::int32_t>& submaps,
                  const std::unordered_map<KeyFrameId, std::int32_t>& keyframes);

// Reads the factors into a map that has its `submaps` submaps and its keyframes. has_motions:
// whether the file has a part for motions. Throws IoError, and InvalidArgument if a factor rejects
// its values.
void ReadFactors(MapReader& reader, std::uint32_t submaps, bool has_motions, Map* map);

}  // namespace highwall
