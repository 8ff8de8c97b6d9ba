#pragma once

#include <cstdint>
#include <map>
#include <unordered_map>

#include <highwall/frontend/map/map.h>

#include "map/map_archive.h"

// User factors in map files: those of positions, and their reference frames.
namespace highwall {

// Returns whether it is a PositionFactor without a loss or with ceres::HuberLoss: the file cannot
// contain the code of any other.
bool CanWrite(const MapFactor& factor);

// Writes the factors for which CanWrite() holds. submaps, keyframes: their indices in the file.
void WriteFactors(MapWriter& writer, const Map& map,
                  const std::map<SubmapId, std::int32_t>& submaps,
                  const std::unordered_map<KeyFrameId, std::int32_t>& keyframes);

// Reads the factors into a map that has its `submaps` submaps and its keyframes. Throws IoError,
// and InvalidArgument if a factor rejects its values.
void ReadFactors(MapReader& reader, std::uint32_t submaps, Map* map);

}  // namespace highwall
