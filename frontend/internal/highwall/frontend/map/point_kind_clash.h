#pragma once

#include <optional>
#include <string>

#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/map/map.h>

namespace [[gnu::visibility("default")]] highwall {

// What the points of each are, in words that differ: "sift", or "orb in 8 levels of 1.2".
struct PointKindClash {
  std::string first, second;
};

// Why points of the two cannot be in one map: descriptors by another name, or levels of another
// pyramid, where both are known (Map::knows_point_kind). Empty where they can.
std::optional<PointKindClash> FindClash(const Map& first, const Map& second);
std::optional<PointKindClash> FindClash(const Map& first, const PointKind& second);

}  // namespace highwall
