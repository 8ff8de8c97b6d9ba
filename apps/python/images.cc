#include "images.h"

#include <cstring>
#include <vector>

#include <highwall/core/error.h>

namespace highwall::python {
namespace {

cv::Mat CopyOf(const py::array& array, int type) {
  cv::Mat image(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type);
  std::memcpy(image.data, array.data(), static_cast<std::size_t>(array.nbytes()));
  return image;
}

}  // namespace

cv::Mat ColourImage(const ColourArray& bgr) {
  HIGHWALL_REQUIRE(bgr.ndim() == 3 && bgr.shape(2) == 3,
                   "a colour image is an array of height x width x 3");
  return CopyOf(bgr, CV_8UC3);
}

cv::Mat DepthImage(const DepthArray& depth) {
  HIGHWALL_REQUIRE(depth.ndim() == 2, "a depth image is an array of height x width, in metres");
  return CopyOf(depth, CV_32FC1);
}

cv::Mat MatrixOf(const py::array& array) {
  if (py::isinstance<py::array_t<float>>(array)) return CopyOf(array.cast<DepthArray>(), CV_32FC1);
  return CopyOf(array.cast<ColourArray>(), CV_8UC1);
}

py::array ImageArray(const cv::Mat& image) {
  std::vector<py::ssize_t> shape = {image.rows, image.cols};
  if (image.channels() > 1) shape.push_back(image.channels());
  const py::dtype type =
      image.depth() == CV_32F ? py::dtype::of<float>() : py::dtype::of<std::uint8_t>();
  py::array array(type, shape);
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  std::memcpy(array.mutable_data(), whole.data, whole.total() * whole.elemSize());
  return array;
}

}  // namespace highwall::python
