#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/camera.h>

namespace highwall {

// A depth image on a coarse grid of square cells, kCells along its longer side, free of distortion:
// what is compared between frames (moving_objects.h), at a hundredth of the image's size.
class DepthGrid {
 public:
  static constexpr int kCells = 80;

  // camera: of the depth images, with its distortion. Throws InvalidArgument if it is not valid.
  explicit DepthGrid(const PinholeCamera& camera);
  // Its columns and rows, without making it; throws alike.
  static cv::Size SizeFor(const PinholeCamera& camera);

  // Whose pixels are the cells, without distortion.
  const PinholeCamera& camera() const { return camera_; }
  // Edge of a cell [px].
  double cell_size() const { return cell_size_; }

  // Direction (x/z, y/z, 1) of the middle of a cell, and the cells that a point p_C [m], z > 0,
  // falls on, fractions included.
  const Eigen::Vector3f& Ray(const cv::Point& cell) const {
    return rays_[static_cast<std::size_t>(cell.y * camera_.width + cell.x)];
  }
  Eigen::Vector2f Project(const Eigen::Vector3f& p_C) const {
    return (scale_.cwiseProduct(p_C.head<2>()) / p_C.z() + centre_).eval();
  }

  // CV_32FC1 [m], a cell a pixel: the median of readings about the middle of the cell; 0 where most
  // are missing or beyond [min_depth, max_depth]. depth: CV_32FC1 of the camera's size, else throws
  // InvalidArgument.
  cv::Mat Sample(const cv::Mat& depth, double min_depth, double max_depth) const;

  // CV_8UC1, a cell a pixel: the mean of the square around the middle of the cell. gray: CV_8UC1 of
  // the camera's size, else throws InvalidArgument.
  cv::Mat Average(const cv::Mat& gray) const;

  // The cell of an undistorted pixel of the image; beyond the image, the nearest one.
  cv::Point CellOf(const Eigen::Vector2d& uv) const;
  // A mask of cells (CV_8UC1) as one of the image's pixels, distorted as they are.
  cv::Mat ToImage(const cv::Mat& cells) const;

 private:
  PinholeCamera image_camera_, camera_;
  double cell_size_;
  Eigen::Vector2f scale_, centre_;     // focal lengths and principal point [cells]
  std::vector<Eigen::Vector3f> rays_;  // of the cells, row by row
  std::vector<cv::Point> pixels_;      // of the image, at the middle of each cell
};

// The surfaces of a grid: neighbouring cells without a step between them.
struct DepthSurfaces {
  cv::Mat labels;          // CV_32SC1: which surface a cell is of; -1 where it has no depth
  std::vector<int> sizes;  // [cells]
};

// link: by which share of its depth a cell may differ from its neighbour on the same surface, > 0.
DepthSurfaces FindSurfaces(const cv::Mat& cells, double link);

}  // namespace highwall
