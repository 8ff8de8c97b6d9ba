#pragma once

#include <array>
#include <filesystem>

#include <opencv2/core/mat.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/mapping/dense_mapper.h>
#include <highwall/mapping/height_map.h>

namespace highwall::apps {

// Viewpoint of a map picture in parallel projection: from above, or from the side, elevated by 40
// degrees.
enum class MapView { kTop, kOblique };

// Returns a CV_8UC3 image of at most `size` pixels along an edge, with the camera path, if any, in
// red. An empty map gives an empty image. size: [px] > 0.
cv::Mat DrawCloud(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size);
// Draws occupied voxels as cubes, coloured by height: violet is low, yellow high (viridis).
cv::Mat DrawOctree(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size);
// Returns a CV_16UC1 image, one pixel per cell, first row at the largest y: 1 + millimetres above
// the lowest cell, 0 where unknown.
cv::Mat HeightImage(const HeightMap& heights);

// Writes a PNG file. Throws IoError and then leaves the old file in place.
void WritePng(const std::filesystem::path& path, const cv::Mat& image);

// Picture of a dense map and its file name (docs/mapping.md).
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

// Writes no file for an empty map. Throws IoError.
void WriteMapPicture(const std::filesystem::path& path, const MapPicture& picture,
                     const DenseMap& dense, const Trajectory& trajectory);

}  // namespace highwall::apps
