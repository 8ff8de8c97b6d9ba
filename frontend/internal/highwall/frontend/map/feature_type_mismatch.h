#pragma once

#include <optional>
#include <string>

#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/map/map.h>

namespace [[gnu::visibility("default")]] highwall {

// Descriptions of the point kinds of both that differ: "sift", or "orb in 8 levels of 1.2".
struct FeatureTypeMismatch {
  std::string first, second;
};

// Returns why points of the two cannot be in one map: descriptors of a different name, or a
// different pyramid, if both are known (Map::knows_feature_type). Empty if they can.
std::optional<FeatureTypeMismatch> FindMismatch(const Map& first, const Map& second);
std::optional<FeatureTypeMismatch> FindMismatch(const Map& first, const FeatureType& second);

}  // namespace highwall
