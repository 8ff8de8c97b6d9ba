#include "input/colour_to_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace highwall {
namespace {

// An affine map of one coordinate: a u + b.
struct AxisMap {
  double a = 1.0, b = 0.0;
  double operator()(double u) const { return a * u + b; }
};

// Maps pixels of `to` to those of `from`.
AxisMap ColumnsOf(const PinholeCamera& to, const PinholeCamera& from) {
  return {from.fx / to.fx, from.cx - to.cx * from.fx / to.fx};
}
AxisMap RowsOf(const PinholeCamera& to, const PinholeCamera& from) {
  return {from.fy / to.fy, from.cy - to.cy * from.fy / to.fy};
}

// [px] the largest distance by which the map moves a pixel of an image of this length.
double LargestShift(const AxisMap& map, int length) {
  const double last = length - 1;
  return std::max(std::abs(map(0.0)), std::abs(map(last) - last));
}

// Returns the pixel that each pixel of the result is taken from; -1 outside.
std::vector<int> NearestPixels(const AxisMap& map, int count, int limit) {
  constexpr double kTie = 1e-6;  // [px] rounding must not decide between two equally near pixels
  std::vector<int> nearest(static_cast<std::size_t>(count), -1);
  for (int i = 0; i < count; ++i) {
    const double at = std::floor(map(i) + 0.5 + kTie);
    if (at >= 0.0 && at < limit) nearest[static_cast<std::size_t>(i)] = static_cast<int>(at);
  }
  return nearest;
}

template <class T>
void TakeNearest(const cv::Mat& depth, const std::vector<int>& columns,
                 const std::vector<int>& rows, cv::Mat* result) {
  for (int v = 0; v < result->rows; ++v) {
    const int row = rows[static_cast<std::size_t>(v)];
    if (row < 0) continue;
    const T* const from = depth.ptr<T>(row);
    T* const to = result->ptr<T>(v);
    for (int u = 0; u < result->cols; ++u) {
      const int column = columns[static_cast<std::size_t>(u)];
      if (column >= 0) to[u] = from[column];
    }
  }
}

}  // namespace

cv::Size FrameSize(const cv::Size& colour, const cv::Size& depth) {
  constexpr int kMost = 640 * 480;  // [px] of a frame: more costs time and adds little
  if (colour == depth) return colour;
  int n = 1;
  while ((colour.width / n) * (colour.height / n) > kMost) ++n;
  return {colour.width / n, colour.height / n};
}

PinholeCamera ResizedCamera(const PinholeCamera& camera, const cv::Size& size) {
  const double sx = static_cast<double>(size.width) / camera.width;
  const double sy = static_cast<double>(size.height) / camera.height;
  PinholeCamera resized = camera;  // its lens is stated for rays, at any size
  resized.width = size.width;
  resized.height = size.height;
  resized.fx = camera.fx * sx;
  resized.fy = camera.fy * sy;
  resized.cx = (camera.cx + 0.5) * sx - 0.5;
  resized.cy = (camera.cy + 0.5) * sy - 0.5;
  return resized;
}

cv::Mat ResampleColour(const cv::Mat& colour, const PinholeCamera& from, const PinholeCamera& to) {
  constexpr double kVisible = 0.05;  // [px]
  const cv::Size size(to.width, to.height);
  cv::Mat reduced = colour;
  if (colour.size() != size) cv::resize(colour, reduced, size, 0.0, 0.0, cv::INTER_AREA);
  const PinholeCamera camera = ResizedCamera(from, size);
  const AxisMap x = ColumnsOf(to, camera), y = RowsOf(to, camera);
  if (std::max(LargestShift(x, size.width), LargestShift(y, size.height)) <= kVisible) {
    return reduced;
  }
  cv::Mat moved;
  cv::warpAffine(reduced, moved, cv::Matx23d(x.a, 0.0, x.b, 0.0, y.a, y.b), size,
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  return moved;
}

cv::Mat ResampleDepth(const cv::Mat& depth, const PinholeCamera& from, const PinholeCamera& to) {
  const PinholeCamera camera = ResizedCamera(from, depth.size());
  const std::vector<int> columns = NearestPixels(ColumnsOf(to, camera), to.width, depth.cols);
  const std::vector<int> rows = NearestPixels(RowsOf(to, camera), to.height, depth.rows);
  cv::Mat result = cv::Mat::zeros(to.height, to.width, depth.type());
  if (depth.type() == CV_16UC1) {
    TakeNearest<std::uint16_t>(depth, columns, rows, &result);
  } else {
    TakeNearest<float>(depth, columns, rows, &result);
  }
  return result;
}

}  // namespace highwall
