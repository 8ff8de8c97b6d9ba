#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/camera.h>

namespace highwall {

// A depth image on a coarse grid of square cells, kCells along its longer side, without distortion,
// at a hundredth of the image's size: the representation in which frames are compared
// (dynamic_objects.h).
class DepthGrid {
 public:
  static constexpr int kCells = 80;

  // camera: of the depth images, with its distortion. Throws InvalidArgument if it is not valid.
  explicit DepthGrid(const PinholeCamera& camera);
  // Returns its columns and rows, without constructing it; throws likewise.
  static cv::Size SizeFor(const PinholeCamera& camera);

  // Camera whose pixels are the cells, without distortion.
  const PinholeCamera& camera() const { return camera_; }
  // Edge of a cell [px].
  double cell_size() const { return cell_size_; }

  // Direction (x/z, y/z, 1) of the centre of a cell, and the cell coordinates, with fractions, of a
  // point p_C [m], z > 0.
  const Eigen::Vector3f& Ray(const cv::Point& cell) const {
    return rays_[static_cast<std::size_t>(cell.y * camera_.width + cell.x)];
  }
  Eigen::Vector2f Project(const Eigen::Vector3f& p_C) const {
    return (scale_.cwiseProduct(p_C.head<2>()) / p_C.z() + centre_).eval();
  }

  // Returns CV_32FC1 [m], one pixel per cell: the median of readings around the centre of the cell;
  // 0 if most are missing or beyond [min_depth, max_depth]. depth: CV_32FC1 of the camera's size,
  // else throws InvalidArgument.
  cv::Mat Sample(const cv::Mat& depth, double min_depth, double max_depth) const;

  // Returns CV_8UC1, one pixel per cell: the mean of the square around the centre of the cell.
  // gray: CV_8UC1 of the camera's size, else throws InvalidArgument.
  cv::Mat Average(const cv::Mat& gray) const;

  // Returns the cell of an undistorted pixel of the image; outside of the image, the nearest one.
  cv::Point CellOf(const Eigen::Vector2d& uv) const;
  // Converts a mask of cells (CV_8UC1) to the pixels of the distorted image.
  cv::Mat ToImage(const cv::Mat& cells) const;

 private:
  std::span<const std::uint16_t> CellsOfDistortedPixels() const;

  PinholeCamera image_camera_, camera_;
  double cell_size_;
  Eigen::Vector2f scale_, centre_;     // focal lengths and principal point [cells]
  std::vector<Eigen::Vector3f> rays_;  // of the cells, row by row
  std::vector<cv::Point> pixels_;      // of the image, at the middle of each cell
  // Of each pixel of a distorted image, row by row, the index of its cell: inverting the distortion
  // takes longer than all else. Found when it is first needed, once for all copies.
  struct CellsOfPixels {
    std::once_flag found;
    std::vector<std::uint16_t> cells;
  };
  std::shared_ptr<CellsOfPixels> cells_of_pixels_ = std::make_shared<CellsOfPixels>();
};

// The connected surfaces of a grid: neighbouring cells without a depth step between them.
struct DepthSurfaces {
  cv::Mat labels;          // CV_32SC1: surface index of a cell; -1 without depth
  std::vector<int> sizes;  // [cells]
};

// link: > 0, maximum difference to a neighbour on the same surface as a share of the depth.
DepthSurfaces FindSurfaces(const cv::Mat& cells, double link);

}  // namespace highwall
