#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/camera.h>

namespace highwall {

// A depth image on a coarse grid of square cells, kColumns to a row, free of distortion: what is
// compared between frames (moving_objects.h), at a hundredth of the image's size.
class DepthGrid {
 public:
  static constexpr int kColumns = 80;

  // camera: of the depth images, with its distortion. Throws InvalidArgument if it is not valid.
  explicit DepthGrid(const PinholeCamera& camera);

  // Whose pixels are the cells, without distortion.
  const PinholeCamera& camera() const { return camera_; }
  // Edge of a cell [px].
  double cell_size() const { return cell_size_; }

  // CV_32FC1 [m], a cell a pixel: the median of readings about the middle of the cell; 0 where most
  // are missing or beyond [min_depth, max_depth]. depth: CV_32FC1 of the camera's size, else throws
  // InvalidArgument.
  cv::Mat Sample(const cv::Mat& depth, double min_depth, double max_depth) const;

  // The cell of an undistorted pixel of the image; beyond the image, the nearest one.
  cv::Point CellOf(const Eigen::Vector2d& uv) const;
  // A mask of cells (CV_8UC1) as one of the image's pixels, distorted as they are.
  cv::Mat ToImage(const cv::Mat& cells) const;

 private:
  PinholeCamera image_camera_, camera_;
  double cell_size_;
  std::vector<cv::Point> pixels_;  // of the image, at the middle of each cell; row by row
};

}  // namespace highwall
