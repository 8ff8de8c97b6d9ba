#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

namespace highwall::apps {

struct SceneLimits {
  std::size_t points = 250'000;
  std::size_t voxels = 60'000;
};

// Returns at most `limit` points, evenly distributed in space by filtering with increasing voxel
// sizes. limit: >= 1.
std::vector<ColoredPoint> ThinPoints(std::vector<ColoredPoint> points, std::size_t limit);

// Returns {"count", "of": before thinning, "low": [3], "step": [m], "positions": base64 of uint16 x
// y z in steps from low, "colours": base64 of uint8 r g b}.
nlohmann::json CloudJson(std::vector<ColoredPoint> points, std::size_t limit);

// Returns the occupied cells at the smallest size, or, if there are more than `limit`, at two, four
// times ... that size: {"count", "size": [m] edge, "resolution": [m] of the octree, "low": [3] the
// centre of the lowest cell, "cells": base64 of uint16 x y z in sizes from low}.
nlohmann::json OctreeJson(const OctomapBuilder& octree, std::size_t limit);

// Returns "cloud" and "octree" of the largest map of a run if its folder contains them; an empty
// object otherwise. Throws IoError for a damaged file.
nlohmann::json SceneJson(const std::filesystem::path& folder, std::size_t place,
                         const SceneLimits& limits);

}  // namespace highwall::apps
