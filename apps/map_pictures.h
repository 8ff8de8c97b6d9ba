#pragma once

#include <array>
#include <filesystem>

#include <opencv2/core/mat.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/mapping/dense_mapper.h>
#include <highwall/mapping/height_map.h>

namespace highwall::apps {

// How a map is looked at, in parallel projection: from above, or from the side and 40 degrees
// above.
enum class MapView { kTop, kOblique };

// CV_8UC3, of at most `size` pixels along an edge; the path of the camera in red where there is
// one. An empty map gives an empty image. size: [px] > 0.
cv::Mat DrawCloud(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size);
// Occupied voxels as cubes, coloured by height: violet below, yellow above
// (viridis).
cv::Mat DrawOctree(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size);
// CV_16UC1, a pixel a cell, first row at the largest y: 1 + millimetres above the lowest cell,
// 0 where unknown.
cv::Mat HeightImage(const HeightMap& heights);

// PNG. Throws IoError; the old file then stays.
void WritePng(const std::filesystem::path& path, const cv::Mat& image);

// What is drawn of a dense map, and the name of its file (docs/mapping.md).
struct MapPicture {
  const char* file;
  cv::Mat (*draw)(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size);
  MapView view;
};
inline constexpr std::array<MapPicture, 4> kMapPictures = {
    {{"cloud_top.png", DrawCloud, MapView::kTop},
     {"cloud.png", DrawCloud, MapView::kOblique},
     {"octree_top.png", DrawOctree, MapView::kTop},
     {"octree.png", DrawOctree, MapView::kOblique}}};

// No file of a map that is empty. Throws IoError.
void WriteMapPicture(const std::filesystem::path& path, const MapPicture& picture,
                     const DenseMap& dense, const Trajectory& trajectory);

}  // namespace highwall::apps
