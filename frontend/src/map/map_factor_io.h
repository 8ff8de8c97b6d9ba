#pragma once

#include <cstdint>
#include <map>
#include <unordered_map>

#include <highwall/frontend/map/map.h>

#include "map/map_archive.h"

// Factors of the user's in map files: those of positions, and the frames they are measured in.
namespace highwall {

// A PositionFactor without a loss or with ceres::HuberLoss: of any other the file would have to
// know its code.
bool CanWrite(const MapFactor& factor);

// Those that can be written. submaps, keyframes: their places in the file.
void WriteFactors(MapWriter& writer, const Map& map,
                  const std::map<SubmapId, std::int32_t>& submaps,
                  const std::unordered_map<KeyFrameId, std::int32_t>& keyframes);

// Of a map that has its `submaps` submaps and its keyframes. Throws IoError, and InvalidArgument
// where a factor refuses its numbers.
void ReadFactors(MapReader& reader, std::uint32_t submaps, Map* map);

}  // namespace highwall
