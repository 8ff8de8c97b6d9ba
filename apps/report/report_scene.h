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

// At most `limit` points, evenly over space: those of larger and larger voxels. limit: >= 1.
std::vector<ColoredPoint> ThinPoints(std::vector<ColoredPoint> points, std::size_t limit);

// {"count", "of": before thinning, "low": [3], "step": [m], "positions": base64 of uint16 x y z in
// steps from low, "colours": base64 of uint8 r g b}.
nlohmann::json CloudJson(std::vector<ColoredPoint> points, std::size_t limit);

// The occupied cells, those of the smallest size or, where they are more than `limit`, of twice,
// four times ... that: {"count", "size": [m] edge, "resolution": [m] of the octree, "low": [3] the
// centre of the lowest cell, "cells": base64 of uint16 x y z in sizes from low}.
nlohmann::json OctreeJson(const OctomapBuilder& octree, std::size_t limit);

// "cloud" and "octree" of the largest map of a run, as far as its folder has them; an empty object
// otherwise. Throws IoError for a file that is damaged.
nlohmann::json SceneJson(const std::filesystem::path& folder, const SceneLimits& limits);

}  // namespace highwall::apps
