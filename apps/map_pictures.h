#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/mapping/height_map.h>

#include "dense_map.h"

namespace highwall::apps {

// How a map is looked at, in parallel projection: from above, or from the side and 40 degrees
// above.
enum class MapView { kTop, kOblique };

// CV_8UC3, of at most `size` pixels along an edge; the path of the camera in red where there is
// one. An empty map gives an empty image. size: [px] > 0.
cv::Mat DrawCloud(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size);
// Occupied voxels as cubes, coloured by height: blue below, red above.
cv::Mat DrawOctree(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size);
// CV_16UC1, a pixel a cell, first row at the largest y: 1 + millimetres above the lowest cell,
// 0 where unknown.
cv::Mat HeightImage(const HeightMap& heights);

// PNG. Throws IoError; the old file then stays.
void WritePng(const std::filesystem::path& path, const cv::Mat& image);

// cloud_top.png, cloud.png, octree_top.png, octree.png (docs/mapping.md) of a map that is not
// empty.
void WriteMapPictures(const std::filesystem::path& directory, const DenseMap& dense,
                      const Trajectory& trajectory);

}  // namespace highwall::apps
