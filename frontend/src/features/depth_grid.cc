#include "features/depth_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall {

namespace {

double CellSize(const PinholeCamera& camera) {
  return static_cast<double>(std::max(camera.width, camera.height)) / DepthGrid::kCells;
}

}  // namespace

cv::Size DepthGrid::SizeFor(const PinholeCamera& camera) {
  camera.Validate();
  const double cell_size = CellSize(camera);
  return {std::max(1, static_cast<int>(camera.width / cell_size)),
          std::max(1, static_cast<int>(camera.height / cell_size))};
}

DepthGrid::DepthGrid(const PinholeCamera& camera)
    : image_camera_((camera.Validate(), camera)),
      camera_(camera.WithoutDistortion()),
      cell_size_(CellSize(camera)) {
  const cv::Size size = SizeFor(camera);
  camera_.width = size.width;
  camera_.height = size.height;
  camera_.fx /= cell_size_;
  camera_.fy /= cell_size_;
  camera_.cx = (camera.cx + 0.5) / cell_size_ - 0.5;
  camera_.cy = (camera.cy + 0.5) / cell_size_ - 0.5;
  scale_ = Eigen::Vector2d(camera_.fx, camera_.fy).cast<float>();
  centre_ = Eigen::Vector2d(camera_.cx, camera_.cy).cast<float>();
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      const Eigen::Vector3d ray = camera_.Unproject({u, v}, 1.0);
      rays_.push_back(ray.cast<float>());
      const Eigen::Vector2d uv = image_camera_.Project(ray);
      pixels_.emplace_back(static_cast<int>(std::lround(uv.x())),
                           static_cast<int>(std::lround(uv.y())));
    }
  }
}

cv::Mat DepthGrid::Sample(const cv::Mat& depth, double min_depth, double max_depth) const {
  HIGHWALL_REQUIRE(depth.type() == CV_32FC1 && depth.cols == image_camera_.width &&
                       depth.rows == image_camera_.height,
                   "DepthGrid::Sample: depth must be CV_32FC1 of the camera's size");
  const int off = std::max(1, static_cast<int>(0.3 * cell_size_));
  const std::array<cv::Point, 5> offsets{
      {{0, 0}, {-off, -off}, {off, -off}, {-off, off}, {off, off}}};
  const auto low = static_cast<float>(min_depth), high = static_cast<float>(max_depth);
  const cv::Rect image(0, 0, depth.cols, depth.rows);
  cv::Mat cells(camera_.height, camera_.width, CV_32FC1);
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    std::array<float, 5> readings{};
    std::ptrdiff_t valid = 0;
    for (const cv::Point& offset : offsets) {
      const cv::Point pixel = pixels_[i] + offset;
      if (!image.contains(pixel)) continue;
      const float z = depth.at<float>(pixel);
      if (z >= low && z <= high) readings[static_cast<std::size_t>(valid++)] = z;
    }
    float& cell = cells.ptr<float>()[i];
    cell = 0.0F;
    if (valid < 3) continue;
    std::nth_element(readings.begin(), readings.begin() + valid / 2, readings.begin() + valid);
    cell = readings[static_cast<std::size_t>(valid / 2)];
  }
  return cells;
}

cv::Mat DepthGrid::Average(const cv::Mat& gray) const {
  HIGHWALL_REQUIRE(gray.type() == CV_8UC1 && gray.cols == image_camera_.width &&
                       gray.rows == image_camera_.height,
                   "DepthGrid::Average: the image must be CV_8UC1 of the camera's size");
  const int half = std::max(1, static_cast<int>(0.5 * cell_size_));
  const cv::Rect image(0, 0, gray.cols, gray.rows);
  cv::Mat cells(camera_.height, camera_.width, CV_8UC1);
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    // Distortion may move a cell outside of the image: the nearest pixels are used instead.
    const cv::Point middle(std::clamp(pixels_[i].x, 0, gray.cols - 1),
                           std::clamp(pixels_[i].y, 0, gray.rows - 1));
    const cv::Rect square =
        cv::Rect(middle - cv::Point(half, half), cv::Size(2 * half, 2 * half)) & image;
    std::int64_t sum = 0;
    for (int v = square.y; v < square.y + square.height; ++v) {
      const std::uint8_t* row = gray.ptr<std::uint8_t>(v);
      sum = std::accumulate(row + square.x, row + square.x + square.width, sum);
    }
    const auto area = static_cast<std::int64_t>(square.area());
    cells.ptr<std::uint8_t>()[i] = static_cast<std::uint8_t>((sum + area / 2) / area);
  }
  return cells;
}

cv::Point DepthGrid::CellOf(const Eigen::Vector2d& uv) const {
  const auto index = [this](double pixel, int count) {
    return std::clamp(static_cast<int>(std::floor((pixel + 0.5) / cell_size_)), 0, count - 1);
  };
  return {index(uv.x(), camera_.width), index(uv.y(), camera_.height)};
}

std::span<const std::uint16_t> DepthGrid::CellsOfDistortedPixels() const {
  static_assert(kCells * kCells <= std::numeric_limits<std::uint16_t>::max());
  std::call_once(cells_of_pixels_->found, [this] {
    std::vector<std::uint16_t>& cells = cells_of_pixels_->cells;
    cells.reserve(static_cast<std::size_t>(image_camera_.width) *
                  static_cast<std::size_t>(image_camera_.height));
    for (int v = 0; v < image_camera_.height; ++v) {
      for (int u = 0; u < image_camera_.width; ++u) {
        const cv::Point cell = CellOf(image_camera_.UndistortPixel(Eigen::Vector2d(u, v)));
        cells.push_back(static_cast<std::uint16_t>(cell.y * camera_.width + cell.x));
      }
    }
  });
  return cells_of_pixels_->cells;
}

cv::Mat DepthGrid::ToImage(const cv::Mat& cells) const {
  HIGHWALL_REQUIRE(
      cells.type() == CV_8UC1 && cells.cols == camera_.width && cells.rows == camera_.height &&
          cells.isContinuous(),
      "DepthGrid::ToImage: the mask must be CV_8UC1, a cell a pixel, without gaps between rows");
  cv::Mat image = cv::Mat::zeros(image_camera_.height, image_camera_.width, CV_8UC1);
  if (cv::countNonZero(cells) == 0) return image;
  if (image_camera_.HasDistortion()) {
    std::ranges::transform(CellsOfDistortedPixels(), image.ptr<std::uint8_t>(),
                           [&](std::uint16_t cell) { return cells.ptr<std::uint8_t>()[cell]; });
    return image;
  }
  // Cells are in the same column for all pixels of a column.
  std::vector<int> columns;
  columns.reserve(static_cast<std::size_t>(image.cols));
  for (int u = 0; u < image.cols; ++u) columns.push_back(CellOf(Eigen::Vector2d(u, 0)).x);
  for (int v = 0; v < image.rows; ++v) {
    const auto* const row = cells.ptr<std::uint8_t>(CellOf(Eigen::Vector2d(0, v)).y);
    auto* const pixels = image.ptr<std::uint8_t>(v);
    for (int u = 0; u < image.cols; ++u) pixels[u] = row[columns[static_cast<std::size_t>(u)]];
  }
  return image;
}

DepthSurfaces FindSurfaces(const cv::Mat& cells, double link) {
  HIGHWALL_REQUIRE(cells.type() == CV_32FC1, "FindSurfaces: the grid must be CV_32FC1");
  const cv::Rect all(0, 0, cells.cols, cells.rows);
  DepthSurfaces surfaces{cv::Mat(cells.size(), CV_32SC1, cv::Scalar(-1)), {}};
  cv::Mat& labels = surfaces.labels;
  const auto is_free = [&](const cv::Point& cell) {
    return all.contains(cell) && cells.at<float>(cell) > 0.0F && labels.at<int>(cell) < 0;
  };
  std::vector<cv::Point> surface;
  surface.reserve(cells.total());
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) {
      if (!is_free({u, v})) continue;
      const int label = static_cast<int>(surfaces.sizes.size());
      surface.assign(1, {u, v});
      labels.at<int>(v, u) = label;
      for (std::size_t i = 0; i < surface.size(); ++i) {
        const float z = cells.at<float>(surface[i]);
        for (const cv::Point& step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          const cv::Point next = surface[i] + step;
          if (!is_free(next)) continue;
          if (std::abs(cells.at<float>(next) - z) > static_cast<float>(link) * z) continue;
          labels.at<int>(next) = label;
          surface.push_back(next);
        }
      }
      surfaces.sizes.push_back(static_cast<int>(surface.size()));
    }
  }
  return surfaces;
}

}  // namespace highwall
